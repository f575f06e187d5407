"""Native part of the package: see the classes that use it for documentation."""

from collections.abc import Callable
from typing import TypedDict

import numpy as np
import numpy.typing as npt

from .array import Floats

class PictureOptions(TypedDict):
    """Options of a picture."""

    scene: str
    mesh: bytes | None
    size: tuple[int, int]
    samples: int | None
    threads: int | None

class FitOptions(TypedDict):
    """Options of a search."""

    strategy: str
    seed: int
    mirrored: bool
    objective: str | None
    models: list[str]
    generations: int | None
    seconds: float | None
    threads: int | None

class NativeMaterial:
    """Genome with its program."""

    @staticmethod
    def parse(text: str) -> NativeMaterial: ...
    @staticmethod
    def decode(bytes: bytes) -> NativeMaterial: ...
    def encode(self) -> bytes: ...
    def text(self) -> str: ...
    def json(self) -> str: ...
    @property
    def hash(self) -> str: ...
    @property
    def program_hash(self) -> str: ...
    @property
    def operations(self) -> int: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def is_painted(self) -> bool: ...
    @property
    def has_brdf(self) -> bool: ...
    @property
    def is_limited(self) -> bool: ...
    @property
    def is_anisotropic(self) -> bool: ...
    @property
    def is_textured(self) -> bool: ...
    def with_limit(self, limited: bool) -> NativeMaterial: ...
    def largest_albedo(self) -> tuple[float, float]: ...

class NativeTarget:
    """Material to match."""

    @staticmethod
    def of_samples(wi: Floats, wo: Floats, f: Floats) -> NativeTarget: ...
    @staticmethod
    def of_file(extension: str, bytes: bytes) -> NativeTarget: ...
    @property
    def counts(self) -> tuple[int, int, int]: ...

class NativeEvolution:
    """Ask-tell search."""

    def __init__(
        self,
        start: list[NativeMaterial],
        seed: int,
        count: int,
        kept: int,
        checkpoint: bytes | None,
    ) -> None: ...
    def ask(self) -> list[NativeMaterial]: ...
    def tell(self, errors: list[float]) -> None: ...
    @property
    def counts(self) -> tuple[int, int]: ...
    @property
    def probe(self) -> tuple[float, float]: ...
    @property
    def best(self) -> tuple[NativeMaterial, float, int] | None: ...
    @property
    def front(self) -> list[tuple[NativeMaterial, float, int]]: ...
    def checkpoint(self) -> bytes: ...

def presets() -> list[tuple[str, str, str, str]]: ...
def export_formats() -> list[tuple[str, str, str, str, bool]]: ...
def simd_level() -> str: ...
def eval(
    material: NativeMaterial,
    wi: Floats,
    wo: Floats,
    uv: Floats | None,
    precise: bool,
    threads: int | None,
) -> Floats: ...
def albedo(
    material: NativeMaterial, wi: Floats, uv: Floats | None, order: int, threads: int | None
) -> npt.NDArray[np.float64]: ...
def pdf(
    material: NativeMaterial, wi: Floats, wo: Floats, threads: int | None
) -> npt.NDArray[np.float64]: ...
def sample(
    material: NativeMaterial, wo: Floats, random: Floats, threads: int | None
) -> npt.NDArray[np.float64]: ...
def sampling_quality(material: NativeMaterial) -> tuple[float, float, float]: ...
def export(
    material: NativeMaterial, format: str, limit: bool | None, lights: int
) -> tuple[bytes, str | None]: ...
def breed(
    parents: list[NativeMaterial],
    count: int,
    seed: int,
    start: str | None,
    options: str,
    threads: int | None,
) -> list[NativeMaterial]: ...
def fit(
    target: NativeTarget,
    start: list[NativeMaterial],
    options: FitOptions,
    progress: Callable[[tuple[int, int, float, float]], object] | None,
) -> tuple[
    list[tuple[NativeMaterial, int, int, tuple[float, float, float, float], float]],
    int,
    tuple[int, int, float, float],
]: ...
def picture(material: NativeMaterial, options: PictureOptions, linear: bool) -> bytes: ...
def pixels(material: NativeMaterial, options: PictureOptions) -> npt.NDArray[np.uint8]: ...
def radiance(material: NativeMaterial, options: PictureOptions) -> npt.NDArray[np.float32]: ...
def sheet(
    materials: list[NativeMaterial], centre: NativeMaterial | None, options: PictureOptions
) -> bytes: ...
