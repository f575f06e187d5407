"""Generations: broods with everything needed to breed them again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from .call import Call, Ref, given, id_of, path_of
from .individual import Individual
from .record import Method, Record, read_bytes, record_of

__all__ = ["Generation"]


def generation(generation: Ref) -> Call[Generation]:
    """Returns a generation with its individuals, read anew."""
    return Call("GET", path_of("generations", id_of(generation)), record_of(Generation))


def sheet(
    generation: Ref, *, scene: Ref | None = None, light_deg: float | None = None
) -> Call[bytes]:
    """Returns the contact sheet as PNG: 6 x 6 around the centre for 20 children, else near-square.

    Args:
        generation: The generation.
        scene: Scene to render; by default the lineage's.
        light_deg: Angle of the lights on their circle, in degrees; by default the scene's.
    """
    query = given(scene=None if scene is None else id_of(scene), light_deg=light_deg)
    path = path_of("generations", id_of(generation), "sheet.png")
    return Call("GET", path, read_bytes, query=query)


def sheet_animation(
    generation: Ref,
    size: int | None = None,
    *,
    frames: int | None = None,
    seconds: float | None = None,
    scene: Ref | None = None,
) -> Call[bytes]:
    """Returns the contact sheet as animated PNG, with the light going once around its circle.

    Args:
        generation: The generation.
        size: Side of each picture in pixels, 16 to 1024; by default 128.
        frames: Number of pictures, 2 to 120; by default 24.
        seconds: Duration of one turn, 0.1 to 60 seconds; by default 4.
        scene: Scene to render; by default the lineage's.
    """
    query = given(
        size=size, frames=frames, seconds=seconds, scene=None if scene is None else id_of(scene)
    )
    path = path_of("generations", id_of(generation), "sheet.apng")
    return Call("GET", path, read_bytes, query=query)


@dataclass(frozen=True, slots=True, kw_only=True)
class Generation(Record):
    """Brood: a sequence of individuals. In a notebook, it is shown as its contact sheet.

    Attributes:
        id: Id of the generation.
        lineage: Id of its lineage.
        index: Place in the lineage, from 0.
        created_ms: Creation time, in milliseconds since 1970-01-01 UTC.
        seed: Seed that was used, from 0 to 2^64 - 1.
        parents: Ids of individuals or hashes of genomes, as requested.
        mutation: Visible amount of mutation, 0 to 1.
        recombination: Expected share of the second parent, 0 to 1.
        curation: `off`, `distinct` or `diverse`.
        constraints: Overrides of the dialect, as requested.
        individuals: Children, by slot.
        centre: Parent that is shown large; None after a random start.
        energy_limit: Energy limit, as requested.
        saturation: Colour saturation, 0 to 1, as requested.
        locks: Locked parts of the first parent.
        steer: Properties that the children keep or change.
        painting: Colours of a picture that the children are painted with.
    """

    nested: ClassVar[Mapping[str, type[Record]]] = {
        "individuals": Individual,
        "centre": Individual,
    }

    id: str
    lineage: str
    index: int
    created_ms: int = field(repr=False)
    seed: int
    parents: tuple[str, ...]
    mutation: float
    recombination: float
    curation: str
    constraints: Mapping[str, Any] = field(hash=False, repr=False)
    individuals: tuple[Individual, ...] = field(repr=False)
    centre: Individual | None = field(default=None, repr=False)
    energy_limit: bool | None = None
    saturation: float | None = None
    locks: Mapping[str, Any] | None = field(default=None, hash=False, repr=False)
    steer: tuple[str, ...] = ()
    painting: Mapping[str, Any] | None = field(default=None, hash=False, repr=False)

    refresh = Method(generation)
    sheet = Method(sheet)
    sheet_animation = Method(sheet_animation)

    def __len__(self) -> int:
        """Returns the number of children."""
        return len(self.individuals)

    def __iter__(self) -> Iterator[Individual]:
        """Returns an iterator over the children, by slot."""
        return iter(self.individuals)

    def __getitem__(self, slot: int) -> Individual:
        """Returns the child of a slot, from 0."""
        return self.individuals[slot]

    def _repr_png_(self) -> bytes | None:
        """Returns the sheet for a notebook; None without an open synchronous client."""
        client = self._shown_by
        return None if client is None else sheet(self).sync(client)
