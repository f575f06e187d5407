"""Broods, fits, and searches with errors measured in Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from brood_brdf import (
    Brood,
    Evolution,
    Fit,
    FitProgress,
    Material,
    Target,
    breed,
    cross,
    fit,
    mutate,
)
from test_material import PNG, directions

GOLD = Material.preset("gold")


def test_brood_depends_only_on_its_arguments() -> None:
    brood = breed(GOLD, seed=1)
    assert len(brood) == 20 and len(set(brood)) == 20
    assert list(brood) == list(breed([GOLD], seed=1, threads=1))
    assert list(breed(GOLD, seed=1, count=5)) == list(brood[:5])
    assert brood[0] != breed(GOLD, seed=2)[0] and brood[-1] == brood[19]
    assert mutate(GOLD, seed=1) == brood[0] and brood.parents == (GOLD,) and brood.seed == 1
    crossed = breed([brood[0], brood[1]], seed=3, count=4, mutation=0.1)
    assert crossed[0] == cross(brood[0], brood[1], seed=3, mutation=0.1)


def test_random_broods_have_their_start() -> None:
    for start in ["wild", "believable", "models", "painted"]:
        brood = breed(seed=1, start=start, count=3)
        assert [child.is_painted for child in brood] == [start == "painted"] * 3
    assert all(child.is_limited for child in breed(seed=2, count=3, energy_limit=True))
    bumpy = breed(seed=2, count=3, bumps=True, isotropic=True, curation="diverse")
    assert all(".bump" in child.text() for child in bumpy)
    locked = breed(GOLD, seed=4, count=3, steer=["keep-colour", "glossier"])
    assert len(locked) == 3


def test_errors_of_breeding_name_the_argument() -> None:
    for arguments, words in [
        ({"count": 0}, "`count` must be 1 to 256"),
        ({"mutation": 1.5}, "`mutation` must be between 0 and 1"),
        ({"mutation": 0.0, "parents": GOLD}, "`mutation` must be above 0"),
        ({"parents": [GOLD] * 3}, "at most 2 parents"),
        ({"start": "foo"}, "`start` must be one of"),
        ({"curation": "foo"}, "unknown variant `foo`"),
        ({"locks": {}}, "`locks` needs a parent"),
        ({"steer": ["warmer"]}, "steer"),
    ]:
        with pytest.raises(ValueError, match=words):
            breed(seed=1, **arguments)  # type: ignore[arg-type]
    with pytest.raises(OverflowError):
        breed(seed=-1)


def test_sheet_is_a_picture() -> None:
    brood = breed(GOLD, seed=1)
    assert brood.sheet(size=16).startswith(PNG)
    small = brood[:3]
    assert isinstance(small, Brood) and (small._repr_png_() or b"").startswith(PNG)
    assert brood[:0]._repr_png_() is None


@pytest.fixture(scope="module")
def target() -> Target:
    """Samples of a material that a model describes."""
    wi, wo = directions(600, 1), directions(600, 2)
    glossy = Material("brood 1\n.model conductor\nroughness 0.3\n")
    return Target(wi, wo, glossy.eval(wi, wo))


def test_fit_finds_a_model(target: Target) -> None:
    assert (target.fitted, target.held_out, target.skipped) == (480, 120, 0)
    seen: list[FitProgress] = []
    arguments = {"strategy": "analytic", "generations": 2, "seed": 3}
    found = fit(target, progress=seen.append, **arguments)  # type: ignore[arg-type]
    assert isinstance(found, Fit) and found.best.error < 0.02 and found.best in found.front
    assert [each.generation for each in seen] == [1, 2] == [1, found.progress.generation]
    again = fit(target, threads=1, **arguments)  # type: ignore[arg-type]
    assert [each.material for each in again] == [each.material for each in found]
    assert found.best.material.is_limited and found.best._repr_png_().startswith(PNG)
    assert (found._repr_png_() or b"").startswith(PNG)


def test_fit_stops_when_progress_fails(target: Target) -> None:
    def stop(_: FitProgress) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit(target, seconds=100, progress=stop)
    for arguments, words in [
        ({"strategy": "foo"}, "foo|strategy|must be"),
        ({"models": ["lambert"]}, "`models` needs the strategy"),
        ({"generations": 0}, "`generations`"),
        ({"seconds": 0}, "`seconds`"),
    ]:
        with pytest.raises(ValueError, match=words):
            fit(target, **arguments)  # type: ignore[arg-type]


def test_target_is_read_from_a_file(tmp_path: Path) -> None:
    wi, wo = directions(200, 1), directions(200, 2)
    table = np.hstack([wi, wo, GOLD.eval(wi, wo)])
    head = "wix,wiy,wiz,wox,woy,woz,r,g,b"
    np.savetxt(tmp_path / "gold.csv", table, delimiter=",", header=head, comments="")
    assert Target.read(tmp_path / "gold.csv").fitted == 160
    with pytest.raises(ValueError, match="column wix"):
        (tmp_path / "bad.csv").write_text("r,g,b\n", "utf-8")
        Target.read(tmp_path / "bad.csv")
    with pytest.raises(ValueError, match=r"got \.txt"):
        (tmp_path / "a.txt").write_text("", "utf-8")
        Target.read(tmp_path / "a.txt")
    with pytest.raises(ValueError, match="at least"):
        Target(wi[:5], wo[:5], np.ones((5, 3)))


def test_evolution_asks_and_tells() -> None:
    wi, wo = directions(64, 3), directions(64, 4)
    wanted = np.array([0.3, 0.2, 0.1])

    def error(material: Material) -> float:
        return float(np.abs(material.eval(wi, wo) - wanted).mean())

    es = Evolution(seed=1, count=8, kept=8)
    first = list(es.ask())
    assert len(first) == 8 and first == list(es.ask())
    es.tell(first[::-1], [error(material) for material in first[::-1]])
    state = es.checkpoint()
    es.optimize(error, iterations=6)
    assert es.stop(iterations=6) == {"iterations": 6} and es.stop(error=-1.0) == {}
    resumed = Evolution(seed=1, count=8, kept=8, checkpoint=state).optimize(error, iterations=6)
    assert resumed.result == es.result and es.result.evaluations == 48
    best = es.best
    assert best is not None and best.error == es.result.fbest == error(best.material)
    assert min(each.error for each in es.front) == best.error and 0 <= es.diversity <= 1
    assert (es._repr_png_() or b"").startswith(PNG)


def test_evolution_starts_from_materials_and_refuses_others() -> None:
    es = Evolution(GOLD, count=4)
    materials = es.ask()
    assert materials[0] == GOLD
    with pytest.raises(ValueError, match="is not one of the materials"):
        es.tell([Material.preset("marble")] * 4, [1.0] * 4)
    with pytest.raises(ValueError, match="NaN"):
        es.tell(materials, [float("nan")] * 4)
    with pytest.raises(ValueError, match="4 materials and 3 errors"):
        es.tell(materials, [1.0] * 3)
    es.tell(materials, [float("inf")] * 4)
    assert es.best is None and es.result.xbest is None
    with pytest.raises(ValueError, match="checkpoint"):
        Evolution(seed=1, checkpoint=b"x")
