"""Evolution by scripts against a real server: breeding, pictures, favourites, files."""

from __future__ import annotations

import io
import json
import time
import zipfile

import pytest

from brood_brdf.client import Client, Conflict, Invalid, Lineage
from client_harness import PNG, SIZE_PX, BroodServer

RED = "brood 1\n.model lambert\nalbedo 0.6 0.05 0.05\n"
OBJ = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def size_of(png: bytes) -> tuple[int, int]:
    assert png.startswith(PNG)
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")


def test_script_breeds_towards_detail(server: BroodServer) -> None:
    with Client(server.url) as client:
        lineage = client.create_lineage("towards detail", saturation=0.65, thumbnail_px=SIZE_PX)
        brood = lineage.breed(seed=1)
        for seed in range(2, 5):
            best = max(brood, key=lambda child: len(child.thumbnail()))
            brood = lineage.breed([best], mutation=0.3, seed=seed)
        sheet = brood.sheet()
        assert sheet.startswith(PNG)
        assert [each.index for each in lineage.generations(page_size=2)] == [0, 1, 2, 3]
        assert brood.parents == (best.id,)
        assert brood.centre is not None and brood.centre.id == best.id
        assert [child.slot for child in brood] == list(range(20)) and len(brood) == 20
        assert lineage.refresh().generation_count == 4


def test_seed_gives_the_same_children(lineage: Lineage, client: Client) -> None:
    other = client.create_lineage("twin", thumbnail_px=SIZE_PX)
    seed = 2**64 - 1
    first, second = lineage.breed(count=4, seed=seed), other.breed(count=4, seed=seed)
    assert first.seed == seed
    assert [child.hash for child in first] == [child.hash for child in second]


def test_lineages_start_in_all_ways(client: Client) -> None:
    for start in ["believable", "models", "painted", "wild"]:
        lineage = client.create_lineage(
            start, start=start, thumbnail_px=SIZE_PX, notes="n", tags=["a tag"]
        )
        assert (lineage.start, lineage.tags, lineage.notes) == (start, ("a tag",), "n")
        child = lineage.breed(count=2, seed=1)[0]
        assert child.operator == "random"
        assert size_of(child.thumbnail()) == (SIZE_PX, SIZE_PX)
    lineage = client.create_lineage("given", start="models", thumbnail_px=SIZE_PX)
    stored = client.store_genome(RED)
    named = client.adopt(lineage, presets=["model-clay"], genomes=[stored], texts=[RED])
    assert [child.hash == stored for child in named] == [True, True, False]
    assert named[0].layers == ("lambert",)
    edited = lineage.adopt(texts=[named[0].text().replace("0.6", "0.7")], parent=named[0])
    assert edited[0].parents == (named[0].id,)
    assert [each.id for each in named[0].descendants()] == [edited[0].id]
    assert [each.id for each in edited[0].ancestry()] == [named[0].id]


def test_breed_takes_all_options(lineage: Lineage) -> None:
    parents = lineage.breed(count=2, seed=1)
    cross = lineage.breed(
        [parents[0], parents[1].id],
        count=3,
        mutation=0.2,
        recombination=0.4,
        curation="diverse",
        seed=3,
        steer=["warmer"],
        locks={"channels": ["r"]},
        saturation=0.5,
        energy_limit=True,
        isotropic=True,
        homogeneous=True,
        bumps=False,
    )
    assert len(cross) == 3 and {child.operator for child in cross} == {"recombine"}
    assert cross.constraints == {"isotropic": True, "homogeneous": True, "bumps": False}
    assert cross.locks is not None and cross.locks["channels"] == ["r"]
    assert (cross.steer, cross.energy_limit, cross.saturation) == (("warmer",), True, 0.5)
    assert cross.mutation == pytest.approx(0.2) and cross.curation == "diverse"


def test_painting_gives_its_colours(client: Client) -> None:
    art = client.render(RED, 64)
    palette = client.palette(art)
    lineage = client.create_lineage("art", start="painted", thumbnail_px=SIZE_PX)
    brood = lineage.breed(count=2, seed=1, painting=palette)
    assert brood.painting == palette
    image = client.upload_image(art)
    assert (image.kind, image.width, image.height) == ("image", 64, 64)


