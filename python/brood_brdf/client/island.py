"""Islands of a search."""

from __future__ import annotations

from dataclasses import dataclass

from .record import Record

__all__ = ["Island"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Island(Record):
    """One of several islands of a search.

    Attributes:
        island: Number of the island, from 0.
        state: State of the island; `succeeded` if its budget is used up or the target error is
            reached.
        generation: Number of generations so far.
        evaluations: Number of evaluated candidates so far.
        seconds: Search time in seconds, without waiting for other islands.
        fitted: E_log of its best candidate on the samples it is fitted to.
        held: E_log of its best candidate on the validation samples.
    """

    island: int
    state: str
    generation: int
    evaluations: int
    seconds: float
    fitted: float | None = None
    held: float | None = None
