"""Lineages: creating, breeding, adopting, reading, changing, and their events."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from .call import Call, File, Flow, Listing, Ref, Requester, bytes_of, given, id_of, path_of
from .event import Watch
from .generation import Generation
from .genome import Genome, Hashed, store_genome
from .individual import favourites
from .record import Method, Record, listing, nothing, read_bytes, record_of
from .retry import Steps

__all__ = ["Lineage"]


def create_lineage(
    name: str,
    *,
    start: str | None = None,
    scene: Ref | None = None,
    dialect: Mapping[str, Any] | None = None,
    saturation: float | None = None,
    energy_limit: bool | None = None,
    thumbnail_px: int | None = None,
    notes: str | None = None,
    tags: Sequence[str] | None = None,
) -> Call[Lineage]:
    """Creates a lineage, which has no generations yet.

    Args:
        name: Display name, 1 to 200 characters.
        start: Source of random children: `believable`, `models`, `painted` or `wild`, the default.
        scene: Scene of the pictures; by default the built-in scene.
        dialect: Restricts the programs of all genomes; by default that of the start.
        saturation: Colour saturation of random children, from 0 (grey) to 1, the default.
        energy_limit: True to put random children under the energy limit.
        thumbnail_px: Side of the thumbnails in pixels, 16 to 1024; by default 256.
        notes: Notes, at most 10,000 characters.
        tags: At most 12 tags of 1 to 30 characters, without commas.
    """
    body = given(
        name=name,
        start=start,
        scene=None if scene is None else id_of(scene),
        dialect=dialect,
        saturation=saturation,
        energy_limit=energy_limit,
        thumbnail_px=thumbnail_px,
        notes=notes,
        tags=None if tags is None else list(tags),
    )
    return Call("POST", "/v1/lineages", record_of(Lineage), json=body)


def lineage(lineage: Ref) -> Call[Lineage]:
    """Returns a lineage, read anew."""
    return Call("GET", path_of("lineages", id_of(lineage)), record_of(Lineage))


def lineages(
    search: str | None = None, *, hidden: bool = False, page_size: int | None = None
) -> Listing[Lineage]:
    """Lists lineages, newest first.

    Args:
        search: Words that must all occur in the name, the notes or a tag.
        hidden: True to list the hidden lineages instead of the others.
        page_size: Items per request, 1 to 200.
    """
    return listing(Lineage, "/v1/lineages", page_size, search=search, hidden=hidden or None)


def change_lineage(
    lineage: Ref,
    *,
    name: str | None = None,
    notes: str | None = None,
    tags: Sequence[str] | None = None,
    scene: Ref | None = None,
    cover: Ref | None = None,
    saturation: float | None = None,
    energy_limit: bool | None = None,
    hidden: bool | None = None,
    version: int | None = None,
) -> Call[Lineage]:
    """Changes the given properties of a lineage, and returns the changed lineage.

    Args:
        lineage: The lineage.
        name: New name.
        notes: New notes.
        tags: New tags, in place of the present ones.
        scene: New scene, for all pictures.
        cover: Individual whose picture represents the lineage.
        saturation: New colour saturation of random children, 0 to 1.
        energy_limit: New energy limit of random children.
        hidden: True to hide it from lists, false to show it again.
        version: Change only this version, as last read, else fail with `Conflict`; by default
            whatever the version is.
    """
    body = given(
        name=name,
        notes=notes,
        tags=None if tags is None else list(tags),
        scene=None if scene is None else id_of(scene),
        cover_individual=None if cover is None else id_of(cover),
        saturation=saturation,
        energy_limit=energy_limit,
        hidden=hidden,
    )
    headers = {"If-Match": "*" if version is None else f'"{version}"'}
    path = path_of("lineages", id_of(lineage))
    return Call("PATCH", path, record_of(Lineage), json=body, headers=headers)


def delete_lineage(lineage: Ref, *, purge: bool = False) -> Call[None]:
    """Hides a lineage from lists, or removes it.

    Args:
        lineage: The lineage.
        purge: True to remove it with all its contents for ever.
    """
    query = given(purge=purge or None)
    return Call("DELETE", path_of("lineages", id_of(lineage)), nothing, query=query)


def lineage_file(lineage: Ref) -> Call[bytes]:
    """Returns the whole history as one file, for `import_lineage` of this or another server."""
    return Call("GET", path_of("lineages", id_of(lineage), "file"), read_bytes)


def import_lineage(file: File) -> Call[Lineage]:
    """Makes a lineage of a file that `lineage_file` returned.

    Args:
        file: Bytes, or the path of a file; at most 256 MiB.
    """
    headers = {"Content-Type": "application/json"}
    content = bytes_of(file)
    return Call("POST", "/v1/lineages/import", record_of(Lineage), content=content, headers=headers)


def breed(
    lineage: Ref,
    parents: Iterable[Ref] = (),
    *,
    count: int | None = None,
    mutation: float | None = None,
    recombination: float | None = None,
    curation: str | None = None,
    seed: int | None = None,
    steer: Sequence[str] | None = None,
    locks: Mapping[str, Any] | None = None,
    saturation: float | None = None,
    energy_limit: bool | None = None,
    isotropic: bool | None = None,
    homogeneous: bool | None = None,
    bumps: bool | None = None,
    painting: Mapping[str, Any] | None = None,
) -> Call[Generation]:
    """Breeds a generation.

    Args:
        lineage: The lineage.
        parents: At most two individuals, or hashes of genomes. None: random children. One:
            mutation. Two: recombination, then mutation; the first is the centre.
        count: Number of children, 1 to 256; by default 20.
        mutation: Visible amount of mutation, from 0.02 (just noticeable) to 1 (unrelated); by
            default 0.3.
        recombination: Expected share of the second parent, 0 to 1; by default 0.5.
        curation: Effort for variety: `off`, `distinct`, the default, or `diverse`.
        seed: Seed, 0 to 2^64 - 1: the same request with it has the same children.
        steer: What the children keep or change: `keep-colour`, `only-gloss`, `warmer`, `cooler`,
            `rougher`, `glossier`, `more-pattern`, `less-pattern`.
        locks: Parts of the first parent that the children keep, such as `{"channels": ["r"]}`.
        saturation: Colour saturation, from 0 (grey) to 1; by default that of the first parent.
        energy_limit: True to put the children under the energy limit.
        isotropic: True if the children look the same when the surface turns about its normal.
        homogeneous: True if the children have no texture.
        bumps: True if all children have bumps, false if none has.
        painting: Colours of a picture, as `palette` returns them.
    """
    constraints = given(isotropic=isotropic, homogeneous=homogeneous, bumps=bumps)
    body = given(
        parents=[id_of(parent) for parent in parents],
        count=count,
        mutation=mutation,
        recombination=recombination,
        curation=curation,
        seed=seed,
        steer=None if steer is None else list(steer),
        locks=locks,
        saturation=saturation,
        energy_limit=energy_limit,
        constraints=constraints or None,
        painting=painting,
    )
    path = path_of("lineages", id_of(lineage), "generations")
    return Call("POST", path, record_of(Generation), json=body)


@dataclass(frozen=True, slots=True)
class Adoption(Flow[Generation]):
    """Generation of given materials; stores those that are texts first."""

    lineage: Ref
    presets: tuple[str, ...]
    hashes: tuple[str, ...]
    texts: tuple[Genome, ...]
    parent: Ref | None

    def steps(self, client: Requester) -> Steps[Generation]:
        """Returns the steps to the generation."""
        hashes = list(self.hashes)
        for text in self.texts:
            hashes.append((yield from store_genome(text).steps(client)))
        body = given(
            presets=list(self.presets) or None,
            genomes=hashes or None,
            parent=None if self.parent is None else id_of(self.parent),
        )
        path = path_of("lineages", id_of(self.lineage), "adoptions")
        call = Call("POST", path, record_of(Generation), json=body)
        return (yield from call.steps(client))


def adopt(
    lineage: Ref,
    *,
    presets: Iterable[str] = (),
    genomes: Iterable[Hashed | str] = (),
    texts: Iterable[Genome] = (),
    parent: Ref | None = None,
) -> Adoption:
    """Adds materials to a lineage as a generation: 1 to 256 together, presets last.

    Args:
        lineage: The lineage.
        presets: Names of presets.
        genomes: Individuals, found materials or hashes of genomes.
        texts: Texts or JSON of genomes.
        parent: Individual of the lineage whose children they become; by default they have no
            parents.

    Raises:
        BadGenome: If a text is invalid; the error has the line and column.
    """
    hashes = tuple(one if isinstance(one, str) else one.hash for one in genomes)
    return Adoption(lineage, tuple(presets), hashes, tuple(texts), parent)


def generations(lineage: Ref, *, page_size: int | None = None) -> Listing[Generation]:
    """Lists the generations of a lineage, oldest first.

    Args:
        lineage: The lineage.
        page_size: Items per request, 1 to 200.
    """
    return listing(Generation, path_of("lineages", id_of(lineage), "generations"), page_size)


def lineage_events(lineage: Ref) -> Watch:
    """Returns the lineage's changes, as they come, without end.

    The events are `generation`, `thumbnail`, `lineage`, `individual`, `job` (of searches) and
    `resync`, if events were missed. A lost connection is continued after the last event.
    """
    return Watch(Call("GET", path_of("lineages", id_of(lineage), "events"), nothing))


@dataclass(frozen=True, slots=True, kw_only=True)
class Lineage(Record):
    """Tree of generations with one dialect and scene.

    Attributes:
        id: Id of the lineage.
        name: Display name.
        start: Source of its random children: `believable`, `models`, `painted` or `wild`.
        dialect: Dialect of its genomes.
        scene: Id of the scene of its pictures.
        saturation: Colour saturation of random children, 0 to 1.
        energy_limit: True if random children are under the energy limit.
        thumbnail_px: Side of its thumbnails in pixels.
        generation_count: Number of generations.
        favourite_count: Number of favourites.
        notes: Notes.
        tags: Tags.
        hidden: True if lists leave it out.
        created_ms: Creation time, in milliseconds since 1970-01-01 UTC.
        version: Number of changes.
        cover_individual: Id of the individual that was chosen as its cover.
        cover: Path of the cover's picture; only in lists.
    """

    # The methods of these names return the things themselves.
    renamed: ClassVar[Mapping[str, str]] = {
        "generations": "generation_count",
        "favourites": "favourite_count",
    }

    id: str
    name: str
    start: str
    dialect: Mapping[str, Any] = field(hash=False, repr=False)
    scene: str
    saturation: float
    energy_limit: bool
    thumbnail_px: int
    generation_count: int
    favourite_count: int
    notes: str = field(repr=False)
    tags: tuple[str, ...]
    hidden: bool
    created_ms: int = field(repr=False)
    version: int
    cover_individual: str | None = None
    cover: str | None = None

    refresh = Method(lineage)
    change = Method(change_lineage)
    delete = Method(delete_lineage)
    file = Method(lineage_file)
    breed = Method(breed)
    adopt = Method(adopt)
    generations = Method(generations)
    favourites = Method(favourites)
    events = Method(lineage_events)