def test_pictures_have_the_asked_form(lineage: Lineage, client: Client) -> None:
    child = lineage.breed(count=1, seed=1)[0]
    assert size_of(child.picture(48)) == (48, 48)
    assert size_of(child.picture((64, 32), light_deg=30, samples=1)) == (64, 32)
    assert size_of(child.picture("64x32", area=(0, 0, 32, 16), backend="cpu")) == (32, 16)
    assert child.radiance(SIZE_PX).startswith(b"\x76\x2f\x31\x01")
    webp = child.thumbnail(webp=True)
    assert webp[:4] == b"RIFF" and webp[8:12] == b"WEBP"
    assert size_of(child.strip(SIZE_PX, frames=3)) == (3 * SIZE_PX, SIZE_PX)
    assert b"acTL" in child.animation(SIZE_PX, frames=2, seconds=1.0)
    assert size_of(child.image_slice(SIZE_PX)) == (SIZE_PX, SIZE_PX)
    assert size_of(client.sheet_of([child, child.id]))[0] >= SIZE_PX
    assert client.develop(child.radiance(SIZE_PX)).startswith(PNG)
    knob = client.store_scene(mesh="knob")
    assert child.picture(SIZE_PX, scene=knob) != child.picture(SIZE_PX)


def test_notebook_shows_pictures(lineage: Lineage, server: BroodServer) -> None:
    brood = lineage.breed(count=2, seed=1)
    assert brood[0]._repr_png_() == brood[0].thumbnail()
    assert brood._repr_png_() == brood.sheet()
    with Client(server.url) as other:
        brood = other.generation(brood)
    assert brood[0]._repr_png_() is None and brood._repr_png_() is None, "its client is closed"


def test_favourites_are_marked_listed_and_saved(lineage: Lineage, client: Client) -> None:
    brood = lineage.breed(count=3, seed=1)
    kept = brood[0].mark(favourite=True, note="the one")
    assert kept.favourite and kept.note == "the one" and kept.lineage == lineage.id
    brood[2].mark(favourite=True)
    favourites = list(lineage.favourites(page_size=1))
    assert {each.id for each in favourites} == {brood[0].id, brood[2].id}
    assert kept.id in {each.id for each in client.favourites()}
    archive = client.export_zip(favourites, ["brood", "png", "glsl-es-300"], size=SIZE_PX)
    names = zipfile.ZipFile(io.BytesIO(archive)).namelist()
    assert (
        sorted(name.rsplit(".", 1)[1] for name in names)
        == ["brood"] * 2 + ["glsl"] * 2 + ["json"] + ["png"] * 2
    )
    whole = client.export_zip(formats=["brood"], generation=brood)
    assert len(zipfile.ZipFile(io.BytesIO(whole)).namelist()) == 4
    assert not brood[0].mark(favourite=False).favourite


def test_brood_is_exported_by_a_job(lineage: Lineage, client: Client) -> None:
    brood = lineage.breed(count=2, seed=1)
    archive = client.export_archive(
        generation=brood, formats=["rgl-bsdf", "brood", "png"], size=(32, 16), poll_s=0.1
    )
    file = zipfile.ZipFile(io.BytesIO(archive))
    endings = sorted(name.rsplit(".", 1)[1] for name in file.namelist())
    assert endings == ["brood"] * 2 + ["bsdf"] * 2 + ["json"] + ["png"] * 2
    manifest = json.loads(file.read("manifest.json"))
    assert [each["individual"] for each in manifest["materials"]] == [each.id for each in brood]
    assert manifest["size"] == [32, 16]
    job = client.start_export(list(brood), ["samples-csv"])
    assert client.job(job).id == job.id and job.files == 2
    while job.state in {"queued", "running"}:
        time.sleep(0.05)
        job = job.refresh()
    assert job.state == "succeeded" and job.progress == 1 and len(job.file()) > 0
    assert client.job(job) == job.refresh()
    with pytest.raises(Conflict):
        job.cancel()
    with pytest.raises(Invalid):
        client.start_export(["x"], ["png"])


