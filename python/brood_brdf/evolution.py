"""Ask and tell: a genetic search whose errors are measured by you, as in pycma."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from . import _native
from .brood import Brood
from .material import Material

__all__ = ["Evaluated", "Evolution", "EvolutionResult"]


class Evaluated(NamedTuple):
    """Material with its error.

    Attributes:
        material: The material.
        error: Error that was passed to `Evolution.tell`.
        operations: Number of scalar operations per sample.
    """

    material: Material
    error: float
    operations: int


class EvolutionResult(NamedTuple):
    """Result of an `Evolution`; the names are pycma's.

    Attributes:
        xbest: Best material; None while none has a finite error.
        fbest: Its error; infinite while there is none.
        evaluations: Number of errors that were passed.
        iterations: Number of generations.
    """

    xbest: Material | None
    fbest: float
    evaluations: int
    iterations: int


class Evolution:
    """Genetic search with the interface of `cma.CMAEvolutionStrategy`.

        es = Evolution(seed=1)
        while not es.stop(iterations=50):
            materials = es.ask()
            es.tell(materials, [error_of(material) for material in materials])
        print(es.result.xbest.text())

    Equal seeds and errors give equal materials.
    """

    __slots__ = ("_asked", "_native")

    def __init__(
        self,
        start: Material | Iterable[Material] = (),
        *,
        seed: int = 1,
        count: int = 20,
        kept: int = 64,
        checkpoint: bytes | None = None,
    ) -> None:
        """Starts a search, or resumes one.

        Args:
            start: Materials of one dialect to start from, at most `count`; by default the search
                starts from random ones.
            seed: Seed, 0 to 2^64 - 1.
            count: Number of materials per generation, 1 to 4096.
            kept: Number of materials kept to breed from, 2 to 4096.
            checkpoint: Bytes of `checkpoint` of a search with the same other arguments.
        """
        start = (start,) if isinstance(start, Material) else tuple(start)
        natives = [material._native for material in start]
        self._native = _native.NativeEvolution(natives, seed, count, kept, checkpoint)
        self._asked: Brood | None = None

    def ask(self) -> Brood:
        """Returns the materials of the current generation, the same until `tell`."""
        if self._asked is None:
            self._asked = Brood(map(Material._of, self._native.ask()))
        return self._asked

    def tell(self, solutions: Sequence[Material], function_values: Iterable[float]) -> None:
        """Takes the errors of the current generation, and breeds the next one.

        Args:
            solutions: The materials of `ask`, in any order.
            function_values: Error of each material; smaller is better. Infinity discards it.

        Raises:
            ValueError: If the materials are not those of `ask`, or an error is NaN.
        """
        errors = [float(value) for value in function_values]
        if len(errors) != len(solutions):
            raise ValueError(f"got {len(solutions)} materials and {len(errors)} errors")
        asked = self.ask()
        if len(solutions) != len(asked):
            raise ValueError(f"`solutions` must be the {len(asked)} materials of `ask`")
        places: dict[Material, list[int]] = {}
        for place, material in enumerate(asked):
            places.setdefault(material, []).append(place)
        ordered = [math.inf] * len(asked)
        for material, error in zip(solutions, errors, strict=True):
            free = places.get(material)
            if not free:
                raise ValueError(f"{material!r} is not one of the materials of `ask`")
            ordered[free.pop(0)] = error
        self._native.tell(ordered)
        self._asked = None

    def stop(
        self,
        *,
        iterations: int | None = None,
        evaluations: int | None = None,
        error: float | None = None,
    ) -> dict[str, float]:
        """Returns the conditions that hold, with their limits; empty to continue.

        Args:
            iterations: Largest number of generations.
            evaluations: Largest number of errors.
            error: Error that is small enough.
        """
        result = self.result
        holds: dict[str, float] = {}
        if iterations is not None and result.iterations >= iterations:
            holds["iterations"] = iterations
        if evaluations is not None and result.evaluations >= evaluations:
            holds["evaluations"] = evaluations
        if error is not None and result.fbest <= error:
            holds["error"] = error
        return holds

    def optimize(
        self,
        objective_function: Callable[[Material], float],
        *,
        iterations: int | None = None,
        evaluations: int | None = None,
        error: float | None = None,
    ) -> Evolution:
        """Asks, evaluates and tells until a condition of `stop` holds; returns itself.

        Args:
            objective_function: Error of a material.
            iterations: Largest number of generations.
            evaluations: Largest number of errors.
            error: Error that is small enough.
        """
        if iterations is None and evaluations is None and error is None:
            raise ValueError("`optimize` needs `iterations`, `evaluations` or `error`")
        while not self.stop(iterations=iterations, evaluations=evaluations, error=error):
            materials = self.ask()
            self.tell(materials, [objective_function(material) for material in materials])
        return self

    @property
    def result(self) -> EvolutionResult:
        """Best material so far, and the numbers of evaluations and generations."""
        iterations, evaluations = self._native.counts
        best = self.best
        if best is None:
            return EvolutionResult(None, math.inf, evaluations, iterations)
        return EvolutionResult(best.material, best.error, evaluations, iterations)

    @property
    def best(self) -> Evaluated | None:
        """Best material; None while none has a finite error."""
        best = self._native.best
        return None if best is None else _evaluated(best)

    @property
    def front(self) -> list[Evaluated]:
        """From the shortest material to the longest; each has a smaller error than shorter ones."""
        return [_evaluated(row) for row in self._native.front]

    @property
    def diversity(self) -> float:
        """Share of distinct structures among the materials that are kept, 0 to 1."""
        return self._native.probe[1]

    def checkpoint(self) -> bytes:
        """Returns the state of the search, to resume it after the last `tell`."""
        return self._native.checkpoint()

    def __repr__(self) -> str:
        """Returns the number of generations and the least error."""
        result = self.result
        return f"<Evolution: {result.iterations} generations, least error {result.fbest:.6g}>"

    def _repr_png_(self) -> bytes | None:
        """Returns the sheet of the current generation for a notebook."""
        return self.ask()._repr_png_()


def _evaluated(row: tuple[_native.NativeMaterial, float, int]) -> Evaluated:
    native, error, operations = row
    return Evaluated(Material._of(native), error, operations)
