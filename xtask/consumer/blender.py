"""Tests exported Blender scripts and OSL shaders with Cycles: python blender.py DIR

DIR holds cases.json and files of `brood bench consumer --format blender` or `blender-osl`. Each
material is made in Blender and rendered on the processor: each pair of directions is a tile with a
pixel of its own, in a scene with one camera and one point light. The pixels are compared with the
values of the fit, as brood computes them, and of the reference. Prints one line of JSON for each
material, then one with the summary. Exits with 1 if a bound is exceeded.
"""

import importlib.util
import json
import math
import statistics
import sys
import tempfile
import types
from pathlib import Path

import bpy
import numpy

from cases import doubles, finish, listed

# Bound of the difference between Cycles and the fit, mean |df cos| / mean f cos: Cycles samples
# colour ramps at 256 places, and tiles have positions of 32 bits.
FIT_ERROR = 0.05
# Cycles leaves out closures whose weight is below this: materials as dark as that are black there.
DARK = 1e-5
# Bound of the median over materials of that difference.
MEDIAN_FIT_ERROR = 2e-3
# Pixels across and down, and angle of view.
WIDTH, HEIGHT, VIEW = 64, 40, math.radians(30)
# The light, seen from the camera: in the middle of the picture.
LIGHT = numpy.array([0.0, 0.0, -100.0])
# Radiant intensity of the light; Blender's power is 4 pi of it.
INTENSITY = 1e4
# Angle from the directions in which a tile would be on the line from the camera to the light.
MARGIN = 1e-3
# Half the length of a tile, at most, relative to its distance; and the smallest cosine of the eye
# at which a tile of that length fills the middle of its pixel.
LENGTH = 0.15
LEAST_COSINE = 1e-3


def unit(vectors):
    return vectors / numpy.linalg.norm(vectors, axis=-1, keepdims=True)


def dot(a, b):
    return (a * b).sum(axis=-1, keepdims=True)


def angles(a, b):
    """Angles between unit vectors."""
    return numpy.arctan2(numpy.linalg.norm(numpy.cross(a, b), axis=-1), dot(a, b)[..., 0])


def pixel_directions():
    """Directions through the middles of the pixels, rows from below."""
    focal = 0.5 * WIDTH / math.tan(VIEW / 2)
    x = (numpy.arange(WIDTH) + 0.5 - WIDTH / 2) / focal
    y = (numpy.arange(HEIGHT) + 0.5 - HEIGHT / 2) / focal
    across, up = numpy.meshgrid(x, y)
    return unit(numpy.stack([across, up, -numpy.ones_like(across)], axis=-1).reshape(-1, 3))


def frames(a, b):
    """Orthonormal frames whose first axis is a and whose second is in the plane of a and b."""
    second = unit(b - dot(a, b) * a)
    return numpy.stack([a, second, numpy.cross(a, second)], axis=1)


class Tiles:
    """A tile for each pair of directions that a pixel can show."""

    def __init__(self, light, eye):
        directions = pixel_directions()
        between = angles(light, eye)
        from_light = angles(directions, unit(LIGHT))
        # Where the light is opposite to the eye, the pixel must be near the light.
        pixels = numpy.empty(len(light), dtype=int)
        pixels[numpy.argsort(-between)] = numpy.argsort(from_light)[: len(light)]
        room = math.pi - between - from_light[pixels]
        is_seen = eye[:, 2] > LEAST_COSINE
        self.cases = numpy.nonzero((room > MARGIN) & (between > MARGIN) & is_seen)[0]
        self.pixels = pixels[self.cases]
        ray, between = directions[self.pixels], between[self.cases, None]
        along = dot(ray, LIGHT)
        distance = along + numpy.linalg.norm(LIGHT - along * ray, axis=1, keepdims=True) / numpy.tan(
            between
        )
        self.places = distance * ray
        to_light = LIGHT - self.places
        self.squares = dot(to_light, to_light)
        # Rotation of the local frame (tangent, bitangent, normal) to the scene.
        world, local = frames(-ray, unit(to_light)), frames(eye[self.cases], light[self.cases])
        self.turns = numpy.einsum("nki,nkj->nij", world, local)
        self.size = 0.4 * 2 * math.tan(VIEW / 2) / WIDTH * distance

    def mesh(self, ray_to_eye):
        """Rectangles, longer where they are seen at grazing angles, with u along the tangent."""
        tangent, normal = self.turns[:, :, 0], self.turns[:, :, 2]
        bitangent = self.turns[:, :, 1]
        cosine = dot(ray_to_eye, normal)
        tilt = ray_to_eye - cosine * normal
        is_upright = numpy.linalg.norm(tilt, axis=1, keepdims=True) < 1e-6
        tilt = unit(numpy.where(is_upright, tangent, tilt))
        # A longer tile would come near the camera, and hide others.
        distance = numpy.linalg.norm(self.places, axis=1, keepdims=True)
        long = tilt * numpy.minimum(self.size / cosine, LENGTH * distance)
        wide = numpy.cross(normal, tilt) * self.size
        corners = numpy.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        offsets = corners[:, 0, None] * long[:, None] + corners[:, 1, None] * wide[:, None]
        vertices = self.places[:, None] + offsets
        scale = 0.01 / self.size[:, None]
        u = 0.5 + scale * dot(offsets, tangent[:, None])
        v = 0.5 + scale * dot(offsets, bitangent[:, None])
        mesh = bpy.data.meshes.new("tiles")
        faces = numpy.arange(4 * len(vertices)).reshape(-1, 4)
        mesh.from_pydata(vertices.reshape(-1, 3).tolist(), [], faces.tolist())
        uv = numpy.concatenate([u, v], axis=-1).astype(numpy.float32)
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uv.ravel())
        return mesh

    def values(self, material, folder):
        """f cos of each case that has a tile: red, green, blue."""
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        cycles = scene.cycles
        cycles.device, cycles.samples, cycles.max_bounces = "CPU", 1, 0
        cycles.use_denoising = cycles.use_adaptive_sampling = False
        cycles.pixel_filter_type, cycles.filter_width = "BOX", 0.01
        cycles.light_sampling_threshold = cycles.sample_clamp_direct = 0
        render = scene.render
        render.resolution_x, render.resolution_y = WIDTH, HEIGHT
        render.resolution_percentage = 100
        render.film_transparent = True
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_depth = "32"
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.data.angle, camera.data.clip_start, camera.data.clip_end = VIEW, 1e-3, 1e6
        lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "POINT"))
        lamp.data.energy, lamp.data.shadow_soft_size = 4 * math.pi * INTENSITY, 0
        lamp.data.use_shadow = False
        lamp.location = LIGHT
        mesh = self.mesh(-unit(self.places))
        mesh.materials.append(material)
        tiles = bpy.data.objects.new("tiles", mesh)
        for thing in (camera, lamp, tiles):
            scene.collection.objects.link(thing)
        scene.camera = camera
        render.filepath = str(Path(folder) / "tiles.exr")
        bpy.ops.render.render(write_still=True)
        picture = bpy.data.images.load(render.filepath)
        picture.colorspace_settings.name = "Non-Color"
        pixels = numpy.empty(WIDTH * HEIGHT * 4, numpy.float32)
        picture.pixels.foreach_get(pixels)
        found = pixels.reshape(-1, 4)[self.pixels].astype(float)
        if not (found[:, 3] > 0.5).all():
            raise RuntimeError("a tile is not in its pixel")
        return found[:, :3] * self.squares / INTENSITY


