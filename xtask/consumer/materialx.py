"""Tests exported nodes in MaterialX: python materialx.py DIR

DIR holds cases.json and files of `brood bench consumer --format materialx`. Each document is
validated and made a shader by the generators of GLSL, ESSL and Vulkan; glslangValidator compiles
these, and spirv-val checks the last. MaterialX's renderer then draws a mesh with a triangle for each
pair of directions under a directional light, and its pixels are compared with the values of the
reference. Two materials are drawn in one shader, to see that their names do not clash. Needs an X
server (xvfb-run), glslangValidator and spirv-val. Prints one line of JSON for each material, then
one with the summary. Exits with 1 if a bound is exceeded.
"""

import base64
import json
import os
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import MaterialX as mx
import MaterialX.PyMaterialXGenGlsl as generators
import MaterialX.PyMaterialXGenShader as shading
import MaterialX.PyMaterialXRender as rendering
import MaterialX.PyMaterialXRenderGlsl as drawing
import numpy

import scene
from cases import compared, doubles, finish, listed

# Bounds of the error of values, mean |df cos| / mean f cos: the larger of this, and of this times
# the change by rounding directions and texture positions to numbers of 32 bits. The mesh rounds
# normals, tangents and places, each of which turns directions.
VALUE_ERROR = 1e-5
ROUNDING_RATIO = 4
# Half the side of the square of a triangle, in pixels.
SIZE = 0.45
# Generators, and the options of the compiler for their shaders.
TARGETS = {
    "genglsl": (generators.GlslShaderGenerator, []),
    "essl": (generators.EsslShaderGenerator, []),
    "vulkan": (generators.VkShaderGenerator, ["-V"]),
}
FLOAT, SHORT, SCALAR = 5126, 5125, "SCALAR"


def gltf(pairs, picture, path):
    """Writes the triangles of a picture: the pair of a triangle is at the centre of its pixel."""
    chosen = numpy.flatnonzero(pairs.picture == picture)
    offsets = numpy.array([[-1, -1, 0], [3, -1, 0], [-1, 3, 0]]) * SIZE / scene.SIDE
    place = (pairs.place[chosen, None] + offsets).reshape(-1, 3)
    each = lambda values: numpy.repeat(values[chosen], 3, axis=0)
    tangent = numpy.concatenate([each(pairs.tangent), numpy.ones((len(place), 1))], axis=1)
    # glTF's v grows downwards.
    uv = each(numpy.stack([pairs.uv[:, 0], 1 - pairs.uv[:, 1]], 1))
    columns = [place, each(pairs.normal), tangent, uv]
    parts = [values.astype("<f4").tobytes() for values in columns]
    parts.append(numpy.arange(len(place), dtype="<u4").tobytes())
    starts = numpy.cumsum([0] + [len(part) for part in parts])
    data = b"".join(parts)
    kinds = ["VEC3", "VEC3", "VEC4", "VEC2", SCALAR]
    accessors = [
        {"bufferView": k, "componentType": SHORT if kind == SCALAR else FLOAT, "count": len(place), "type": kind}
        for k, kind in enumerate(kinds)
    ]
    accessors[0] |= {"min": place.min(0).tolist(), "max": place.max(0).tolist()}
    attributes = {"POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3}
    path.write_text(
        json.dumps(
            {
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": attributes, "indices": 4}]}],
                "accessors": accessors,
                "bufferViews": [
                    {"buffer": 0, "byteOffset": int(start), "byteLength": len(part)}
                    for start, part in zip(starts, parts)
                ],
                "buffers": [
                    {
                        "byteLength": len(data),
                        "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
                    }
                ],
            }
        )
    )


class Tester:
    def __init__(self, pairs, folder):
        self.pairs, self.folder = pairs, folder
        self.search = mx.getDefaultDataSearchPath()
        self.library = mx.createDocument()
        mx.loadLibraries(mx.getDefaultDataLibraryFolders(), self.search, self.library)
        self.renderers = [self.renderer(picture) for picture in range(len(scene.LIGHTS))]

    def renderer(self, picture):
        path = self.folder / f"picture-{picture}.gltf"
        gltf(self.pairs, picture, path)
        renderer = drawing.GlslRenderer.create(scene.SIDE, scene.SIDE, rendering.BaseType.FLOAT)
        renderer.initialize()
        handler = renderer.getGeometryHandler()
        handler.addLoader(rendering.CgltfLoader.create())
        assert handler.loadGeometry(mx.FilePath(str(path)), False), "the mesh is not read"
        camera = rendering.Camera.create()
        far = 2 * abs(self.pairs.place[:, 2]).max()
        camera.setProjectionMatrix(rendering.Camera.createOrthographicMatrix(-1, 1, -1, 1, 0, far))
        renderer.setCamera(camera)
        images = drawing.GLTextureHandler.create(rendering.StbImageLoader.create())
        renderer.setImageHandler(images)
        return renderer

    def document(self, folder):
        document = mx.createDocument()
        for path in sorted(folder.glob("*.mtlx")):
            mx.readFromXmlFile(document, str(path))
        document.setDataLibrary(self.library)
        valid, message = document.validate()
        assert valid, message
        return document

    def shader(self, target, node, name, lights=None):
        generator = TARGETS[target][0].create()
        context = shading.GenContext(generator)
        context.registerSourceCodeSearchPath(self.search)
        context.getOptions().hwMaxActiveLightSources = 1
        context.getOptions().targetColorSpaceOverride = "lin_rec709"
        if lights:
            lights(context)
        return generator.generate(name, node, context)

    def compiled(self, target, node, name):
        """Compiles the shader of a target."""
        shader = self.shader(target, node, name)
        options = TARGETS[target][1]
        for stage, ending in [("vertex", "vert"), ("pixel", "frag")]:
            path = self.folder / f"shader.{ending}"
            path.write_text(shader.getSourceCode(stage))
            binary = self.folder / f"{ending}.spv"
            out = ["-o", str(binary)] if options else []
            run = subprocess.run(
                ["glslangValidator", *options, *out, str(path)], capture_output=True, text=True
            )
            assert run.returncode == 0, f"{target} {stage}: {run.stdout}"
            if options:
                subprocess.run(["spirv-val", str(binary)], check=True)

    def drawn(self, node, name):
        """f cos of each pair, drawn by MaterialX."""
        found = numpy.zeros((len(self.pairs.wi), 3))
        for picture, (renderer, to_light) in enumerate(zip(self.renderers, scene.LIGHTS)):
            document = mx.createDocument()
            document.setDataLibrary(self.library)
            light = document.addNode("directional_light", "lamp", "lightshader")
            x, y, z = -to_light
            light.setInputValue("direction", mx.Vector3(x, y, z))
            light.setInputValue("color", mx.Color3(1, 1, 1))
            light.setInputValue("intensity", 1.0)
            handler = rendering.LightHandler.create()
            handler.addLightSource(light)
            handler.setIndirectLighting(False)
            renderer.setLightHandler(handler)
            lights = lambda context: handler.registerLights(document, [light], context)
            renderer.createProgram(self.shader("genglsl", node, name, lights))
            renderer.validateInputs()
            renderer.render()
            image = renderer.captureImage(None)
            chosen = numpy.flatnonzero(self.pairs.picture == picture)
            for k in chosen:
                row, column = divmod(int(self.pairs.pixel[k]), scene.SIDE)
                color = image.getTexelColor(column, row)
                found[k] = [color[0], color[1], color[2]]
        return found


def unpacked(path, folder):
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)


