"""Exports of several materials as one ZIP file: at once, or as a job with progress."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from .call import Call, Flow, Ref, Requester, given, id_of, path_of
from .error import ExportFailed
from .genome import Size, size_text
from .progress import Progress
from .record import Method, Record, read_bytes, record_of
from .retry import Pause, Steps

__all__ = ["ExportJob"]

ENDED = frozenset({"succeeded", "failed", "cancelled"})
"""States of exports that have ended."""


def _of(
    individuals: Iterable[Ref] | None, generation: Ref | None, search: Ref | None
) -> dict[str, Any]:
    """Returns what is exported, by the names of the server."""
    return given(
        individuals=None if individuals is None else list(map(id_of, individuals)),
        generation=None if generation is None else id_of(generation),
        job=None if search is None else id_of(search),
    )


def export_zip(
    individuals: Iterable[Ref] | None = None,
    formats: Iterable[str] | None = None,
    *,
    generation: Ref | None = None,
    search: Ref | None = None,
    size: Size | None = None,
    energy_limit: bool | None = None,
) -> Call[bytes]:
    """Returns a ZIP file of individuals, of a whole brood or of a search's front.

    Its last entry `manifest.json` has the errors of tables, the errors and costs of a search's
    results, and what was left out. Exactly one of individuals, generation and search is given.

    Args:
        individuals: At most 256 individuals.
        formats: `brood`, `png`, `exr` and names of `export_formats`; by default `brood`, `png`. At
            most 16 files may be binary tables; `export_archive` makes more.
        generation: Generation whose children are exported.
        search: Search whose front is exported.
        size: Side of the pictures in pixels, or width and height; by default 256.
        energy_limit: True to apply the energy limit; by default true for formats of path tracers,
            as in the genome for others.
    """
    of = _of(individuals, generation, search)
    query = given(
        **{name: ",".join(of[name]) if name == "individuals" else of[name] for name in of},
        formats=None if formats is None else ",".join(formats),
        size=size_text(size),
        energy_limit=energy_limit,
    )
    return Call("GET", "/v1/exports.zip", read_bytes, query=query)


def start_export(
    individuals: Iterable[Ref] | None = None,
    formats: Iterable[str] = ("brood",),
    *,
    generation: Ref | None = None,
    search: Ref | None = None,
    size: Size | None = None,
    energy_limit: bool | None = None,
) -> Call[ExportJob]:
    """Starts a job that makes a ZIP file as of `export_zip`, with up to 256 binary tables.

    Args:
        individuals: At most 256 individuals.
        formats: `brood`, `png`, `exr` and names of `export_formats`; not pictures alone.
        generation: Generation whose children are exported.
        search: Search whose front is exported.
        size: Side of the pictures in pixels, or width and height; by default 256.
        energy_limit: True to apply the energy limit; by default true for formats of path tracers,
            as in the genome for others.
    """
    body = given(
        **_of(individuals, generation, search),
        formats=list(formats),
        size=_side(size),
        energy_limit=energy_limit,
    )
    return Call("POST", "/v1/exports", record_of(ExportJob), json=body)


def _side(size: Size | None) -> int | list[int] | None:
    """Returns a size as JSON: a side, or width and height."""
    if size is None or isinstance(size, int):
        return size
    sides = size.split("x") if isinstance(size, str) else size
    width, *height = map(int, sides)
    return [width, *height] if height else width


def export_job(export: Ref) -> Call[ExportJob]:
    """Returns a job that makes a ZIP file, read anew."""
    return Call("GET", path_of("jobs", id_of(export)), record_of(ExportJob))


def cancel_export(export: Ref) -> Call[ExportJob]:
    """Cancels a job and deletes its files; fails with `Conflict` if it has ended."""
    return Call("POST", path_of("jobs", id_of(export), "cancel"), record_of(ExportJob))


def export_file(export: Ref) -> Call[bytes]:
    """Returns the ZIP file of a job; fails with `Conflict` unless it has succeeded."""
    return Call("GET", path_of("jobs", id_of(export), "archive.zip"), read_bytes)


@dataclass(frozen=True, slots=True)
class Archive(Flow[bytes]):
    """Job that makes a ZIP file, its wait, and the file."""

    begin: Call[ExportJob]
    poll_s: float
    timeout_s: float | None
    progress: bool

    def steps(self, client: Requester) -> Steps[bytes]:
        """Returns the steps to the file."""
        begun_s = client.clock_s()
        now = yield from self.begin.steps(client)
        with Progress("export", self.progress) as bar:
            while True:
                bar.show(now.progress, f"{now.made} of {now.files} files")
                if now.state in ENDED:
                    break
                waited_s = client.clock_s() - begun_s
                if self.timeout_s is not None and waited_s + self.poll_s > self.timeout_s:
                    raise TimeoutError(f"export {now.id} is {now.state} after {waited_s:.0f} s")
                yield Pause(self.poll_s)
                now = yield from export_job(now).steps(client)
        if now.state != "succeeded":
            raise ExportFailed(f"export {now.id} is {now.state}: {now.reason}")
        return (yield from export_file(now).steps(client))


def export_archive(
    individuals: Iterable[Ref] | None = None,
    formats: Iterable[str] = ("brood",),
    *,
    generation: Ref | None = None,
    search: Ref | None = None,
    size: Size | None = None,
    energy_limit: bool | None = None,
    poll_s: float = 1.0,
    timeout_s: float | None = None,
    progress: bool = False,
) -> Archive:
    """Makes a ZIP file by a job, waits for it, and returns it.

    Args:
        individuals: At most 256 individuals.
        formats: `brood`, `png`, `exr` and names of `export_formats`; not pictures alone.
        generation: Generation whose children are exported.
        search: Search whose front is exported.
        size: Side of the pictures in pixels, or width and height; by default 256.
        energy_limit: True to apply the energy limit; by default true for formats of path tracers,
            as in the genome for others.
        poll_s: Seconds between looks.
        timeout_s: Most seconds to wait; by default any number.
        progress: True to show a progress bar by tqdm.

    Raises:
        ExportFailed: If the job fails or is cancelled.
        TimeoutError: If it has not ended in time; the server continues it.
        ImportError: If tqdm is needed and not installed.
    """
    begin = start_export(
        individuals,
        formats,
        generation=generation,
        search=search,
        size=size,
        energy_limit=energy_limit,
    )
    return Archive(begin, poll_s, timeout_s, progress)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportJob(Record):
    """Job that makes a ZIP file of several materials.

    Attributes:
        id: Id of the job.
        state: `queued`, `running`, `succeeded`, `failed` or `cancelled`.
        progress: Share of the files that are made, 0 to 1.
        files: Number of files that workers make, without pictures and manifest.
        made: Number of those that are made.
        bytes: Size of the made files, before compression.
        created_ms: Creation time, in milliseconds since 1970-01-01 UTC.
        started_ms: Time of the first work, likewise.
        ended_ms: Time of the end, likewise.
        expires_ms: Time at which the job and its files are deleted, likewise.
        archive: Path of the file on the server, once the job has succeeded.
        reason: Reason of a failure.
    """

    id: str
    state: str
    progress: float
    files: int
    made: int
    bytes: int
    created_ms: int = field(repr=False)
    started_ms: int | None = field(default=None, repr=False)
    ended_ms: int | None = field(default=None, repr=False)
    expires_ms: int | None = field(default=None, repr=False)
    archive: str | None = field(default=None, repr=False)
    reason: str | None = None

    refresh = Method(export_job)
    cancel = Method(cancel_export)
    file = Method(export_file)
