"""Pictures by Mitsuba of the scenes that brood rendered, and how far brood's are from them.

Reads a list of cases: brood's scene, the same material for Mitsuba, and brood's picture. Writes one JSON object to stdout.
The yardstick is the peer's own noise: pictures that differ by nothing but the seed differ by it times sqrt 2.
"""

import argparse
import json
import math
import pathlib
import sys

import drjit
import mitsuba
import numpy

mitsuba.set_variant("llvm_ad_rgb")

import mitsuba_models  # noqa: E402, BSDF classes exist only once a variant is set
from mesh_tangents import tangents  # noqa: E402


def rgb(value):
    return {"type": "rgb", "value": value if isinstance(value, list) else [value] * 3}


def camera_of(camera):
    """brood's camera as origin, target, up and the rest of a sensor."""
    transform = mitsuba.ScalarTransform4f()
    if "orthographic" in camera:
        half = camera["orthographic"]
        view = transform.look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0])
        return {"type": "orthographic", "to_world": view @ transform.scale([half, half, 1.0])}
    view = transform.look_at(origin=camera["eye"], target=camera["target"], up=[0, 1, 0])
    return {"type": "perspective", "fov": camera["fov_y_deg"], "fov_axis": "y", "to_world": view}


def light_of(light):
    if light["kind"] == "directional":
        return {
            "type": "directional", "direction": light["direction"],
            "irradiance": rgb(light["irradiance_w_m2"]),
        }
    if light["kind"] == "ambient":
        return {"type": "constant", "radiance": rgb(light["radiance_w_m2_sr"])}
    if light["kind"] == "environment":
        # The middle of the picture is -z in brood and +z in Mitsuba.
        turn = mitsuba.ScalarTransform4f().rotate([0, 1, 0], light["rotation_deg"] - 180)
        return {"type": "envmap", "filename": light["image"], "to_world": turn}
    return {"type": "point", "position": light["position"], "intensity": rgb(light["intensity"])}


def shape_of(mesh):
    # A sphere is exact here, of whatever triangles it is in brood.
    if mesh is None or pathlib.Path(mesh).name == "sphere.obj":
        # brood's sphere has its poles above and below, Mitsuba's before and behind.
        upright = mitsuba.ScalarTransform4f().rotate([1, 0, 0], -90)
        return {"type": "sphere", "to_world": upright}
    return {"type": "obj", "filename": mesh}


def bsdf_of(bsdf):
    return {key: rgb(value) if isinstance(value, list) else value for key, value in bsdf.items()}


def others_of(case):
    """The other spheres of brood's scene, and its ground."""
    scene, shapes = case["scene"], {}
    transform = mitsuba.ScalarTransform4f()
    bsdfs = [bsdf_of(bsdf) for bsdf in case["others"]]
    for index, sphere in enumerate(scene.get("objects", [])):
        place = transform.translate(sphere["position"]) @ transform.scale(sphere["scale"])
        shapes[f"other{index}"] = {"type": "sphere", "to_world": place, "bsdf": bsdfs[index]}
    if "ground" in scene:
        place = transform.translate([0, scene["ground"]["height"], 0]) @ transform.rotate([1, 0, 0], -90)
        shapes["ground"] = {
            "type": "rectangle", "to_world": place @ transform.scale([1000.0] * 3), "bsdf": bsdfs[-1],
        }
    return shapes


def scene_of(case):
    scene = case["scene"]
    (light,) = scene["lights"]
    # Only sampling a light that is a delta finds it.
    delta = light["kind"] not in ("ambient", "environment")
    integrator = {
        "type": "direct", "hide_emitters": True,
        "emitter_samples": 1, "bsdf_samples": 0 if delta else 1,
    }
    if case.get("max_depth", 2) > 2:
        integrator = {"type": "path", "hide_emitters": True, "max_depth": case["max_depth"]}
    film = {
        "type": "hdrfilm", "width": case["size_px"], "height": case["size_px"],
        "pixel_format": "rgb", "component_format": "float32", "rfilter": {"type": "box"},
    }
    sampler = {"type": case["sampler"], "sample_count": case["samples"]}
    sensor = camera_of(scene["camera"]) | {"film": film, "sampler": sampler}
    shape = mitsuba.load_dict(shape_of(case["mesh"]) | {"bsdf": bsdf_of(case["bsdf"])})
    if shape.is_mesh():
        add_tangents(shape)
    return mitsuba.load_dict({
        "type": "scene", "integrator": integrator, "sensor": sensor, "light": light_of(light), "shape": shape,
    } | others_of(case))


def add_tangents(mesh):
    """Gives a mesh the directions along the surface that it has in brood, for the BSDFs that take them."""
    parameters = mitsuba.traverse(mesh)

    def rows(name, columns):
        return numpy.array(parameters[name]).reshape(-1, columns)

    places, normals = (rows(name, 3).astype(numpy.float64) for name in ("vertex_positions", "vertex_normals"))
    textures = rows("vertex_texcoords", 2).astype(numpy.float64)
    if not len(textures):
        textures = numpy.zeros((len(places), 2))
    found = tangents(places, normals, textures, rows("faces", 3))
    mesh.add_attribute(mitsuba_models.TANGENT, 3, found.astype(numpy.float32).ravel())


def rmse(a, b):
    return float(numpy.sqrt(numpy.mean((a - b) ** 2)))


def read(path):
    bitmap = mitsuba.Bitmap(str(path)).convert(
        mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, srgb_gamma=False
    )
    return numpy.array(bitmap).astype(numpy.float64)


def compare(case, options):
    scene = scene_of(case)
    seeds = range(1, options.renders + 1)
    pictures = [render(scene, case["samples"], seed) for seed in seeds]
    mean = numpy.mean(pictures, axis=0)
    apart = [rmse(a, b) ** 2 for index, a in enumerate(pictures) for b in pictures[:index]]
    own = read(case["picture"])
    recorded = read(case["recorded"]) if case["recorded"] else None
    wanted = mean if recorded is None else recorded
    noise = math.sqrt(numpy.mean(apart) / 2)
    if options.pictures:
        write_sheet(pathlib.Path(options.pictures) / f"{case['name']}.png", own, wanted, noise)
    return {
        "rmse": rmse(own, wanted), "noise": noise, "averaged": options.renders if recorded is None else 1,
        "recorded_rmse": None if recorded is None else rmse(recorded, mean),
        "brightest": float(mean.max()),
    }


def render(scene, samples, seed):
    return numpy.array(mitsuba.render(scene, spp=samples, seed=seed)).astype(numpy.float64)


def write_sheet(path, own, wanted, noise):
    """brood's, the peer's, and the difference: grey where there is none, black or white at twenty times the noise."""
    difference = 0.5 + (own - wanted) / (40 * noise)
    sheet = numpy.concatenate([own, wanted, difference], axis=1).clip(0, 1)
    mitsuba.util.write_bitmap(str(path), mitsuba.Bitmap(sheet.astype(numpy.float32)))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cases", help="a JSON file")
    parser.add_argument("--renders", type=int, default=4)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--pictures", help="a folder for brood's, Mitsuba's and their difference, for looking at")
    options = parser.parse_args()
    drjit.set_thread_count(options.threads)
    cases = json.loads(pathlib.Path(options.cases).read_text())
    rows = []
    for case in cases:
        rows.append(compare(case, options))
        print(f"{case['name']}: {rows[-1]['rmse'] / rows[-1]['noise']:.2f} times the noise", file=sys.stderr)
    print(json.dumps({"renders": options.renders, "rows": rows}))


if __name__ == "__main__":
    main()
