"""Searches for materials that match a target: starting, watching, waiting, results."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import httpx

from .call import Call, Flow, Listing, Ref, Requester, Sender, given, id_of, path_of
from .error import SearchFailed
from .event import Event, Watch
from .export import ExportJob
from .genome import genome_json, genome_text
from .individual import export, inspection, picture
from .island import Island
from .job import DeferredAnswer, RenderJob
from .progress import Progress
from .record import Method, Record, listing, nothing, read_bytes, record_of
from .retry import Pause, Steps

__all__ = [
    "FoundMaterial",
    "FoundView",
    "MaterialSpread",
    "NextScene",
    "Search",
    "SearchLine",
]

ENDED = frozenset({"succeeded", "failed", "cancelled"})
"""States of searches that have ended."""


def start_search(
    target: Ref,
    *,
    seconds: float | None = None,
    generations: int | None = None,
    evaluations: int | None = None,
    strategy: str | None = None,
    objective: str | None = None,
    seed: int | None = None,
    threads: int | None = None,
    islands: int | None = None,
    target_error: float | None = None,
    lineage: Ref | None = None,
    start: Iterable[Ref] | None = None,
    mirrored: bool | None = None,
    name: str | None = None,
) -> Call[Search]:
    """Starts a search, with exactly one budget: seconds, generations or evaluations.

    Args:
        target: Target to match.
        seconds: Budget of time, above 0 and at most 604,800 seconds.
        generations: Budget of generations; the result is the same on every machine.
        evaluations: Budget of evaluated candidates.
        strategy: `auto`, `lobes`, `analytic`, `gp` or `hybrid`; `auto`, the default, is
            `analytic` for pictures and `hybrid` for measurements.
        objective: What lobes minimise: `seen`, the default of `lobes` and `hybrid`, is E_log with
            differences of dark values added; `e_log` is E_log alone.
        seed: Seed, 0 to 2^64 - 1; by default 1.
        threads: Number of threads, 1 to 256; by default all of the worker.
        islands: Number of islands, 1 to 64, for `gp` and `hybrid`: searches with different seeds
            on as many workers, which take over each other's best programs; by default 1.
        target_error: E_log on the validation samples at which the search ends early.
        lineage: Lineage of the results; by default a new one.
        start: At most 64 individuals to start from.
        mirrored: True if the material is mirror symmetric.
        name: Display name; by default that of the target.
    """
    body = given(
        kind="fit",
        target=id_of(target),
        seconds=seconds,
        generations=generations,
        evaluations=evaluations,
        strategy=strategy,
        objective=objective,
        seed=seed,
        threads=threads,
        islands=islands,
        target_error=target_error,
        lineage=None if lineage is None else id_of(lineage),
        start=None if start is None else [id_of(one) for one in start],
        mirrored=mirrored,
        name=name,
    )
    return Call("POST", "/v1/jobs", record_of(Search), json=body)


def search(search: Ref) -> Call[Search]:
    """Returns a search, read anew."""
    return Call("GET", path_of("jobs", id_of(search)), record_of(Search))


def job(job: Ref) -> Call[Search | ExportJob | RenderJob | DeferredAnswer]:
    """Returns a job: a search, an export, a deferred answer, or the render job of a brood."""

    def read(
        answer: httpx.Response, client: Sender | None
    ) -> Search | ExportJob | RenderJob | DeferredAnswer:
        data = answer.json()
        kinds: dict[str, type[Search | ExportJob | RenderJob | DeferredAnswer]]
        kinds = {"render": RenderJob, "export": ExportJob, "answer": DeferredAnswer}
        return kinds.get(data.get("kind"), Search).of(data, client)

    return Call("GET", path_of("jobs", id_of(job)), read)


def searches(lineage: Ref | None = None, *, page_size: int | None = None) -> Listing[Search]:
    """Lists searches, newest first.

    Args:
        lineage: Only those whose results go to this lineage.
        page_size: Items per request, 1 to 200.
    """
    only = None if lineage is None else id_of(lineage)
    return listing(Search, "/v1/jobs", page_size, lineage=only)


def pause_search(search: Ref) -> Call[Search]:
    """Pauses a queued or running search; fails with `Conflict` in another state."""
    return _change(search, "pause")


def resume_search(search: Ref) -> Call[Search]:
    """Resumes a paused search; fails with `Conflict` in another state."""
    return _change(search, "resume")


def cancel_search(search: Ref) -> Call[Search]:
    """Ends a search, which keeps its best result; fails with `Conflict` if it has ended."""
    return _change(search, "cancel")


def _change(search: Ref, word: str) -> Call[Search]:
    return Call("POST", path_of("jobs", id_of(search), word), record_of(Search))


def front(search: Ref) -> Call[tuple[FoundMaterial, ...]]:
    """Returns the results, best first; while the search runs, only the best so far."""

    def read(answer: httpx.Response, client: Sender | None) -> tuple[FoundMaterial, ...]:
        return tuple(FoundMaterial.of(item, client) for item in answer.json()["items"])

    return Call("GET", path_of("jobs", id_of(search), "front"), read)


def spread(search: Ref) -> Call[MaterialSpread | None]:
    """Returns the spread of the materials that match the pictures of the target.

    None until the search has ended, and unless models were fitted to pictures.
    """

    def read(answer: httpx.Response, client: Sender | None) -> MaterialSpread | None:
        found = answer.json()["spread"]
        return None if found is None else MaterialSpread.of(found, client)

    return Call("GET", path_of("jobs", id_of(search), "front"), read)


def darkest(search: Ref) -> Call[bytes]:
    """Returns the darkest that the material could be under up to three other lights, as PNG.

    5 % quantile of each pixel over the materials of `spread`; fails with `NotFound` if there is
    no spread.
    """
    return Call("GET", path_of("jobs", id_of(search), "darkest.png"), read_bytes)


def brightest(search: Ref) -> Call[bytes]:
    """Returns the brightest that the material could be under the lights of `darkest`, as PNG.

    95 % quantile of each pixel, at the exposures of `darkest`.
    """
    return Call("GET", path_of("jobs", id_of(search), "brightest.png"), read_bytes)


def search_log(search: Ref, after: int = 0, island: int = 0) -> Call[tuple[SearchLine, ...]]:
    """Returns one line per generation so far.

    Args:
        search: The search.
        after: Skip the generations up to and including this one.
        island: Number of the island, from 0.
    """

    def read(answer: httpx.Response, client: Sender | None) -> tuple[SearchLine, ...]:
        lines = answer.content.split(b"\n")
        return tuple(SearchLine.of(json.loads(line), client) for line in lines if line)

    query = {"after": after} if island == 0 else {"after": after, "island": island}
    return Call("GET", path_of("jobs", id_of(search), "log"), read, query=query)


def search_events(search: Ref) -> Watch:
    """Returns the search's changes, as they come, until it ends.

    The events are `state`, `progress`, `best`, and `resync` if events were missed. The last one is
    the `state` `succeeded`, `failed` or `cancelled`, also if the search has ended before.
    """
    path = path_of("jobs", id_of(search))

    def read_end(answer: httpx.Response, _: Sender | None) -> Event | None:
        data = answer.json()
        if data["state"] not in ENDED:
            return None
        return Event("state", {name: data.get(name) for name in ("id", "state", "reason")})

    return Watch(
        Call("GET", path + "/events", nothing),
        Call("GET", path, read_end),
        lambda event: event.name == "state" and event.data.get("state") in ENDED,
    )


@dataclass(frozen=True, slots=True)
class Wait(Flow["Search"]):
    """Wait for the end of a search."""

    search: Ref
    poll_s: float
    timeout_s: float | None
    progress: bool

    def steps(self, client: Requester) -> Steps[Search]:
        """Returns the steps to the ended search."""
        begun_s = client.clock_s()
        with Progress("search", self.progress) as bar:
            while True:
                now = yield from search(self.search).steps(client)
                bar.show(now.progress, "" if now.held is None else f"E_log {now.held:.4g}")
                if now.state == "failed":
                    raise SearchFailed(f"search {now.id} failed: {now.reason}")
                if now.state in ENDED:
                    return now
                waited_s = client.clock_s() - begun_s
                if self.timeout_s is not None and waited_s + self.poll_s > self.timeout_s:
                    words = f"search {now.id} is {now.state} after {waited_s:.0f} s"
                    raise TimeoutError(words)
                yield Pause(self.poll_s)


def wait(
    search: Ref, *, poll_s: float = 1.0, timeout_s: float | None = None, progress: bool = False
) -> Wait:
    """Waits until a search has succeeded or was cancelled, and returns it.

    Args:
        search: The search. It may be paused and resumed meanwhile.
        poll_s: Seconds between looks.
        timeout_s: Most seconds to wait; by default any number.
        progress: True to show a progress bar by tqdm.

    Raises:
        SearchFailed: If the search fails.
        TimeoutError: If it has not ended in time; the server continues it.
        ImportError: If tqdm is needed and not installed.
    """
    return Wait(search, poll_s, timeout_s, progress)


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundView(Record):
    """Difference of a found material from an image of the target.

    Attributes:
        flip: Mean FLIP error at equal exposure, 0 to 1.
        rmse: Root mean square difference of linear radiance.
        gain: Factor applied to the material's picture before the comparison.
        held_out: True if the image was not fitted.
    """

    flip: float
    rmse: float
    gain: float
    held_out: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundMaterial(Record):
    """Material that a search has found; may be used as an individual.

    Attributes:
        individual: Id of the individual in the search's lineage.
        hash: Content hash of the genome.
        e_log: E_log on the held-out samples: root mean square difference of ln(1 + f cos_i).
        e_log_fitted: E_log on the fitted samples.
        e_cbrt: Root mean square difference of the cube root of f cos_i, on held-out samples.
        relative_l2: Relative L2 difference of f cos_i on the held-out samples.
        operations: Scalar operations per sample, including the energy limit.
        numbers: Number of fitted parameters.
        divisor: Divisor that the energy limit applies to f; 1 or more.
        generation: Generation of the search, from 1.
        thumbnail: Path of the thumbnail on the server.
        views: Difference from each image of the target; empty for measurements.
    """

    nested: ClassVar[Mapping[str, type[Record]]] = {"views": FoundView}

    individual: str
    hash: str = field(repr=False)
    e_log: float
    e_log_fitted: float
    e_cbrt: float
    relative_l2: float
    operations: int
    numbers: int
    divisor: float
    generation: int
    thumbnail: str | None = field(default=None, repr=False)
    views: tuple[FoundView, ...] | None = None

    picture = Method(picture)
    inspection = Method(inspection)
    export = Method(export)
    text = Method(genome_text)
    json = Method(genome_json)

    @property
    def id(self) -> str:
        """Id of the individual."""
        return self.individual

    def _repr_png_(self) -> bytes | None:
        """Returns its picture for a notebook; None without an open synchronous client."""
        client = self._shown_by
        return None if client is None else picture(self).sync(client)


@dataclass(frozen=True, slots=True, kw_only=True)
class Search(Record):
    """Search for a material that matches a target.

    Attributes:
        id: Id of the search.
        name: Display name.
        target: Id of the target.
        lineage: Id of the lineage of the results.
        state: `queued`, `running`, `paused`, `succeeded`, `failed` or `cancelled`.
        progress: Share of the budget that is used up, 0 to 1.
        generation: Number of generations so far; of several islands, the least.
        evaluations: Number of evaluated candidates so far, on all islands.
        seconds: Search time in seconds, without pauses; of several islands, the longest.
        islands: Number of islands.
        each_island: Progress of each of several islands; empty for a single one.
        budget: One of `seconds`, `generations` and `evaluations`.
        strategy: `lobes`, `analytic`, `gp` or `hybrid`.
        seed: Seed of the search.
        start: Ids of the individuals that it starts from.
        mirrored: True if the material is fitted as mirror symmetric.
        created_ms: Creation time, in milliseconds since 1970-01-01 UTC.
        started_ms: Time of the first work, likewise.
        ended_ms: Time of the end, likewise.
        best: Best material so far.
        fitted: E_log of the best candidate on the samples it is fitted to.
        held: E_log of the best candidate on the validation samples.
        objective: `seen` or `e_log`; None in searches of earlier versions.
        reason: Reason of a failure.
        population: Hash of the search's state.
        target_error: E_log at which it ends early.
        threads: Number of threads; None for all of the worker.
    """

    nested: ClassVar[Mapping[str, type[Record]]] = {"best": FoundMaterial, "each_island": Island}

    id: str
    name: str
    target: str
    lineage: str
    state: str
    progress: float
    generation: int
    evaluations: int
    seconds: float
    islands: int = field(default=1, repr=False)
    each_island: tuple[Island, ...] = field(default=(), repr=False)
    budget: Mapping[str, float] = field(hash=False)
    strategy: str
    seed: int
    start: tuple[str, ...] = field(repr=False)
    mirrored: bool
    created_ms: int = field(repr=False)
    started_ms: int | None = field(default=None, repr=False)
    ended_ms: int | None = field(default=None, repr=False)
    best: FoundMaterial | None = None
    fitted: float | None = None
    held: float | None = None
    objective: str | None = None
    reason: str | None = None
    population: str | None = field(default=None, repr=False)
    target_error: float | None = None
    threads: int | None = None

    refresh = Method(search)
    wait = Method(wait)
    pause = Method(pause_search)
    resume = Method(resume_search)
    cancel = Method(cancel_search)
    front = Method(front)
    spread = Method(spread)
    darkest = Method(darkest)
    brightest = Method(brightest)
    log = Method(search_log)
    events = Method(search_events)


@dataclass(frozen=True, slots=True, kw_only=True)
class NextScene(Record):
    """A picture that would tell more about a material.

    Attributes:
        scene: Scene of the first picture with the light elsewhere.
        light_deg: Direction of the lamp from the object with the eye in front: to the right and
            upwards, degrees. None if the environment is turned.
        e_log: Expected E_log over all directions after it.
    """

    scene: Mapping[str, Any] = field(hash=False, repr=False)
    light_deg: tuple[float, ...] | None = None
    e_log: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialSpread(Record):
    """Spread of the materials that match the pictures of a target about as well as the best.

    The maps have `cells` rows over theta_d and as many columns over theta_h, both from 0 to 90
    degrees, at phi_d = 90 degrees, row by row.

    Attributes:
        e_log: Expected E_log over all directions.
        cells: Number of rows, and of columns.
        seen: Share of the samples in each cell.
        deviation: Standard deviation of ln f in each cell; 0 below the surface.
        next: The picture after which the least error is expected, or None if none lowers it by
            a tenth.
        pictures: True if the search has pictures `darkest` and `brightest`; False for searches
            of earlier versions.
    """

    nested: ClassVar[Mapping[str, type[Record]]] = {"next": NextScene}

    e_log: float
    cells: int
    seen: tuple[float, ...] = field(repr=False)
    deviation: tuple[float, ...] = field(repr=False)
    next: NextScene | None = None
    pictures: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchLine(Record):
    """One generation of a search's log.

    Attributes:
        generation: Generation, from 1.
        evaluations: Number of evaluated candidates so far.
        seconds: Search time so far, in seconds.
        fitted: E_log of the best candidate on the samples it is fitted to.
        held: E_log of the best candidate on the validation samples.
        median: Median E_log of the population on the fitted samples.
        diversity: Share of the population that differs in more than its parameters, 0 to 1.
        repeats: Number of skipped candidates so far.
        best: Hash of the best genome so far.
    """

    generation: int
    evaluations: int
    seconds: float
    fitted: float | None = None
    held: float | None = None
    median: float | None = None
    diversity: float | None = None
    repeats: int | None = None
    best: str | None = None
