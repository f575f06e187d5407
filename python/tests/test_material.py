"""Reading, evaluation, sampling, albedo, pictures and exports of materials."""

from __future__ import annotations

import copy
import io
import json
import pickle
import struct
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from brood_brdf import GenomeError, Material, export_formats, presets, simd_level

TEXT = "brood 1\n.dialect paper smooth registers 7\nSIN R0.xy, R0.x\n"
LAMBERT = Material("brood 1\n.model lambert\nalbedo 0.25 0.5 0.75\n")
PNG = b"\x89PNG\r\n\x1a\n"
Rows = npt.NDArray[np.float64]


def directions(count: int, seed: int, lowest: float = 0.05) -> Rows:
    """Returns directions above the surface, even on the hemisphere."""
    random = np.random.default_rng(seed).random((2, count))
    z = lowest + (1 - lowest) * random[0]
    radius, azimuth = np.sqrt(1 - z * z), 2 * np.pi * random[1]
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=1)


def test_material_is_read_from_every_form(tmp_path: Path) -> None:
    material = Material(TEXT)
    path = tmp_path / "a.brood"
    material.save(path)
    forms = [
        TEXT.encode(),
        json.dumps(material.json()),
        material.json(),
        material.canonical_bytes(),
        path,
        io.StringIO(TEXT),
        io.BytesIO(material.canonical_bytes()),
    ]
    for form in forms:
        assert Material(form) == material
    assert Material(material.text()).hash == material.hash
    assert pickle.loads(pickle.dumps(material)) == material == copy.deepcopy(material)
    assert len({material, Material(TEXT)}) == 1 and material != LAMBERT


def test_error_of_a_genome_has_its_place() -> None:
    with pytest.raises(GenomeError, match="line 3, column 1") as raised:
        Material("brood 1\n.dialect paper smooth registers 7\nFOO R1\n")
    assert (raised.value.line, raised.value.column, raised.value.pointer) == (3, 1, None)
    with pytest.raises(ValueError) as json_raised:
        Material({"brood": 2, "dialect": Material(TEXT).json()["dialect"], "instructions": []})
    assert isinstance(json_raised.value, GenomeError) and json_raised.value.pointer == "/brood"
    with pytest.raises(GenomeError) as syntax:
        Material('{"brood": 1,\n ]')
    assert syntax.value.line == 2
    for bad in [b"\xff", b"brood genome 1\n\xff", "", "brood 2\n"]:
        with pytest.raises(GenomeError):
            Material(bad)
    with pytest.raises(TypeError, match="got int"):
        Material(3)  # type: ignore[arg-type]
    again = pickle.loads(pickle.dumps(raised.value))
    assert (str(again), again.line) == (str(raised.value), 3)


def test_f_of_lambert_is_its_reflectance_over_pi() -> None:
    wi, wo = directions(10_000, 1), directions(10_000, 2)
    f = LAMBERT.eval(wi, wo)
    assert f.dtype == np.float32 and f.shape == (10_000, 3)
    assert np.allclose(f, np.array([0.25, 0.5, 0.75]) / np.pi, rtol=1e-6)
    assert np.allclose(LAMBERT.albedo(directions(3, 3)), [[0.25, 0.5, 0.75]] * 3, rtol=1e-5)
    assert LAMBERT.largest_albedo() == pytest.approx(0.75, rel=1e-3)


@pytest.mark.parametrize("name", [each.name for each in presets()])
def test_types_threads_and_precision_agree(name: str) -> None:
    material = Material.preset(name)
    assert material.text() and material.operations >= 0 and isinstance(material.inputs, list)
    wi, wo = directions(5000, 1), directions(5000, 2)
    uv = np.random.default_rng(3).random((5000, 2))
    assert material.has_brdf == (not material.is_painted or "by brdf" in material.text())
    if not material.has_brdf:
        with pytest.raises(ValueError, match="not a BRDF"):
            material.eval(wi, wo)
        return
    f = material.eval(wi, wo, uv)
    assert np.array_equal(f, material.eval(wi, wo, uv, threads=1))
    assert np.array_equal(f[4095:4099], material.eval(wi[4095:4099], wo[4095:4099], uv[4095:4099]))
    assert np.array_equal(f, material.eval(np.asfortranarray(wi), wo[::1], uv.tolist()))
    precise = material.eval(wi, wo, uv, precise=True)
    assert precise.dtype == np.float64
    error = np.abs(f - precise).sum() / max(np.abs(precise).sum(), 1e-30)
    assert error < 1e-3
    single = material.eval(wi.astype(np.float32), wo.astype(np.float32), uv.astype(np.float32))
    assert np.abs(single - f).sum() <= 0.02 * max(f.sum(), 1e-6)


