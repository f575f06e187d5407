"""Lists: presets, formats of exports, and the instruction set in use."""

from __future__ import annotations

from typing import NamedTuple

from . import _native
from .material import Material

__all__ = ["ExportFormat", "Preset", "export_formats", "presets", "simd_level"]


class ExportFormat(NamedTuple):
    """Format of `Material.export`.

    Attributes:
        name: Name that `export` takes.
        label: Description.
        extension: Ending of file names, without the first dot.
        media_type: Value of `Content-Type`.
        is_binary: True if files are not text: `export_bytes` returns them.
    """

    name: str
    label: str
    extension: str
    media_type: str
    is_binary: bool


class Preset(NamedTuple):
    """Hand-written material.

    Attributes:
        name: Name that `Material.preset` takes.
        title: Title for people.
        words: Description of the look.
        text: Text of the genome, with comments.
    """

    name: str
    title: str
    words: str
    text: str

    @property
    def material(self) -> Material:
        """The material."""
        return Material(self.text)


def presets() -> list[Preset]:
    """Returns all presets, the simplest first."""
    return [Preset(*row) for row in _native.presets()]


def export_formats() -> list[ExportFormat]:
    """Returns the formats that materials are exported in."""
    return [ExportFormat(*row) for row in _native.export_formats()]


def simd_level() -> str:
    """Returns the instruction set that `Material.eval` uses: sse2, avx2, avx-512 or neon.

    All of them give the same bits.
    """
    return _native.simd_level()
