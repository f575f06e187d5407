"""Targets of searches: measurements, and pictures of a known scene."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from .call import Call, File, Listing, Ref, bytes_of, given, id_of, path_of
from .genome import Size, size_text
from .record import Method, Record, listing, nothing, read_bytes, record_of

__all__ = ["Target"]


def upload_target(
    kind: str,
    file: File,
    *,
    name: str | None = None,
    scene: Mapping[str, Any] | Ref | None = None,
    mask: File | None = None,
    gain: bool | None = None,
    samples: int | str | None = None,
    clip_from: int | str | None = None,
    crop: tuple[int, int, int, int] | None = None,
    refine: Mapping[str, float] | None = None,
) -> Call[Target]:
    """Uploads a measurement or a picture of a known scene.

    Args:
        kind: `samples` (CSV), `slice` (EXR), `merl`, `rgl`, `cornell` or `image`.
        file: Bytes, or the path of a file; at most 64 MiB.
        name: Display name, at most 200 characters.
        scene: Scene of an image, as JSON or stored; by default the default scene.
        mask: Picture of the size of an image, white where pixels count.
        gain: True if the brightness of an image is unknown.
        samples: Samples per pixel of an image, 1 to 64, or `adaptive`, the default.
        clip_from: Code from which a channel of an image is clipped: `auto`, `off` or 1 to 255.
        crop: Part of an image to use: first column, first row, width, height, in pixels.
        refine: Standard deviations within which searches correct the scene of an image, such as
            `{"light_deg": 2, "camera_deg": 1, "fov": 0.01}`.
    """
    spec = given(
        kind=kind,
        name=name,
        scene=_scene_of(scene),
        gain=gain,
        samples=samples,
        clip_from=clip_from,
        crop=None if crop is None else list(crop),
        refine=None if refine is None else dict(refine),
    )
    parts = [("file", bytes_of(file))]
    if mask is not None:
        parts.append(("mask", bytes_of(mask)))
    return _upload(spec, parts)


def upload_views(
    views: Sequence[Mapping[str, Any]], files: Mapping[str, File], *, name: str | None = None
) -> Call[Target]:
    """Uploads several pictures of one material.

    Args:
        views: 1 to 16 views as JSON, such as `{"picture": "a", "scene": {...}, "held_out": True}`;
            `picture` and `mask` are names in `files`.
        files: Pictures and masks by name, as bytes or paths of files.
        name: Display name, at most 200 characters.
    """
    spec = given(kind="image", name=name, views=[dict(view) for view in views])
    return _upload(spec, [(part, bytes_of(file)) for part, file in files.items()])


def _scene_of(scene: Mapping[str, Any] | Ref | None) -> Any:
    if scene is None:
        return None
    return dict(scene) if isinstance(scene, Mapping) else id_of(scene)


def _upload(spec: Mapping[str, Any], parts: Sequence[tuple[str, bytes]]) -> Call[Target]:
    files = [("spec", json.dumps(spec).encode("utf-8")), *parts]
    return Call("POST", "/v1/targets", record_of(Target), files=files)


def target(target: Ref) -> Call[Target]:
    """Returns a target."""
    return Call("GET", path_of("targets", id_of(target)), record_of(Target))


def targets(*, page_size: int | None = None) -> Listing[Target]:
    """Lists the targets, newest first."""
    return listing(Target, "/v1/targets", page_size)


def delete_target(target: Ref) -> Call[None]:
    """Deletes a target; fails with `Conflict` while an unfinished search uses it."""
    return Call("DELETE", path_of("targets", id_of(target)), nothing)


def target_picture(
    target: Ref,
    size: Size | None = None,
    *,
    scene: Ref | None = None,
    light_deg: float | None = None,
    exposure_ev: float | None = None,
    view: int | None = None,
) -> Call[bytes]:
    """Returns a measured material drawn in a scene, or an image of the target, as PNG.

    Args:
        target: The target.
        size: Side in pixels, or width and height; of measurements only, by default 256.
        scene: Scene to render; of measurements only, by default the default scene.
        light_deg: Angle of the lights on their circle, in degrees; of measurements only.
        exposure_ev: Exposure in EV; of measurements only.
        view: Index of the image, from 0; of images only.
    """
    query = given(
        size=size_text(size),
        scene=None if scene is None else id_of(scene),
        light_deg=light_deg,
        exposure_ev=exposure_ev,
        view=view,
    )
    path = path_of("targets", id_of(target), "render.png")
    return Call("GET", path, read_bytes, query=query)


def target_view(target: Ref, view: int = 0, layer: str = "pixels") -> Call[bytes]:
    """Returns how an image was read, as PNG.

    Args:
        target: The target.
        view: Index of the image, from 0.
        layer: `picture`; `mask`; `scene`, the scene in grey; `corrected`, the same as corrected by
            a search; or `pixels`, coloured by use.
    """
    name, query = ("scene", {"corrected": "true"}) if layer == "corrected" else (layer, {})
    path = path_of("targets", id_of(target), "views", str(view), f"{name}.png")
    return Call("GET", path, read_bytes, query=query)


@dataclass(frozen=True, slots=True, kw_only=True)
class Target(Record):
    """Target of searches. In a notebook, it is shown as its picture.

    Attributes:
        id: Id of the target.
        kind: `samples`, `slice`, `merl`, `rgl`, `cornell` or `image`.
        name: Display name.
        hash: Content hash.
        size_bytes: Size in bytes.
        samples: Number of samples, fitted and held out.
        fitted_samples: Number of samples that searches fit.
        held_out_samples: Number of samples that errors are measured on.
        skipped_samples: Number of samples with a direction below the surface.
        largest_f: Largest fitted reflectance f, per steradian.
        created_ms: Creation time, in milliseconds since 1970-01-01 UTC.
        largest_albedo: Largest directional albedo and its angle; None if not known.
        reciprocal_floor: Least E_log of a reciprocal isotropic material on f as measured;
            None if no pair was measured in both orders or repeated.
        views: Images as JSON, in the order of the upload.
    """

    renamed: ClassVar[Mapping[str, str]] = {"bytes": "size_bytes"}

    id: str
    kind: str
    name: str
    hash: str = field(repr=False)
    size_bytes: int
    samples: int
    fitted_samples: int
    held_out_samples: int
    skipped_samples: int
    largest_f: float
    created_ms: int = field(repr=False)
    largest_albedo: Mapping[str, Any] | None = field(default=None, hash=False)
    reciprocal_floor: float | None = None
    views: tuple[Mapping[str, Any], ...] = field(default=(), hash=False, repr=False)

    delete = Method(delete_target)
    picture = Method(target_picture)
    view = Method(target_view)

    def _repr_png_(self) -> bytes | None:
        """Returns the picture for a notebook; None without an open synchronous client."""
        client = self._shown_by
        return None if client is None else target_picture(self).sync(client)
