"""Jobs other than searches and exports: renders of a brood, and deferred answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .record import Record

__all__ = ["DeferredAnswer", "RenderJob"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RenderJob(Record):
    """Job that renders the pictures of a brood.

    Attributes:
        id: Id of the job.
        state: `queued`, `running`, `succeeded` or `failed`.
        reason: Reason of a failure.
        times: Durations in microseconds, once it has succeeded.
        work: Counters, once it has succeeded.
    """

    id: str
    state: str
    reason: str | None = None
    times: Mapping[str, int] | None = field(default=None, hash=False)
    work: Mapping[str, int] | None = field(default=None, hash=False, repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class DeferredAnswer(Record):
    """Answer to a request with `Prefer: respond-async` that was not ready in time.

    Attributes:
        id: Id of the job.
        state: `running`, `succeeded`, `failed` or `cancelled`.
        progress: Share of its pictures or children that are made, 0 to 1.
        method: Method of the request.
        request: Path and query of the request.
        created_ms: Time of the request, in milliseconds since 1970-01-01 UTC.
        status: Status of the answer, once it is ready.
        answer: Path of the answer, once it is ready; `Client.request` reads it.
        reason: Reason of a failure.
        ended_ms: Time of the end.
        expires_ms: Time at which the answer is deleted.
    """

    id: str
    state: str
    progress: float
    method: str
    request: str
    created_ms: int
    status: int | None = None
    answer: str | None = None
    reason: str | None = None
    ended_ms: int | None = None
    expires_ms: int | None = None
