"""Scenes and sizes of pictures."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from . import _native

__all__ = ["Scene", "Size", "picture_options"]

Scene = Mapping[str, Any] | str | PathLike[str]
"""Scene as the HTTP API describes it: fields, JSON text, or the path of a JSON file."""

Size = int | tuple[int, int]
"""Side of a square picture, or width and height, in pixels: 1 to 4096."""

_BUILT_IN = ("ball", "sphere", "torus", "cube", "knob")


def picture_options(
    scene: Scene | None,
    size: Size,
    *,
    mesh: str | PathLike[str] | None = None,
    light_deg: float | None = None,
    samples: int | None = None,
    threads: int | None = None,
) -> _native.PictureOptions:
    """Returns the options of the native renderer.

    Args:
        scene: Scene; by default a ball with one light.
        size: Size of the picture in pixels.
        mesh: Built-in mesh (ball, sphere, torus, cube, knob) or path of an OBJ file.
        light_deg: Position of the lights on their circle in degrees.
        samples: Samples per pixel, 1 to 1024; by default adaptive.
        threads: Number of threads.
    """
    fields = _fields(scene)
    obj: bytes | None = None
    if mesh is not None:
        if isinstance(mesh, str) and mesh in _BUILT_IN:
            fields["mesh"] = mesh
        else:
            obj = Path(mesh).read_bytes()
    if light_deg is not None:
        fields["light_deg"] = light_deg
    width, height = (size, size) if isinstance(size, int) else size
    return {
        "scene": json.dumps(fields),
        "mesh": obj,
        "size": (width, height),
        "samples": samples,
        "threads": threads,
    }


def _fields(scene: Scene | None) -> dict[str, Any]:
    if scene is None:
        return {}
    if isinstance(scene, Mapping):
        return dict(scene)
    text = scene if isinstance(scene, str) else Path(scene).read_text("utf-8")
    try:
        fields = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"`scene` is no JSON: {error}") from None
    if not isinstance(fields, dict):
        raise ValueError("`scene` must be a JSON object")
    return fields
