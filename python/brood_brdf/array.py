"""Arrays of directions, texture positions and random numbers: checks of shapes, without copies."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Floats", "matched", "rows"]

Floats = npt.NDArray[np.float32] | npt.NDArray[np.float64]
"""Array of numbers of 32 or 64 bits."""


def rows(name: str, value: npt.ArrayLike, columns: int) -> Floats:
    """Returns an array of rows; copies only what is not C-contiguous or of another number type.

    Args:
        name: Name of the argument, for errors.
        value: Array of shape (N, columns), or (columns,) for one row that all samples share.
        columns: Numbers of a row.
    """
    array: npt.NDArray[Any] = np.asarray(value)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"`{name}` must be an array of real numbers, got dtype {array.dtype}")
    if array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float64)
    if array.shape == (columns,):
        array = array.reshape(1, columns)
    if array.ndim != 2 or array.shape[1] != columns:
        wanted = f"(N, {columns}) or ({columns},)"
        raise ValueError(f"`{name}` must have the shape {wanted}, got {np.shape(value)}")
    aligned: Floats = np.require(array, array.dtype.newbyteorder("="), ["C", "ALIGNED"])
    return aligned


def matched(**arrays: Floats | None) -> int:
    """Returns the number of rows of arrays, each of which has that many or one.

    Args:
        arrays: Arrays by the names of their arguments; None are left out.
    """
    counts = {name: len(array) for name, array in arrays.items() if array is not None}
    count = next((each for each in counts.values() if each != 1), 1)
    for name, each in counts.items():
        if each not in (1, count):
            shown = ", ".join(f"`{name}` {each}" for name, each in counts.items())
            raise ValueError(f"`{name}` must have 1 or {count} rows; the arrays have: {shown}")
    return count
