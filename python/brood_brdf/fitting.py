"""Fits: searches for a material that matches measured values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy.typing as npt

from . import _native
from .array import matched, rows
from .brood import Brood
from .material import Material

__all__ = ["Fit", "FitProgress", "Found", "Target", "fit"]

# Budget in seconds if none is given.
_SECONDS = 10.0


class Target:
    """Measured material that `fit` matches.

    Attributes:
        fitted: Number of samples that fits use.
        held_out: Number of samples that errors are measured on.
        skipped: Number of samples that were left out because they are below the surface.
    """

    __slots__ = ("_native", "fitted", "held_out", "skipped")

    fitted: int
    held_out: int
    skipped: int

    def __init__(self, wi: npt.ArrayLike, wo: npt.ArrayLike, f: npt.ArrayLike) -> None:
        """Makes a target of samples. Every fifth one is held out.

        Args:
            wi: Directions to the light, shape (N, 3) or (3,).
            wo: Directions to the eye, shape (N, 3) or (3,).
            f: Linear red, green and blue in 1/sr, without the cosine, shape (N, 3). Values below 0
                become 0.

        Raises:
            ValueError: If there are fewer than 100 samples or more than 262,144, all are black, or
                a value is not finite.
        """
        wi, wo, f = rows("wi", wi, 3), rows("wo", wo, 3), rows("f", f, 3)
        matched(wi=wi, wo=wo, f=f)
        self._set(_native.NativeTarget.of_samples(wi, wo, f))

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Target:
        """Reads a measurement.

        Args:
            path: MERL `.binary`, RGL `.bsdf`, samples as `.csv`, a goniometer's `.brdf`, or an
                image slice as `.exr`.
        """
        path = Path(path)
        new = cls.__new__(cls)
        extension = path.suffix.lower().removeprefix(".")
        new._set(_native.NativeTarget.of_file(extension, path.read_bytes()))
        return new

    def _set(self, native: _native.NativeTarget) -> None:
        self._native = native
        self.fitted, self.held_out, self.skipped = native.counts

    def __repr__(self) -> str:
        """Returns the numbers of samples."""
        return f"<Target of {self.fitted} fitted and {self.held_out} held-out samples>"


class FitProgress(NamedTuple):
    """State of a search after a generation.

    Attributes:
        generation: Number of generations so far.
        evaluations: Number of evaluations of a material on the samples.
        training_error: E_log of the best material on the training samples.
        validation_error: E_log of the best material on the validation samples.
    """

    generation: int
    evaluations: int
    training_error: float
    validation_error: float


class Found(NamedTuple):
    """Material that a search found, under the energy limit.

    Attributes:
        material: The material.
        operations: Number of scalar operations per sample.
        parameters: Number of fitted parameters.
        fitted_error: E_log on the samples that were fitted: the root mean square difference of
            ln(1 + f cos_i).
        error: E_log on the held-out samples.
        cubic_error: The same with cube roots instead of logarithms.
        relative_error: Relative L2 error of f cos_i on the held-out samples.
        divisor: Divisor of f by the energy limit; 1 if the material is within it.
    """

    material: Material
    operations: int
    parameters: int
    fitted_error: float
    error: float
    cubic_error: float
    relative_error: float
    divisor: float

    def _repr_png_(self) -> bytes:
        """Returns a picture for a notebook."""
        return self.material._repr_png_()


class Fit:
    """Result of `fit`: an iterable over the front.

    Attributes:
        best: Material of least error.
        front: From the longest to the shortest material: each has a smaller error than all shorter
            ones, or is the best.
        progress: State of the search at its end.
    """

    __slots__ = ("best", "front", "progress")

    best: Found
    front: list[Found]
    progress: FitProgress

    def __init__(self, front: list[Found], best: Found, progress: FitProgress) -> None:
        """Makes a result.

        Args:
            front: The front.
            best: Member of the front of least error.
            progress: State of the search at its end.
        """
        self.front = front
        self.best = best
        self.progress = progress

    def __iter__(self) -> Iterator[Found]:
        """Returns an iterator over the front."""
        return iter(self.front)

    def __len__(self) -> int:
        """Returns the length of the front."""
        return len(self.front)

    def __repr__(self) -> str:
        """Returns the least error and the length of the front."""
        return f"<Fit: error {self.best.error:.5f}, front of {len(self)}>"

    def _repr_png_(self) -> bytes | None:
        """Returns the sheet of the front for a notebook."""
        return Brood([found.material for found in self.front])._repr_png_()


def fit(
    target: Target | str | PathLike[str],
    *,
    strategy: str = "hybrid",
    objective: str | None = None,
    generations: int | None = None,
    seconds: float | None = None,
    seed: int = 1,
    start: Iterable[Material] = (),
    models: Iterable[str] = (),
    mirrored: bool = False,
    threads: int | None = None,
    progress: Callable[[FitProgress], object] | None = None,
) -> Fit:
    """Searches for materials that match a target. They are reciprocal and energy-limited.

    Ctrl-C ends the search with `KeyboardInterrupt` after the current generation.

    Args:
        target: Target, or the path of a measurement (`Target.read`).
        strategy: `lobes`, `analytic`, `gp` or `hybrid`.
        objective: What lobes minimise: `seen`, the default of `lobes` and `hybrid`, is E_log with
            differences of dark values added; `e_log` is E_log alone.
        generations: Budget as a number of generations: gives the same result on every machine.
        seconds: Budget in seconds, the final steps included; 10 if there is no budget.
        seed: Seed, 0 to 2^64 - 1.
        start: Materials to start from; ignored by `lobes`.
        models: Models for the strategy `analytic`; by default all reciprocal ones.
        mirrored: True to treat the material as its own mirror image.
        threads: Number of threads.
        progress: Function that is called after each generation.

    Raises:
        ValueError: If an argument is out of range.
    """
    if not isinstance(target, Target):
        target = Target.read(target)
    if generations is not None and not 1 <= generations <= 100_000:
        raise ValueError(f"`generations` must be 1 to 100000, got {generations}")
    if generations is None and seconds is None:
        seconds = _SECONDS
    if seconds is not None and not 0 < seconds <= 1e6:
        raise ValueError(f"`seconds` must be above 0 and at most 1000000, got {seconds}")
    options: _native.FitOptions = {
        "strategy": strategy,
        "objective": objective,
        "seed": seed,
        "mirrored": mirrored,
        "models": list(models),
        "generations": generations,
        "seconds": seconds,
        "threads": threads,
    }
    report = None if progress is None else _reporter(progress)
    started = [material._native for material in start]
    front, best, done = _native.fit(target._native, started, options, report)
    found = [
        Found(Material._of(native), operations, parameters, *errors, divisor)
        for native, operations, parameters, errors, divisor in front
    ]
    return Fit(found, found[best], FitProgress(*done))


def _reporter(
    progress: Callable[[FitProgress], object],
) -> Callable[[tuple[int, int, float, float]], object]:
    return lambda row: progress(FitProgress(*row))