def test_bumps_at_one_place_are_those_of_many_places() -> None:
    ball, wi, wo = Material.preset("model-golf-ball"), directions(5000, 1), directions(5000, 2)
    shared = ball.eval(wi, wo, [0.3, 0.6])
    assert np.array_equal(shared, ball.eval(wi, wo, np.tile([0.3, 0.6], (5000, 1))))
    assert not np.array_equal(shared, ball.eval(wi, wo, [0.31, 0.6]))


def test_one_row_is_shared_and_below_the_surface_is_black() -> None:
    wi = directions(100, 4)
    gold = Material.preset("gold")
    shared = gold.eval(wi, [0.0, 0.0, 1.0])
    assert np.array_equal(shared, gold.eval(wi, np.tile([0.0, 0.0, 1.0], (100, 1))))
    assert not gold.eval(-wi, [0, 0, 1]).any() and not gold.eval(wi, [0, 0, -1]).any()
    assert gold.eval(np.zeros((0, 3)), [0, 0, 1]).shape == (0, 3)


def test_errors_name_the_argument() -> None:
    wi = directions(10, 5)
    for call, words in [
        (lambda: LAMBERT.eval(wi[:, :2], wi), r"`wi` must have the shape .*got \(10, 2\)"),
        (lambda: LAMBERT.eval(wi, wi[:4]), "`wo` must have 1 or 10 rows"),
        (lambda: LAMBERT.eval(wi, wi, wi), "`uv` must have the shape"),
        (lambda: LAMBERT.eval(np.full((10, 3), "a"), wi), "`wi` must be an array of real numbers"),
        (lambda: LAMBERT.eval(wi, wi, threads=0), "`threads` must be 1 to 1024"),
        (lambda: LAMBERT.eval(wi, wi, [np.nan, 0]), "`uv`, row 0"),
        (lambda: LAMBERT.albedo(wi, order=2), "`order`"),
        (lambda: LAMBERT.sample(wi, wi + 2), "`random`, row 0"),
        (lambda: LAMBERT.export("foo"), "unknown format"),
        (lambda: LAMBERT.render(size=0), "`size`"),
        (lambda: LAMBERT.render({"mesh": 3}), "`scene`"),
        (lambda: Material.preset("foo"), "no preset is named foo"),
    ]:
        with pytest.raises(ValueError, match=words):
            call()
    bad = np.tile(wi, (1000, 1))
    bad[[4321, 9000]] = np.nan
    with pytest.raises(ValueError, match="`wi`, row 4321: a component"):
        LAMBERT.eval(bad, wi[0])
    with pytest.raises(ValueError, match="`wo`, row 4321: a component"):
        LAMBERT.pdf(wi[0], bad)
    bad = np.tile(wi, (1000, 1))
    bad[5] *= 1.1
    with pytest.raises(ValueError, match="`wi`, row 5: the length of the direction"):
        LAMBERT.eval(bad, wi[0])


@pytest.mark.parametrize("name", ["model-clay", "gold", "brushed-metal", "model-golf-ball"])
def test_samples_have_the_density_and_the_albedo(name: str) -> None:
    material = Material.preset(name)
    for wo in directions(2, 6, lowest=0.3):
        count = 40_000
        drawn = material.sample(np.tile(wo, (count, 1)), 7)
        assert drawn.wi.shape == drawn.weight.shape == (count, 3) and drawn.pdf.shape == (count,)
        # The albedo towards the eye is that of light from there, because f is reciprocal.
        mean, error = drawn.weight.mean(0), drawn.weight.std(0) / np.sqrt(count)
        albedo = material.albedo(wo, order=64)[0]
        assert (np.abs(mean - albedo) < 6 * error + 0.01 * albedo + 1e-4).all()
        # Histogram of the drawn directions against the integral of the density.
        places = directions(200_000, 9, lowest=0.0)
        density = material.pdf(places, wo) * 2 * np.pi / len(places)
        cells = [np.linspace(-1, 1, 9)] * 2
        expected, _, _ = np.histogram2d(places[:, 0], places[:, 1], cells, weights=density)
        above = drawn.wi[drawn.wi[:, 2] > 0]
        got, _, _ = np.histogram2d(above[:, 0], above[:, 1], cells)
        spread = np.sqrt(expected / count) + 0.05 * expected + 3e-3
        assert (np.abs(got / count - expected) < 5 * spread).all()
    assert 0 <= material.sampling_quality.table_share < 1
    assert material.sampling_quality.variance <= material.sampling_quality.cosine_variance * 1.01