def test_genome_is_read_stored_and_exported(lineage: Lineage, client: Client) -> None:
    child = lineage.breed(count=1, seed=1)[0]
    text, data = child.text(), child.json()
    assert client.store_genome(text) == client.store_genome(data) == child.hash
    assert client.genome_text(child.hash) == text and client.genome_json(child.hash) == data
    formats = {each.name for each in client.export_formats()}
    assert {"wgsl", "glsl-es-300"} <= formats
    assert child.export("wgsl", energy_limit=True) != ""
    assert child.export_bytes("gltf")[:4] == b"glTF"
    assert client.export_genome(RED, "glsl-es-300", uv_within=1.0) != ""
    assert "energy" in child.inspection()
    compared = client.compare([child, client.store_genome(RED)], size=SIZE_PX)
    assert len(compared["materials"]) == 2


def test_presets_and_models_are_listed(client: Client) -> None:
    presets = {preset.name: preset for preset in client.presets()}
    assert presets["gold"].text.startswith("brood 1")
    assert client.render(presets["gold"].text, (48, 32)).startswith(PNG)
    models = {model.name: model for model in client.models()}
    lambert = models["lambert"].parameters[0]
    assert lambert.name == "albedo" and lambert.kind == "color" and len(lambert.default) == 3


def test_lineage_is_listed_changed_hidden_and_moved(client: Client) -> None:
    names = [f"zebra {number}" for number in range(3)]
    made = [client.create_lineage(name, thumbnail_px=SIZE_PX) for name in names]
    listed = list(client.lineages("zebra", page_size=2))
    assert [each.name for each in listed] == names[::-1]
    cover = made[0].breed(count=1, seed=1)[0]
    changed = made[0].change(name="horse", tags=["a"], cover=cover, saturation=0.5)
    assert (changed.name, changed.tags, changed.cover_individual) == ("horse", ("a",), cover.id)
    assert changed.version > made[0].version
    made[1].delete()
    assert [each.id for each in client.lineages("zebra", hidden=True)] == [made[1].id]
    assert not client.change_lineage(made[1], hidden=False).hidden
    again = client.import_lineage(made[0].file())
    assert again.id != made[0].id and again.generation_count == 1
    made[2].delete(purge=True)
    assert made[2].id not in {each.id for each in client.lineages()}


def test_scene_with_own_mesh_is_stored(client: Client) -> None:
    mesh = client.upload_mesh(OBJ)
    assert mesh.triangles == 4 and client.mesh(mesh) == mesh
    assert client.mesh_glb(mesh).startswith(b"glTF") and client.mesh_glb("knob") != b""
    base = client.default_scene()
    scene = client.store_scene({**base, "mesh": mesh.id}, scale=2.0)
    assert (scene.mesh, scene.scale) == (mesh.id, 2.0)
    assert client.scene(scene) == scene
    lineage = client.create_lineage("in a scene", scene=scene, thumbnail_px=SIZE_PX)
    assert lineage.scene == scene.id
    assert client.render(RED, SIZE_PX, scene=scene) != client.render(RED, SIZE_PX)


def test_environments_have_lit_spheres(client: Client, lineage: Lineage) -> None:
    scene = client.store_scene(lights=[{"kind": "environment", "image": "studio"}])
    child = lineage.adopt(texts=[RED])[0]
    spheres = child.lit_spheres(scene=scene, texels=16)
    assert spheres is not None and spheres.startswith(b"broodlit")
    assert client.lit_spheres_of(RED, scene, texels=16) == spheres
    painted = {preset.name: preset.text for preset in client.presets()}["paint-toon"]
    assert client.lit_spheres_of(painted, scene) is None
    sky = client.upload_environment(child.radiance((32, 16), scene=scene))
    assert sky.kind == "environment" and sky.mean_radiance is not None


def test_any_request_can_be_sent(client: Client) -> None:
    assert client.ready()
    system = client.system()
    assert system.limits["generation_children"] == 256
    page = client.request("GET", "/v1/lineages?limit=1").json()
    assert len(page["items"]) <= 1
    answer = client.request("get", "/v1/system", query={"x": None})
    assert answer.json()["version"] == system.version
    made = client.request("POST", "/v1/lineages", json={"name": "by hand"})
    assert made.status_code == 201 and json.loads(made.content)["name"] == "by hand"
    with pytest.raises(ValueError, match="one slash"):
        client.request("GET", "//elsewhere.example/v1/system")
