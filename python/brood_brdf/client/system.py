"""State of the server: version, backend, workers, limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import httpx

from .call import Call, Sender
from .record import Record, record_of

__all__ = ["System"]


def system() -> Call[System]:
    """Returns version, backend in use and why, workers, and limits."""
    return Call("GET", "/v1/system", record_of(System))


def ready() -> Call[bool]:
    """Returns true if the server can read and write its data and is not stopping.

    Raises:
        TooBusy: If it is not, after all attempts.
    """

    def read(answer: httpx.Response, _: Sender | None) -> bool:
        return answer.text.strip() == "ready"

    return Call("GET", "/readyz", read)


@dataclass(frozen=True, slots=True, kw_only=True)
class System(Record):
    """State of the server.

    Attributes:
        version: Version of the server.
        renderer_version: Version of the renderer; pictures of other versions may differ.
        database: Engine of the database with its version, such as "SQLite 3.51.3".
        workers: Names of the workers that were active in the last minute.
        limits: Limits by name; the last word of a name is its unit.
        backend: Evaluator of the worker that reported last: `name`, `adapter`, `exact`, `reason`.
    """

    version: str
    renderer_version: int
    database: str
    workers: tuple[str, ...]
    limits: Mapping[str, int] = field(hash=False, repr=False)
    backend: Mapping[str, Any] | None = field(default=None, hash=False)
