"""Genomes: storing and reading, pictures and exports of a text, presets, models and formats."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Protocol

import httpx

from .call import Call, Flow, Ref, Requester, Sender, given, id_of, path_of
from .record import Record, items_of, read_bytes, read_bytes_if_any, read_json, read_text
from .retry import Steps

__all__ = ["ExportFormat", "Genome", "Hashed", "Model", "Parameter", "Preset", "Size"]

Genome = str | Mapping[str, Any]
"""Text or JSON of a genome."""

Size = int | tuple[int, int] | str
"""Side of a square picture, or width and height, in pixels; as text `256` or `640x360`."""

_TEXT = "text/x-brood"


class Hashed(Protocol):
    """Anything with a genome: an individual or a found material."""

    @property
    def hash(self) -> str:
        """Content hash of the genome: 64 hexadecimal digits."""
        ...


def size_text(size: Size | None) -> str | None:
    """Returns a size as the server reads it; None for the default."""
    if size is None or isinstance(size, str):
        return size
    if isinstance(size, int):
        return str(size)
    width, height = size
    return f"{width}x{height}"


def _hash_of(genome: Hashed | str) -> str:
    return genome if isinstance(genome, str) else genome.hash


def _body_of(genome: Genome) -> tuple[bytes, dict[str, str]]:
    if isinstance(genome, str):
        return genome.encode("utf-8"), {"Content-Type": _TEXT}
    return json.dumps(genome).encode("utf-8"), {"Content-Type": "application/json"}


def store_genome(genome: Genome) -> Call[str]:
    """Stores a genome, and returns its hash: 64 hexadecimal digits.

    Args:
        genome: Text or JSON.

    Raises:
        BadGenome: If it is invalid; the error has the line, column or JSON pointer.
    """

    def read(answer: httpx.Response, _: Sender | None) -> str:
        return str(answer.json()["hash"])

    content, headers = _body_of(genome)
    return Call("POST", "/v1/genomes", read, content=content, headers=headers)


def genome_text(genome: Hashed | str) -> Call[str]:
    """Returns the text of a stored genome.

    Args:
        genome: Individual, found material, or hash of a genome.
    """
    path = path_of("genomes", _hash_of(genome))
    return Call("GET", path, read_text, headers={"Accept": _TEXT})


def genome_json(genome: Hashed | str) -> Call[dict[str, Any]]:
    """Returns a stored genome as JSON.

    Args:
        genome: Individual, found material, or hash of a genome.
    """
    path = path_of("genomes", _hash_of(genome))
    return Call("GET", path, read_json, headers={"Accept": "application/json"})


@dataclass(frozen=True, slots=True)
class Render(Flow[bytes]):
    """Picture of a genome that is not stored; stores the default scene if none is given."""

    call: Call[bytes]
    scene: Ref | None

    def steps(self, client: Requester) -> Steps[bytes]:
        """Returns the steps to the picture."""
        if self.scene is None:
            default = Call("POST", "/v1/scenes", read_json, json={})
            stored = yield from default.steps(client)
            scene = str(stored["id"])
        else:
            scene = id_of(self.scene)
        call = replace(self.call, query={**self.call.query, "scene": scene})
        return (yield from call.steps(client))


def render(
    genome: Genome,
    size: Size | None = None,
    *,
    scene: Ref | None = None,
    light_deg: float | None = None,
) -> Render:
    """Returns a picture of a genome as PNG, without storing the genome.

    Args:
        genome: Text or JSON.
        size: Side in pixels, or width and height; each 16 to 2048, by default 256.
        scene: Scene to render; by default the server's default scene.
        light_deg: Angle of the lights on their circle, in degrees.

    Raises:
        BadGenome: If the genome is invalid; the error has the line, column or JSON pointer.
    """
    content, headers = _body_of(genome)
    query = given(size=size_text(size), light_deg=light_deg)
    call = Call("POST", "/v1/render.png", read_bytes, query=query, content=content, headers=headers)
    return Render(call, scene)


def lit_spheres_of(
    genome: Genome,
    scene: Ref,
    *,
    light_deg: float | None = None,
    texels: int | None = None,
    turns: int | None = None,
) -> Call[bytes | None]:
    """Returns what `lit_spheres` does, of a genome that is not stored.

    Args:
        genome: Text or JSON.
        scene: Scene with the environments and the camera.
        light_deg: Angle of the lights on their circle, in degrees.
        texels: Texels along the side of a sphere, 16 to 128; by default 48.
        turns: Number of turns of the environments, 1 to 24; by default 1.
    """
    content, headers = _body_of(genome)
    query = given(scene=id_of(scene), light_deg=light_deg, texels=texels, turns=turns)
    path = "/v1/lit-spheres"
    return Call("POST", path, read_bytes_if_any, query=query, content=content, headers=headers)


def export_genome(
    genome: Genome,
    format: str,
    *,
    energy_limit: bool | None = None,
    uv_within: float | None = None,
    lights: int | None = None,
) -> Call[str]:
    """Returns a genome in a format of text, without storing it; `Material.export_bytes` has the
    binary formats.

    Args:
        genome: Text or JSON.
        format: Name of a format of `export_formats`, such as `wgsl`.
        energy_limit: True to apply the energy limit; by default on in formats for path tracers, in
            others as in the genome.
        uv_within: Largest absolute texture coordinate that the code must handle.
        lights: Number of lights of a painted material, 1 to 8; by default 1.
    """
    content, headers = _body_of(genome)
    query = given(energy_limit=energy_limit, uv_within=uv_within, lights=lights)
    path = path_of("exports", format)
    return Call("POST", path, read_text, query=query, content=content, headers=headers)


def export_formats() -> Call[tuple[ExportFormat, ...]]:
    """Lists the formats of exported source code."""
    return Call("GET", "/v1/exports", items_of(ExportFormat))


def presets() -> Call[tuple[Preset, ...]]:
    """Lists the hand-written materials."""
    return Call("GET", "/v1/presets", items_of(Preset))


def models() -> Call[tuple[Model, ...]]:
    """Lists the reflectance models with their parameters."""
    return Call("GET", "/v1/models", items_of(Model))


def compare(
    materials: Iterable[Ref],
    *,
    scene: Ref | None = None,
    size: int | None = None,
) -> Call[dict[str, Any]]:
    """Compares two to six materials: curves, numbers, and differences from the first one.

    Args:
        materials: Individuals, found materials, ids of individuals, or hashes of genomes.
        scene: Scene to render; by default that of the first individual's lineage.
        size: Side of the pictures in pixels, 16 to 1024; by default 256.
    """
    query = given(
        materials=",".join(map(id_of, materials)),
        scene=None if scene is None else id_of(scene),
        size=size,
    )
    return Call("GET", "/v1/comparison", read_json, query=query)


@dataclass(frozen=True, slots=True, kw_only=True)
class Preset(Record):
    """Hand-written material.

    Attributes:
        name: Name in requests.
        title: Name for people.
        words: Description of its appearance.
        dialect: Dialect of a lineage that can breed it.
        text: Text of the genome, with comments.
    """

    name: str
    title: str
    words: str
    dialect: Mapping[str, Any] = field(hash=False, repr=False)
    text: str = field(repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter(Record):
    """Parameter of a reflectance model.

    Attributes:
        name: Name in genomes.
        about: Description.
        unit: Unit; empty if it has none.
        kind: `scalar`, `color` or `choice`.
        range: Least and largest value of each component; of a choice, the index of a word.
        scale: `linear` or `logarithmic`.
        default: Default values: one, or three of a colour.
        words: Words of a choice.
    """

    name: str
    about: str
    unit: str
    kind: str
    range: tuple[float, float]
    scale: str
    default: tuple[float, ...]
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Model(Record):
    """Reflectance model.

    Attributes:
        name: Name in genomes.
        about: Description.
        source: Author, year and title of the publication.
        parameters: Parameters, in the order of a genome's text.
    """

    nested: ClassVar[Mapping[str, type[Record]]] = {"parameters": Parameter}

    name: str
    about: str
    source: str
    parameters: tuple[Parameter, ...] = field(repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportFormat(Record):
    """Format of exported materials.

    Attributes:
        name: Name in requests.
        label: Name for people.
        extension: Ending of file names, without the first dot.
        media_type: Media type of the file.
        painted: True if only painted materials can be exported in it.
        brdf: True if only BRDFs can be exported in it.
        exactness: exact (code), table (numbers between which is interpolated), or fit (the nearest
            of the format's own materials).
        error: Error of the format, in words.
        opened_by: Programs that open it.
        commands: Shell commands from nothing to a picture, in which FILE is the name of the file
            and URL its address; empty if the format needs a program of the user.
        path_traced: True if path tracers read it, so that the energy limit is on by default.
    """

    name: str
    label: str
    extension: str
    media_type: str
    painted: bool
    brdf: bool
    exactness: str
    error: str
    opened_by: str
    commands: tuple[str, ...]
    path_traced: bool
