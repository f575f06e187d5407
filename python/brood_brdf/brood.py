"""Breeding: broods of children of none, one or two materials."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, overload

from . import _native
from .material import Material
from .scene import Scene, picture_options

__all__ = ["Brood", "breed", "cross", "mutate"]

# Side of the pictures of a sheet in notebooks, in pixels.
_SHOWN_PX = 96


class Brood(Sequence[Material]):
    """Children of a brood: a sequence of materials, shown as its sheet in notebooks.

    Attributes:
        parents: Parents, at most two; the first one is the centre of the sheet.
        seed: Seed that the children were drawn with; None for materials that were not bred.
    """

    __slots__ = ("_children", "parents", "seed")

    parents: tuple[Material, ...]
    seed: int | None

    def __init__(
        self,
        children: Iterable[Material],
        parents: Iterable[Material] = (),
        seed: int | None = None,
    ) -> None:
        """Makes a brood of given materials.

        Args:
            children: The materials.
            parents: Their parents.
            seed: Seed that they were drawn with.
        """
        self._children = tuple(children)
        self.parents = tuple(parents)
        self.seed = seed

    def __len__(self) -> int:
        """Returns the number of children."""
        return len(self._children)

    @overload
    def __getitem__(self, slot: int) -> Material: ...
    @overload
    def __getitem__(self, slot: slice) -> Brood: ...
    def __getitem__(self, slot: int | slice) -> Material | Brood:
        """Returns the child of a slot, from 0, or the brood of some slots.

        Args:
            slot: Index or slice.
        """
        if isinstance(slot, slice):
            return Brood(self._children[slot], self.parents, self.seed)
        return self._children[slot]

    def sheet(
        self,
        scene: Scene | None = None,
        size: int = 128,
        *,
        mesh: str | PathLike[str] | None = None,
        light_deg: float | None = None,
        samples: int | None = None,
        threads: int | None = None,
    ) -> bytes:
        """Renders all children and returns the bytes of one PNG file.

        Twenty children are placed around the first parent.

        Args:
            scene: Scene, as for `Material.render`.
            size: Side of each picture in pixels.
            mesh: Built-in mesh or path of an OBJ file.
            light_deg: Position of the lights on their circle in degrees.
            samples: Samples per pixel, 1 to 1024; by default adaptive.
            threads: Number of threads.
        """
        if not self._children:
            raise ValueError("an empty brood has no sheet")
        options = picture_options(
            scene, size, mesh=mesh, light_deg=light_deg, samples=samples, threads=threads
        )
        centre = self.parents[0] if self.parents else self._children[0]
        children = [child._native for child in self._children]
        return _native.sheet(children, centre._native, options)

    def __repr__(self) -> str:
        """Returns the number of children and the seed."""
        return f"<Brood of {len(self)}, seed {self.seed}>"

    def _repr_png_(self) -> bytes | None:
        """Returns the sheet for a notebook; None if there are no children."""
        return self.sheet(size=_SHOWN_PX) if self._children else None


def breed(
    parents: Material | Iterable[Material] = (),
    *,
    seed: int,
    count: int = 20,
    mutation: float = 0.3,
    recombination: float = 0.5,
    curation: str = "distinct",
    start: str | None = None,
    steer: Iterable[str] = (),
    saturation: float | None = None,
    energy_limit: bool | None = None,
    isotropic: bool | None = None,
    homogeneous: bool | None = None,
    bumps: bool | None = None,
    locks: Mapping[str, Any] | None = None,
    painting: Mapping[str, Any] | None = None,
    threads: int | None = None,
) -> Brood:
    """Breeds children. Equal arguments give equal children, on every machine.

    Without parents, children are random. With one, they are its mutants. With two, they are crossed
    and then mutated. The names and defaults are those of the HTTP API.

    Args:
        parents: None, one or two materials.
        seed: Seed, 0 to 2^64 - 1.
        count: Number of children, 1 to 256.
        mutation: Visible amount of mutation, from 0.02, just noticeable, to 1, unrelated.
        recombination: Expected share of the second parent in a child, 0 to 1.
        curation: `off`, `distinct` (redraw until the program is new) or `diverse` (redraw also
            until a preview is not black and differs from those of parents and siblings).
        start: Source of random children: `wild` (the default), `believable`, `models`, `painted`.
            With parents: `believable` varies parameters only.
        steer: Properties that children keep or change, compared with the first parent:
            `keep-colour`, `only-gloss`, `warmer`, `cooler`, `rougher`, `glossier`, `more-pattern`,
            `less-pattern`.
        saturation: Colour of the children, 0 grey to 1 as evolved; by default as the first parent.
        energy_limit: True for the energy limit; by default as the first parent.
        isotropic: True for children that do not change when turned about the normal.
        homogeneous: True for children that are the same everywhere on the surface.
        bumps: True for children with bumps, False for none; by default as their parents.
        locks: Parts of the first parent that children keep, such as `{"channels": ["r"]}`.
        painting: Colours of a picture for painted children, as the HTTP API describes them.
        threads: Number of threads.

    Raises:
        ValueError: If an argument is out of range, or does not fit the parents.
    """
    parents = (parents,) if isinstance(parents, Material) else tuple(parents)
    constraints = {"isotropic": isotropic, "homogeneous": homogeneous, "bumps": bumps}
    optional = {
        "saturation": saturation,
        "energy_limit": energy_limit,
        "locks": None if locks is None else dict(locks),
        "painting": None if painting is None else dict(painting),
    }
    options = {
        "mutation": mutation,
        "recombination": recombination,
        "curation": curation,
        "constraints": {name: each for name, each in constraints.items() if each is not None},
        "steer": list(steer),
        **{name: each for name, each in optional.items() if each is not None},
    }
    natives = [parent._native for parent in parents]
    children = _native.breed(natives, count, seed, start, json.dumps(options), threads)
    return Brood(map(Material._of, children), parents, seed)


def mutate(material: Material, amount: float = 0.3, *, seed: int) -> Material:
    """Returns one mutant of a material: the first child of `breed` with the same seed.

    Args:
        material: The parent.
        amount: Visible amount of mutation, from 0.02, just noticeable, to 1, unrelated.
        seed: Seed, 0 to 2^64 - 1.
    """
    return breed(material, seed=seed, count=1, mutation=amount)[0]


def cross(
    first: Material,
    second: Material,
    share: float = 0.5,
    *,
    seed: int,
    mutation: float = 0.0,
) -> Material:
    """Returns one child of two materials: the first child of `breed` with the same seed.

    Args:
        first: First parent.
        second: Second parent, of a compatible dialect.
        share: Expected share of the second parent, 0 to 1.
        seed: Seed, 0 to 2^64 - 1.
        mutation: Visible amount of mutation after crossing, 0 to 1.
    """
    parents = (first, second)
    return breed(parents, seed=seed, count=1, mutation=mutation, recombination=share)[0]
