"""Scenes and the files that they refer to: meshes, environments, profiles, images; palettes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from .call import Call, File, Ref, bytes_of, given, id_of, path_of
from .record import Record, read_bytes, read_json, record_of

__all__ = ["Asset", "Mesh", "Scene"]


def store_scene(scene: Mapping[str, Any] | None = None, **fields: Any) -> Call[Scene]:
    """Stores a scene; equal scenes have the same id.

    Args:
        scene: Scene as JSON; fields that are left out have defaults.
        fields: Further fields, such as `mesh="knob"`.
    """
    body = {**(scene or {}), **fields}
    return Call("POST", "/v1/scenes", record_of(Scene), json=body)


def scene(scene: Ref) -> Call[Scene]:
    """Returns a stored scene, every field present."""
    return Call("GET", path_of("scenes", id_of(scene)), record_of(Scene))


def default_scene() -> Call[dict[str, Any]]:
    """Returns the default scene as JSON, to be changed and stored."""
    return Call("GET", "/v1/scenes/default", read_json)


def upload_mesh(file: File) -> Call[Mesh]:
    """Uploads an OBJ file.

    Args:
        file: Bytes, or the path of a file; at most 32 MiB.
    """
    headers = {"Content-Type": "model/obj"}
    return Call("POST", "/v1/meshes", record_of(Mesh), content=bytes_of(file), headers=headers)


def mesh(mesh: Ref) -> Call[Mesh]:
    """Returns the summary of an uploaded mesh."""
    return Call("GET", path_of("meshes", id_of(mesh)), record_of(Mesh))


def mesh_glb(mesh: Ref, sphere_pole: str | None = None) -> Call[bytes]:
    """Returns a mesh as binary glTF, with the tangents that brood shades with.

    Args:
        mesh: Uploaded mesh, name of a built-in one, or `ground`.
        sphere_pole: Axis of the texture of the mesh `sphere`: `y`, the default, or `z`.
    """
    path = path_of("meshes", id_of(mesh), "mesh.glb")
    return Call("GET", path, read_bytes, query=given(sphere_pole=sphere_pole))


def upload_environment(file: File) -> Call[Asset]:
    """Uploads an equirectangular environment image.

    Args:
        file: Radiance HDR or EXR, as bytes or the path of a file; at most 64 MiB.
    """
    return _upload("/v1/environments", bytes_of(file))


def upload_image(file: File) -> Call[Asset]:
    """Uploads an image for painted materials, backdrops or normal maps.

    Args:
        file: PNG or JPEG, as bytes or the path of a file; at most 4096 pixels a side.
    """
    return _upload("/v1/images", bytes_of(file))


def upload_profile(file: File) -> Call[Asset]:
    """Uploads the IES profile of a lamp.

    Args:
        file: IES text, as bytes or the path of a file; at most 4 MiB.
    """
    return _upload("/v1/profiles", bytes_of(file), "application/x-ies")


def palette(file: File) -> Call[dict[str, Any]]:
    """Returns the colours of a picture by regions, as the `painting` of `breed`.

    Args:
        file: PNG or JPEG, as bytes or the path of a file; at most 4096 pixels a side.
    """
    content = bytes_of(file)
    headers = {"Content-Type": _media_type(content)}
    return Call("POST", "/v1/palettes", read_json, content=content, headers=headers)


def develop(file: File) -> Call[bytes]:
    """Returns a picture of linear radiance as PNG in its own size, at automatic exposure.

    Args:
        file: EXR or Radiance HDR, as bytes or the path of a file.
    """
    content = bytes_of(file)
    headers = {"Content-Type": _media_type(content)}
    return Call("POST", "/v1/develop.png", read_bytes, content=content, headers=headers)


def _upload(path: str, content: bytes, media_type: str | None = None) -> Call[Asset]:
    headers = {"Content-Type": media_type or _media_type(content)}
    return Call("POST", path, record_of(Asset), content=content, headers=headers)


_BEGINNINGS = {
    b"\x89PNG": "image/png",
    b"\xff\xd8": "image/jpeg",
    b"\x76\x2f\x31\x01": "image/x-exr",
    b"#?": "image/vnd.radiance",
}


def _media_type(content: bytes) -> str:
    for beginning, media_type in _BEGINNINGS.items():
        if content.startswith(beginning):
            return media_type
    raise ValueError("the file must be PNG, JPEG, EXR or Radiance HDR")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene(Record):
    """Mesh, camera, lights and film of a picture. The world is right-handed with y up.

    Attributes:
        id: Id of the scene.
        mesh: `ball`, `sphere`, `torus`, `cube`, `knob` or the id of an uploaded mesh.
        camera: Where the scene is seen from.
        lights: Lights.
        film: Exposure and tone curve.
        light_deg: Angle of the lights on their circle, in degrees.
        rotation_deg: Rotation of the mesh about x, y and z, in degrees.
        scale: Factor of the mesh's size.
        shadows: True if objects cast shadows.
        objects: Objects beside the one that is bred.
        backdrop: What is seen behind the object; None if nothing.
        ground: Level ground below the object; None if there is none.
    """

    id: str
    mesh: str
    camera: Mapping[str, Any] = field(hash=False)
    lights: tuple[Mapping[str, Any], ...] = field(hash=False)
    film: Mapping[str, Any] = field(hash=False)
    light_deg: float
    rotation_deg: tuple[float, float, float]
    scale: float
    shadows: bool = False
    objects: tuple[Mapping[str, Any], ...] = field(default=(), hash=False)
    backdrop: Mapping[str, Any] | None = field(default=None, hash=False)
    ground: Mapping[str, Any] | None = field(default=None, hash=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshWarning(Record):
    """Problem of an OBJ file that was read nevertheless.

    Attributes:
        line: Line of the file, from 1.
        text: Description.
    """

    line: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Mesh(Record):
    """Uploaded mesh.

    Attributes:
        id: Id of the mesh, for a scene's `mesh`.
        vertices: Number of vertices.
        triangles: Number of triangles.
        has_uv: True if the file has texture coordinates.
        warnings: Problems of the file.
    """

    nested: ClassVar[Mapping[str, type[Record]]] = {"warnings": MeshWarning}

    id: str
    vertices: int
    triangles: int
    has_uv: bool
    warnings: tuple[MeshWarning, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Asset(Record):
    """Uploaded profile, environment or image.

    Attributes:
        id: Id for a light's `profile` or `image`: the hash of the file.
        kind: `profile`, `environment` or `image`.
        width: Width of an image in pixels.
        height: Height of an image in pixels.
        lumens: Luminous flux of a profile in lumens.
        peak_candela: Largest luminous intensity of a profile in candela.
        mean_radiance: Mean radiance of an environment: red, green, blue.
    """

    id: str
    kind: str
    width: int | None = None
    height: int | None = None
    lumens: float | None = None
    peak_candela: float | None = None
    mean_radiance: tuple[float, float, float] | None = None