def material_of_nodes(path):
    """The material that a script makes."""
    spec = importlib.util.spec_from_file_location(path.stem.replace(".", "_"), path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    material = module.make_material()
    if material.asset_data is None or material.asset_data.description != module.DESCRIPTION:
        raise RuntimeError("the material is no asset with the error in its description")
    return material


def material_of_osl(path, folder):
    """A material of one Script node with a shader."""
    import _cycles

    compiled = Path(folder) / f"{path.stem}.oso"
    if not _cycles.osl_compile(str(path), str(compiled)):
        raise RuntimeError("the shader does not compile")
    # Blender asks this module for the sockets of the node; the package bpy lacks it.
    sys.modules.setdefault("oslquery", types.SimpleNamespace(OSLQuery=lambda path: None))
    bpy.context.scene.cycles.shading_system = True
    material = bpy.data.materials.new("osl")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeScript")
    node.mode, node.filepath = "EXTERNAL", str(compiled)
    node.inputs.new("NodeSocketVector", "Tangent", identifier="Tangent")
    node.outputs.new("NodeSocketShader", "BSDF", identifier="BSDF")
    tangent = tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type = "UV_MAP"
    tree.links.new(tangent.outputs[0], node.inputs["Tangent"])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    return material


def relative(found, wanted):
    """Mean |df cos| / mean f cos."""
    total = abs(wanted).sum()
    return float(abs(found - wanted).sum() / (total if total > 0 else 1))


def main():
    folder = Path(sys.argv[1])
    given = listed(folder)
    pairs = doubles(given["pairs"]).reshape(-1, 8)
    light, eye = unit(pairs[:, :3]), unit(pairs[:, 3:6])
    tiles = Tiles(light, eye)
    cosine = pairs[tiles.cases, 2:3]
    results = []
    for case in given["cases"]:
        if "file" not in case:
            continue
        bpy.ops.wm.read_factory_settings(use_empty=True)
        path = folder / case["file"]
        with tempfile.TemporaryDirectory() as scratch:
            if given["format"] == "blender":
                material = material_of_nodes(path)
            else:
                material = material_of_osl(path, scratch)
            found = tiles.values(material, scratch)
        wanted = doubles(case["f"]).reshape(-1, 3)[tiles.cases] * cosine
        fit = doubles(case["fit"]).reshape(-1, 3)[tiles.cases] * cosine
        result = {
            "name": case["name"],
            "fit_error": relative(found, fit),
            "value_error": relative(found, wanted),
            "own_error": case["own_error"],
            "note": case["note"],
        }
        is_black = abs(fit).mean() < DARK and not found.any()
        result["passed"] = bool(result["fit_error"] <= FIT_ERROR or is_black)
        print(json.dumps(result), flush=True)
        results.append(result)
    errors = [result["fit_error"] for result in results]
    median = statistics.median(errors)
    code = finish(
        f"bpy {bpy.app.version_string}",
        given["cases"],
        results,
        pairs=len(tiles.cases),
        worst_fit_error=max(errors),
        median_fit_error=median,
    )
    return code or int(median > MEDIAN_FIT_ERROR)


if __name__ == "__main__":
    sys.exit(main())
