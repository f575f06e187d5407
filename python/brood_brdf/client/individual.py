"""Individuals: genomes in their place in a brood, with pictures, text, exports and family."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from .call import Call, Listing, Ref, given, id_of, path_of
from .genome import Size, genome_json, genome_text, size_text
from .record import (
    Method,
    Record,
    listing,
    read_bytes,
    read_bytes_if_any,
    read_json,
    read_text,
    record_of,
)

__all__ = ["Individual"]


def individual(individual: Ref) -> Call[Individual]:
    """Returns an individual, read anew."""
    return Call("GET", path_of("individuals", id_of(individual)), record_of(Individual))


def favourites(lineage: Ref | None = None, *, page_size: int | None = None) -> Listing[Individual]:
    """Lists favourites, newest first.

    Args:
        lineage: Only those of this lineage; by default of all that are not hidden.
        page_size: Items per request, 1 to 200.
    """
    only = None if lineage is None else id_of(lineage)
    return listing(Individual, "/v1/individuals", page_size, favourite=True, lineage=only)


def mark(
    individual: Ref,
    *,
    favourite: bool | None = None,
    note: str | None = None,
    version: int | None = None,
) -> Call[Individual]:
    """Changes an individual's favourite mark or note, and returns the changed individual.

    Args:
        individual: The individual.
        favourite: New mark; None keeps it.
        note: New note, at most 10,000 characters; None keeps it.
        version: Change only this version, as last read, else fail with `Conflict`; by default
            whatever the version is.
    """
    return Call(
        "PATCH",
        path_of("individuals", id_of(individual)),
        record_of(Individual),
        json=given(favourite=favourite, note=note),
        headers={"If-Match": "*" if version is None else f'"{version}"'},
    )


def ancestry(individual: Ref, depth: int | None = None) -> Listing[Individual]:
    """Lists the ancestors, nearest first.

    Args:
        individual: The individual.
        depth: Number of generations, 1 to 10,000; by default 100.
    """
    path = path_of("individuals", id_of(individual), "ancestry")
    return listing(Individual, path, None, depth=depth)


def descendants(individual: Ref, *, page_size: int | None = None) -> Listing[Individual]:
    """Lists the descendants in all lineages, oldest first."""
    path = path_of("individuals", id_of(individual), "descendants")
    return listing(Individual, path, page_size)


def picture(
    individual: Ref,
    size: Size | None = None,
    *,
    scene: Ref | None = None,
    light_deg: float | None = None,
    samples: int | str | None = None,
    area: tuple[int, int, int, int] | None = None,
    backend: str | None = None,
    target: Ref | None = None,
    view: int | None = None,
) -> Call[bytes]:
    """Returns a picture as PNG, sRGB of 8 bits; waits while the server renders it.

    Args:
        individual: The individual.
        size: Side in pixels, or width and height; each 16 to 2048, by default 256.
        scene: Scene to render; by default the lineage's.
        light_deg: Angle of the lights on their circle, in degrees.
        samples: Samples per pixel, 1 to 64, or `adaptive`, the default.
        area: Part to render: first column, first row, width, height, in pixels.
        backend: `cpu`, `gpu` or `reference`; by default the server's choice.
        target: Target to compare with: it sets exposure and, if it is an image, scene and size.
        view: Index of the target's image, from 0.
    """
    query = given(
        size=size_text(size),
        scene=None if scene is None else id_of(scene),
        light_deg=light_deg,
        samples=samples,
        area=None if area is None else ",".join(map(str, area)),
        backend=backend,
        target=None if target is None else id_of(target),
        view=view,
    )
    path = path_of("individuals", id_of(individual), "render.png")
    return Call("GET", path, read_bytes, query=query)


def radiance(
    individual: Ref,
    size: Size | None = None,
    *,
    scene: Ref | None = None,
    light_deg: float | None = None,
    samples: int | str | None = None,
    area: tuple[int, int, int, int] | None = None,
    backend: str | None = None,
    target: Ref | None = None,
    view: int | None = None,
) -> Call[bytes]:
    """Returns the linear radiance as an EXR file. The arguments are those of `picture`."""
    png = picture(
        individual,
        size,
        scene=scene,
        light_deg=light_deg,
        samples=samples,
        area=area,
        backend=backend,
        target=target,
        view=view,
    )
    return replace(png, path=path_of("individuals", id_of(individual), "render.exr"))


def animation(
    individual: Ref,
    size: int | None = None,
    *,
    frames: int | None = None,
    seconds: float | None = None,
    scene: Ref | None = None,
) -> Call[bytes]:
    """Returns an animated PNG with the light going once around its circle.

    Args:
        individual: The individual.
        size: Side of each picture in pixels, 16 to 1024; by default 128.
        frames: Number of pictures, 2 to 120; by default 24.
        seconds: Duration of one turn, 0.1 to 60 seconds; by default 4.
        scene: Scene to render; by default the lineage's.
    """
    query = given(
        size=size, frames=frames, seconds=seconds, scene=None if scene is None else id_of(scene)
    )
    path = path_of("individuals", id_of(individual), "render.apng")
    return Call("GET", path, read_bytes, query=query)


def strip(
    individual: Ref,
    size: int | None = None,
    *,
    frames: int | None = None,
    scene: Ref | None = None,
) -> Call[bytes]:
    """Returns pictures along the light's circle, side by side in one PNG.

    Args:
        individual: The individual.
        size: Side of each picture in pixels, 16 to 1024; by default 128.
        frames: Number of pictures, 2 to 120; by default 24.
        scene: Scene to render; by default the lineage's.
    """
    moving = animation(individual, size, frames=frames, scene=scene)
    return replace(moving, path=path_of("individuals", id_of(individual), "strip.png"))


def image_slice(individual: Ref, size: int | None = None) -> Call[bytes]:
    """Returns the image slice as PNG.

    Args:
        individual: The individual.
        size: Side in pixels, 16 to 2048; by default 256.
    """
    path = path_of("individuals", id_of(individual), "slice.png")
    return Call("GET", path, read_bytes, query=given(size=size))


def lit_spheres(
    individual: Ref,
    *,
    scene: Ref | None = None,
    light_deg: float | None = None,
    texels: int | None = None,
    turns: int | None = None,
) -> Call[bytes | None]:
    """Returns the radiance in the environments of a scene, for all normals.

    The result is in the binary format of openapi.json; None if the material has none, because it
    is anisotropic, textured or painted, or has bumps.

    Args:
        individual: The individual.
        scene: Scene with the environments and the camera; by default the lineage's.
        light_deg: Angle of the lights on their circle, in degrees.
        texels: Texels along the side of a sphere, 16 to 128; by default 48.
        turns: Number of turns of the environments, 1 to 24; by default 1.
    """
    query = given(
        scene=None if scene is None else id_of(scene),
        light_deg=light_deg,
        texels=texels,
        turns=turns,
    )
    path = path_of("individuals", id_of(individual), "lit-spheres")
    return Call("GET", path, read_bytes_if_any, query=query)


def thumbnail(individual: Individual, *, webp: bool = False) -> Call[bytes]:
    """Returns the picture of the lists, in the lineage's scene and thumbnail size.

    Args:
        individual: The individual.
        webp: True for lossy WebP, about a sixth of the bytes, in place of PNG.
    """
    path = individual.thumbnail_path
    return Call("GET", path.removesuffix(".png") + ".webp" if webp else path, read_bytes)


def inspection(individual: Ref) -> Call[dict[str, Any]]:
    """Returns source, live code, inputs, physical checks, albedo and reflectance over planes."""
    return Call("GET", path_of("individuals", id_of(individual), "inspection"), read_json)


def export(
    individual: Ref,
    format: str,
    *,
    energy_limit: bool | None = None,
    uv_within: float | None = None,
    lights: int | None = None,
) -> Call[str]:
    """Returns source code, for example of a shader; `export_bytes` has the binary formats.

    Args:
        individual: The individual.
        format: Name of a format of `export_formats`, such as `wgsl`.
        energy_limit: True to apply the energy limit; by default on in formats for path tracers, in
            others as in the genome.
        uv_within: Largest absolute texture coordinate that the code must handle.
        lights: Number of lights of a painted material, 1 to 8; by default 1.
    """
    query = given(energy_limit=energy_limit, uv_within=uv_within, lights=lights)
    return Call(
        "GET", path_of("individuals", id_of(individual), "exports", format), read_text, query
    )


def export_bytes(
    individual: Ref,
    format: str,
    *,
    energy_limit: bool | None = None,
    uv_within: float | None = None,
    lights: int | None = None,
) -> Call[bytes]:
    """Returns the file of an export, of any format.

    The arguments are those of `export`.
    """
    query = given(energy_limit=energy_limit, uv_within=uv_within, lights=lights)
    return Call(
        "GET", path_of("individuals", id_of(individual), "exports", format), read_bytes, query
    )


def sheet_of(individuals: Iterable[Ref]) -> Call[bytes]:
    """Returns a contact sheet of any individuals as PNG, each in its lineage's scene.

    Args:
        individuals: At most 256 individuals.
    """
    query = {"individuals": ",".join(map(id_of, individuals))}
    return Call("GET", "/v1/sheet.png", read_bytes, query=query)


@dataclass(frozen=True, slots=True, kw_only=True)
class Individual(Record):
    """Genome in its place in a brood. In a notebook, it is shown as its thumbnail.

    Attributes:
        id: Id of the individual.
        hash: Content hash of the genome: 64 hexadecimal digits.
        slot: Place in the brood, from 0.
        operator: Origin: `random`, `mutate`, `recombine`, `adopt` or `fit`.
        parents: Ids of individuals or hashes of genomes, as requested.
        live_instructions: Number of instructions that can change the result.
        favourite: True if it is marked as a favourite.
        note: Note of a user.
        thumbnail_path: Path of the thumbnail on the server.
        version: Number of changes.
        twin: True if no draw gave a program that differs from those of parents and siblings.
        layers: Names of its analytic models, lowest first.
        lineage: Id of its lineage; None in a generation.
        generation: Id of its generation; None in a generation.
        generation_index: Place of its generation in the lineage, from 0; None in a generation.
        exposure_ev: Automatic exposure over the light circle in EV; only from `individual`.
    """

    # The method `thumbnail` has the field's name.
    renamed: ClassVar[Mapping[str, str]] = {"thumbnail": "thumbnail_path"}

    id: str
    hash: str
    slot: int
    operator: str
    parents: tuple[str, ...]
    live_instructions: int
    favourite: bool
    note: str
    thumbnail_path: str
    version: int
    twin: bool = False
    layers: tuple[str, ...] = ()
    lineage: str | None = None
    generation: str | None = None
    generation_index: int | None = None
    exposure_ev: float | None = None

    refresh = Method(individual)
    mark = Method(mark)
    ancestry = Method(ancestry)
    descendants = Method(descendants)
    picture = Method(picture)
    radiance = Method(radiance)
    animation = Method(animation)
    strip = Method(strip)
    image_slice = Method(image_slice)
    thumbnail = Method(thumbnail)
    lit_spheres = Method(lit_spheres)
    inspection = Method(inspection)
    export = Method(export)
    export_bytes = Method(export_bytes)
    text = Method(genome_text)
    json = Method(genome_json)

    def _repr_png_(self) -> bytes | None:
        """Returns the thumbnail for a notebook; None without an open synchronous client."""
        client = self._shown_by
        return None if client is None else thumbnail(self).sync(client)
