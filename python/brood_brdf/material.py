"""Materials: reading, evaluation, sampling, pictures and exports."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _native
from ._native import NativeMaterial
from .array import Floats, matched, rows
from .error import GenomeError
from .sampling import Sampled, SamplingQuality
from .scene import Scene, Size, picture_options

__all__ = ["Material", "Readable", "Source"]

# Side of the pictures in notebooks, in pixels.
_SHOWN_PX = 256
# First line of canonical bytes.
_CANONICAL = b"brood genome 1\n"


class Readable(Protocol):
    """File that is open for reading, as text or binary."""

    def read(self) -> str | bytes:
        """Returns the rest of the file."""
        ...


Source = str | bytes | Mapping[str, Any] | PathLike[str] | Readable
"""Genome as text, as JSON, as canonical bytes, or in a file."""


class Material:
    """Material: a genome, a small program that computes a BRDF, or a painted material.

    Directions are unit vectors that point away from the surface, in the local frame: z is the
    normal, x the tangent along u. `wi` points to the light, `wo` to the eye. Materials do not
    change; equal genomes are equal, and can be keys of dictionaries. Methods release Python's lock.
    """

    __slots__ = ("__weakref__", "_native")

    _native: NativeMaterial

    def __init__(self, source: Source) -> None:
        """Reads a genome.

        Args:
            source: Text or JSON as `str`, or in a mapping; bytes of text, of JSON or of
                `canonical_bytes`; the path of a file (`pathlib.Path`), or an open file.

        Raises:
            GenomeError: If it is no genome; the error has the line and column, or a JSON pointer.
        """
        self._native = _parsed(_content(source))

    @classmethod
    def preset(cls, name: str) -> Material:
        """Returns a preset.

        Args:
            name: Name of a preset of `presets`, such as `gold`.
        """
        known = {row[0]: row[3] for row in _native.presets()}
        if name not in known:
            raise ValueError(f"no preset is named {name}; presets are: {', '.join(known)}")
        return cls(known[name])

    @classmethod
    def _of(cls, native: NativeMaterial) -> Material:
        new = cls.__new__(cls)
        new._native = native
        return new

    def text(self) -> str:
        """Returns the genome as text."""
        return self._native.text()

    def json(self) -> dict[str, Any]:
        """Returns the genome as JSON: dictionaries, lists and numbers."""
        genome: dict[str, Any] = json.loads(self._native.json())
        return genome

    def canonical_bytes(self) -> bytes:
        """Returns the shortest form of the genome, of which `hash` is the hash."""
        return self._native.encode()

    @property
    def hash(self) -> str:
        """Content hash of the genome: 64 hexadecimal digits."""
        return self._native.hash

    @property
    def program_hash(self) -> str:
        """Hash of what the genome computes: equal for genomes that differ in dead code only."""
        return self._native.program_hash

    @property
    def operations(self) -> int:
        """Number of scalar operations per sample."""
        return self._native.operations

    @property
    def inputs(self) -> list[str]:
        """Names of the inputs that the program reads."""
        return self._native.inputs

    @property
    def is_painted(self) -> bool:
        """True if the material has colours as a display shows them, and no or not only a BRDF."""
        return self._native.is_painted

    @property
    def has_brdf(self) -> bool:
        """True if the material has a BRDF: `eval`, `sample` and `albedo` work."""
        return self._native.has_brdf

    @property
    def is_limited(self) -> bool:
        """True if the energy limit is on: no more light is reflected than arrives.

        Bumps are ignored: the limit is about the normal that they turn.
        """
        return self._native.is_limited

    @property
    def is_anisotropic(self) -> bool:
        """True if f changes when the surface turns about its normal."""
        return self._native.is_anisotropic

    @property
    def is_textured(self) -> bool:
        """True if f changes over the surface."""
        return self._native.is_textured

    def limited(self, limit: bool = True) -> Material:
        """Returns the material with the energy limit on or off.

        Args:
            limit: True for on.
        """
        return Material._of(self._native.with_limit(limit))

    def eval(
        self,
        wi: npt.ArrayLike,
        wo: npt.ArrayLike,
        uv: npt.ArrayLike | None = None,
        *,
        precise: bool = False,
        threads: int | None = None,
    ) -> Floats:
        """Returns f for pairs of directions, without the cosine, in 1/sr.

        Arrays of float32 or float64 that are C-contiguous are not copied. f is 0 unless both
        directions are above the surface (z > 0).

        Args:
            wi: Directions to the light, shape (N, 3), or (3,) for all samples. Lengths must be 1
                within 0.001.
            wo: Directions to the eye, shape (N, 3) or (3,).
            uv: Texture positions, shape (N, 2) or (2,), 1 per repeat of the texture; by default 0.
            precise: True for the reference in float64, which is slower: it measures the error of
                the canonical float32.
            threads: Number of threads; by default `$RAYON_NUM_THREADS`, or one per core.

        Returns:
            Linear red, green and blue, float32 (float64 if precise) of shape (N, 3).

        Raises:
            ValueError: If a shape is wrong, or a direction is not finite or not of length 1; the
                error names the first row. Also for painted materials.
        """
        wi, wo = rows("wi", wi, 3), rows("wo", wo, 3)
        uv = None if uv is None else rows("uv", uv, 2)
        matched(wi=wi, wo=wo, uv=uv)
        return _native.eval(self._native, wi, wo, uv, precise, threads)

    def pdf(
        self,
        wi: npt.ArrayLike,
        wo: npt.ArrayLike,
        *,
        threads: int | None = None,
    ) -> npt.NDArray[np.float64]:
        """Returns the density with which `sample` draws directions to the light, in 1/sr.

        It integrates to 1 over the sphere: `sample` also draws directions below the surface, for
        which 0 is returned.

        Args:
            wi: Directions to the light, shape (N, 3) or (3,).
            wo: Directions to the eye, shape (N, 3) or (3,).
            threads: Number of threads.

        Returns:
            Densities, float64 of shape (N,).
        """
        wi, wo = rows("wi", wi, 3), rows("wo", wo, 3)
        matched(wi=wi, wo=wo)
        return _native.pdf(self._native, wi, wo, threads)

    def sample(
        self,
        wo: npt.ArrayLike,
        random: npt.ArrayLike | int,
        uv: npt.ArrayLike | None = None,
        *,
        threads: int | None = None,
    ) -> Sampled:
        """Draws directions to the light, in proportion to what is reflected to the eye.

        The first call makes a table, which takes up to seconds for anisotropic materials. The table
        is the one in Mitsuba plugins, see `sampling_quality`.

        Args:
            wo: Directions to the eye, shape (N, 3) or (3,).
            random: Random numbers in [0, 1), shape (N, 3); or a seed, which draws one sample per
                direction.
            uv: Texture positions for the weights, shape (N, 2) or (2,).
            threads: Number of threads.
        """
        wo = rows("wo", wo, 3)
        if isinstance(random, int | np.integer):
            random = np.random.default_rng(int(random)).random((len(wo), 3))
        random = rows("random", random, 3)
        places = None if uv is None else rows("uv", uv, 2)
        given = {} if places is None else {"uv": places}
        count = matched(wo=wo, random=random, **given)
        if len(random) < count:
            raise ValueError(f"`random` must have a row for each of {count} samples")
        wi = _native.sample(self._native, wo, random, threads)
        pdf = self.pdf(wi, wo, threads=threads)
        f = self.eval(wi, wo, places, threads=threads)
        weight = np.zeros(f.shape, np.float32)
        lit = pdf > 0
        weight[lit] = f[lit] * (wi[lit, 2] / pdf[lit])[:, None]
        return Sampled(wi, pdf, weight)

    @property
    def sampling_quality(self) -> SamplingQuality:
        """Quality of `sample`, measured when its table is made."""
        return SamplingQuality(*_native.sampling_quality(self._native))

    def albedo(
        self,
        wi: npt.ArrayLike = (0.0, 0.0, 1.0),
        uv: npt.ArrayLike | None = None,
        *,
        order: int = 32,
        threads: int | None = None,
    ) -> npt.NDArray[np.float64]:
        """Returns the directional albedo: the share of light from `wi` that is reflected.

        Bumps are ignored: `wi` is about the normal that they turn.

        Args:
            wi: Directions to the light, shape (N, 3) or (3,).
            uv: Texture positions, shape (N, 2) or (2,); by default 0.
            order: Order of the quadrature, 4 to 512: 2 order^2 evaluations for each direction.
            threads: Number of threads.

        Returns:
            Shares of red, green and blue, float64 of shape (N, 3); 0 below the surface.
        """
        if not 4 <= order <= 512:
            raise ValueError(f"`order` must be 4 to 512, got {order}")
        wi = rows("wi", wi, 3)
        uv = None if uv is None else rows("uv", uv, 2)
        matched(wi=wi, uv=uv)
        return _native.albedo(self._native, wi, uv, order, threads)

    def largest_albedo(self) -> float:
        """Returns an upper bound of the directional albedo.

        It holds over all directions, channels and texture positions, as far as a search finds them,
        about the normal that bumps turn.
        """
        return self._native.largest_albedo()[0]

    def render(
        self,
        scene: Scene | None = None,
        size: Size = 256,
        *,
        mesh: str | PathLike[str] | None = None,
        light_deg: float | None = None,
        samples: int | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.uint8]:
        """Renders a picture as a display shows it, on the CPU; the bits are those of a server.

        Args:
            scene: Scene as the HTTP API describes it (`POST /v1/scenes`): a mapping, JSON text or
                the path of a JSON file; by default a ball with one light. Scenes whose lights are
                files (profiles, environments) need a server.
            size: Side of a square picture, or (width, height), in pixels.
            mesh: Built-in mesh (ball, sphere, torus, cube, knob) or path of an OBJ file.
            light_deg: Position of the lights on their circle in degrees.
            samples: Samples per pixel, 1 to 1024; by default adaptive.
            threads: Number of threads.

        Returns:
            Codes of red, green, blue and alpha (sRGB), uint8 of shape (height, width, 4).
        """
        options = picture_options(
            scene, size, mesh=mesh, light_deg=light_deg, samples=samples, threads=threads
        )
        return _native.pixels(self._native, options)

    def radiance(
        self,
        scene: Scene | None = None,
        size: Size = 256,
        *,
        mesh: str | PathLike[str] | None = None,
        light_deg: float | None = None,
        samples: int | None = None,
        threads: int | None = None,
    ) -> npt.NDArray[np.float32]:
        """Renders a linear picture, before exposure and tone curve, over black.

        The arguments are those of `render`.

        Returns:
            Radiance of red, green and blue in W/(m^2 sr), float32 of shape (height, width, 3).
        """
        options = picture_options(
            scene, size, mesh=mesh, light_deg=light_deg, samples=samples, threads=threads
        )
        return _native.radiance(self._native, options)

    def png(
        self,
        scene: Scene | None = None,
        size: Size = 256,
        *,
        mesh: str | PathLike[str] | None = None,
        light_deg: float | None = None,
        samples: int | None = None,
        threads: int | None = None,
    ) -> bytes:
        """Renders a picture and returns the bytes of a PNG file.

        The arguments are those of `render`.
        """
        options = picture_options(
            scene, size, mesh=mesh, light_deg=light_deg, samples=samples, threads=threads
        )
        return _native.picture(self._native, options, False)

    def exr(
        self,
        scene: Scene | None = None,
        size: Size = 256,
        *,
        mesh: str | PathLike[str] | None = None,
        light_deg: float | None = None,
        samples: int | None = None,
        threads: int | None = None,
    ) -> bytes:
        """Renders a linear picture and returns the bytes of an EXR file.

        The arguments are those of `render`.
        """
        options = picture_options(
            scene, size, mesh=mesh, light_deg=light_deg, samples=samples, threads=threads
        )
        return _native.picture(self._native, options, True)

    def export(self, format: str, *, energy_limit: bool | None = None, lights: int = 1) -> str:
        """Returns the material in a format of other renderers, as text.

        Args:
            format: Name of a format of `export_formats`, such as `wgsl` or `mitsuba`.
            energy_limit: True for the energy limit; by default on in formats for path tracers,
                in others as in the genome.
            lights: Number of lights of a painted material, 1 to 8.

        Raises:
            ValueError: If the format is unknown or binary, or cannot carry the material.
        """
        binary = {row[0] for row in _native.export_formats() if row[4]}
        if format in binary:
            raise ValueError(f"{format} is a binary format: use `export_bytes`")
        return self.export_bytes(format, energy_limit=energy_limit, lights=lights).decode("utf-8")

    def export_bytes(
        self, format: str, *, energy_limit: bool | None = None, lights: int = 1
    ) -> bytes:
        """Returns the material in a format of other renderers, as the bytes of a file.

        The arguments are those of `export`.
        """
        return _native.export(self._native, format, energy_limit, lights)[0]

    def export_note(
        self, format: str, *, energy_limit: bool | None = None, lights: int = 1
    ) -> str | None:
        """Returns what a table holds and how far it is from the material; None for code.

        The arguments are those of `export`.
        """
        return _native.export(self._native, format, energy_limit, lights)[1]

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the genome as text.

        Args:
            path: Path of the file, by custom with the ending `.brood`.
        """
        Path(path).write_text(self.text(), "utf-8", newline="\n")

    def __eq__(self, other: object) -> bool:
        """Returns True if both have the same genome."""
        return isinstance(other, Material) and self.hash == other.hash

    def __hash__(self) -> int:
        """Returns a hash of the genome."""
        return int(self.hash[:15], 16)

    def __reduce__(self) -> tuple[Callable[[bytes], Material], tuple[bytes]]:
        """Returns the state for `pickle` and `copy`."""
        return (Material, (self.canonical_bytes(),))

    def __repr__(self) -> str:
        """Returns the beginning of the hash and the number of operations."""
        return f"<Material {self.hash[:8]}, {self.operations} operations>"

    def __str__(self) -> str:
        """Returns the genome as text."""
        return self.text()

    def _repr_png_(self) -> bytes:
        """Returns a picture for a notebook."""
        return self.png(size=_SHOWN_PX)


def _content(source: Source) -> str | bytes:
    if isinstance(source, str | bytes):
        return source
    if isinstance(source, PathLike):
        return Path(source).read_bytes()
    if isinstance(source, Mapping):
        return json.dumps(source)
    if hasattr(source, "read"):
        return source.read()
    kind = type(source).__name__
    raise TypeError(f"`source` must be text, bytes, a mapping or a file, got {kind}")


def _parsed(source: str | bytes) -> NativeMaterial:
    if isinstance(source, bytes):
        if source.startswith(_CANONICAL):
            return NativeMaterial.decode(source)
        try:
            source = source.decode("utf-8")
        except UnicodeDecodeError as error:
            raise GenomeError(f"a genome must be UTF-8 text: {error}") from None
    return NativeMaterial.parse(source)