def together(tester, folder):
    """Compiles a shader with two of the materials."""
    own = folder / "together"
    for path in sorted(folder.glob("case-*"))[:2]:
        own.mkdir(exist_ok=True)
        for file in path.iterdir():
            (own / file.name).write_bytes(file.read_bytes())
    document = tester.document(own)
    surface = document.getMaterialNodes()[0].getConnectedNode("surfaceshader")
    materials = [material.getConnectedNode("surfaceshader") for material in document.getMaterialNodes()]
    first, second = (material.getConnectedNode("bsdf") for material in materials)
    mix = document.addNode("mix", "both", "BSDF")
    mix.addInput("fg", "BSDF").setNodeName(first.getName())
    mix.addInput("bg", "BSDF").setNodeName(second.getName())
    mix.setInputValue("mix", 0.5)
    surface.getInput("bsdf").setNodeName("both")
    for target in TARGETS:
        tester.compiled(target, document.getMaterialNodes()[0], "both")


def main():
    folder = Path(sys.argv[1])
    given = listed(folder)
    pairs = scene.Pairs(given["pairs"])
    only = sys.argv[2:]
    cases = [case for case in given["cases"] if "f" in case]
    cases = [case for case in cases if not only or case["name"] in only]
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        tester = Tester(pairs, Path(temporary))
        for case in cases:
            own = Path(temporary) / Path(case["file"]).stem
            unpacked(folder / case["file"], own)
            document = tester.document(own)
            node = document.getMaterialNodes()[0]
            for target in TARGETS:
                tester.compiled(target, node, "material")
            wanted = doubles(case["f"]).reshape(-1, 3)
            error = pairs.error(tester.drawn(node, "material"), wanted)
            result = compared(case, error, VALUE_ERROR, ROUNDING_RATIO)
            print(json.dumps(result), flush=True)
            results.append(result)
        together(tester, Path(temporary))
    return finish(f"MaterialX {mx.getVersionString()}", given["cases"], results)


if __name__ == "__main__":
    if "DISPLAY" not in os.environ:
        os.execvp("xvfb-run", ["xvfb-run", "-a", sys.executable, *sys.argv])
    sys.exit(main())