def test_pictures_have_their_size_and_repeat() -> None:
    gold = Material.preset("gold")
    pixels = gold.render(size=(40, 30), mesh="torus", light_deg=30)
    assert pixels.shape == (30, 40, 4) and pixels.dtype == np.uint8 and pixels.any()
    assert np.array_equal(pixels, gold.render({"mesh": "torus", "light_deg": 30}, (40, 30)))
    linear = gold.radiance(size=32)
    assert linear.shape == (32, 32, 3) and linear.dtype == np.float32 and linear.max() > 0
    png = gold.png(size=(40, 30))
    assert png.startswith(PNG) and struct.unpack(">II", png[16:24]) == (40, 30)
    assert gold.exr(size=16).startswith(b"v/1\x01")
    assert gold._repr_png_().startswith(PNG)


def test_mesh_and_scene_are_files(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n", "utf-8")
    (tmp_path / "scene.json").write_text('{"light_deg": 45}', "utf-8")
    pixels = LAMBERT.render(tmp_path / "scene.json", 16, mesh=tmp_path / "a.obj")
    assert pixels[..., 3].any() and not pixels[..., 3].all()
    with pytest.raises(ValueError, match="a server"):
        LAMBERT.render({"lights": [{"kind": "ies", "profile": "a.ies"}]}, 16)


def test_painted_materials_are_rendered() -> None:
    painted = next(each.material for each in presets() if each.material.is_painted)
    assert painted.render(size=16).any()


def test_exports_have_every_format() -> None:
    for format in export_formats():
        try:
            content = LAMBERT.export_bytes(format.name)
        except ValueError as error:
            assert "painted" in str(error)
            continue
        assert content
        if format.is_binary:
            with pytest.raises(ValueError, match="export_bytes"):
                LAMBERT.export(format.name)
        else:
            assert LAMBERT.export(format.name).encode() == content
    assert "vec3 evolved(" in LAMBERT.export("glsl-es-300")
    assert LAMBERT.export_note("wgsl") is None


def test_limit_bounds_the_albedo() -> None:
    bright = Material("brood 1\n.model lambert\nalbedo 1 1 1\n")
    limited = bright.limited()
    assert limited.is_limited and not limited.limited(False).is_limited
    assert limited.largest_albedo() <= 1.001
    assert simd_level() in ("sse2", "avx2", "avx-512", "neon", "baseline")


def test_f_with_bumps_is_0_below_the_surface() -> None:
    copper = Material.preset("model-hammered-copper")
    below = copper.eval([0.6, 0.0, 0.8], [0.8, 0.0, -0.6], [0.3, 0.7])
    assert not below.any()
    assert copper.eval([0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [0.3, 0.7]).all()


def test_empty_arrays_have_no_samples() -> None:
    gold = Material.preset("gold")
    up, none = [0.0, 0.0, 1.0], np.empty((0, 2))
    assert gold.eval(up, up, none).shape == (0, 3)
    assert gold.albedo(up, none).shape == (0, 3)
    with pytest.raises(ValueError):
        gold.sample(up, 1, np.zeros((5, 2)))


def test_threads_of_python_render_at_once_with_pools_of_the_same_size() -> None:
    gold = Material.preset("gold")

    def draw(place: int) -> int:
        scene = {"camera": {"orbit_deg": [10.0 + place // 2, 20.0]}}
        return int(gold.render(scene, size=24, threads=2).sum())

    with ThreadPoolExecutor(2) as pool:
        sums = list(pool.map(draw, range(24), timeout=120))
    assert sums[::2] == sums[1::2]
