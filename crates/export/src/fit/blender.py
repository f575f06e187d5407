import math
import os
import sys

import bpy

NAME = "@NAME@"
DESCRIPTION = "@DESCRIPTION@"
TAGS = ("brood", "bred material")
# The place of an inclination in the colour ramps: its share of a right angle to this power.
PLACE_POWER = @POWER@
# Kind, width, anisotropy, normal, and weights at even places of the colour ramps. Kinds of facets
# have alpha as width, of which Blender's roughness is the square root. The normal is the surface's
# (UPRIGHT), the direction to the eye (EYE), or between them (HALF).
LOBES = (
@LOBES@
)


class Graph:
    """Nodes of a material."""

    def __init__(self, material):
        if bpy.app.version < (5, 0, 0):
            material.use_nodes = True
        self.tree = material.node_tree
        self.tree.nodes.clear()

    def add(self, kind, place, *inputs, **properties):
        """A node at a column and row; inputs are sockets, numbers or None."""
        node = self.tree.nodes.new(kind)
        node.location = (200 * place[0], -280 * place[1])
        for name, value in properties.items():
            setattr(node, name, value)
        for socket, value in zip(node.inputs, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node

    def link(self, output, node, name):
        self.tree.links.new(output, node.inputs[name])

    def math(self, operation, place, *inputs):
        return self.add("ShaderNodeMath", place, *inputs, operation=operation).outputs[0]

    def vector(self, operation, place, *inputs):
        return self.add("ShaderNodeVectorMath", place, *inputs, operation=operation)


def make_material():
    """Makes the material, and marks it as an asset."""
    material = bpy.data.materials.new(NAME)
    graph = Graph(material)
    geometry = graph.add("ShaderNodeNewGeometry", (0, 0))
    eye, normal = geometry.outputs["Incoming"], geometry.outputs["Normal"]
    cosine = graph.vector("DOT_PRODUCT", (1, 0), eye, normal).outputs["Value"]
    angle = graph.math("ARCCOSINE", (3, 0), graph.math("MINIMUM", (2, 0), cosine, 1.0))
    share = graph.math("MULTIPLY", (4, 0), angle, 2 / math.pi)
    place = graph.math("POWER", (5, 0), share, PLACE_POWER)
    normals = {"UPRIGHT": None, "EYE": eye}
    if any(lobe[3] == "HALF" for lobe in LOBES):
        between = graph.vector("ADD", (1, 1), eye, normal).outputs[0]
        normals["HALF"] = graph.vector("NORMALIZE", (2, 1), between).outputs[0]
    tangent = None
    if any(lobe[2] != 0 for lobe in LOBES):
        tangent = graph.add("ShaderNodeTangent", (0, 1), direction_type="UV_MAP").outputs[0]
    total = None
    for row, (kind, width, anisotropy, lean, weights) in enumerate(LOBES):
        ramp = graph.add("ShaderNodeValToRGB", (6, row), place)
        set_colours(ramp.color_ramp, weights)
        at = (8, row)
        if kind == "DIFFUSE":
            lobe = graph.add("ShaderNodeBsdfDiffuse", at)
            lobe.inputs["Roughness"].default_value = 0
        elif kind == "VELVET":
            lobe = graph.add("ShaderNodeBsdfSheen", at, distribution="ASHIKHMIN")
            lobe.inputs["Roughness"].default_value = width
        else:
            lobe = graph.add("ShaderNodeBsdfAnisotropic", at, distribution=kind)
            lobe.inputs["Roughness"].default_value = math.sqrt(width)
            lobe.inputs["Anisotropy"].default_value = anisotropy
            if anisotropy != 0:
                graph.link(tangent, lobe, "Tangent")
        if normals[lean] is not None:
            graph.link(normals[lean], lobe, "Normal")
        graph.link(ramp.outputs["Color"], lobe, "Color")
        shader = lobe.outputs[0]
        if total is not None:
            shader = graph.add("ShaderNodeAddShader", (9 + row, row), total, shader).outputs[0]
        total = shader
    output = graph.add("ShaderNodeOutputMaterial", (10 + len(LOBES), 0))
    if total is not None:
        graph.link(total, output, "Surface")
    material.use_fake_user = True
    material.asset_mark()
    material.asset_data.description = DESCRIPTION
    for tag in TAGS:
        material.asset_data.tags.new(tag)
    return material


def set_colours(ramp, colours):
    ramp.interpolation = "LINEAR"
    while len(ramp.elements) < len(colours):
        ramp.elements.new(0.5)
    for place, (red, green, blue) in enumerate(colours):
        ramp.elements[place].position = place / (len(colours) - 1)
        ramp.elements[place].color = (red, green, blue, 1)


def render(material, path, size=384, samples=64):
    """Renders a sphere on a ground, in an even sky and a large lamp, with Cycles."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    world = bpy.data.worlds.new("sky")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.4, 0.4, 0.4, 1)
    scene.world = world
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.angle = math.radians(28)
    camera.location, camera.rotation_euler = (0, -6, 2.2), (math.radians(78.2), 0, 0)
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
    lamp.data.size, lamp.data.energy = 2, 75
    lamp.location, lamp.rotation_euler = (-3, -3, 5), (math.radians(46.7), 0, math.radians(-45))
    for thing in (camera, lamp):
        scene.collection.objects.link(thing)
    scene.camera = camera
    bpy.ops.mesh.primitive_plane_add(size=40)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, location=(0, 0, 1))
    ball = bpy.context.object
    ball.data.materials.append(material)
    ball.data.shade_smooth()
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)


def main():
    """Makes the material in the open file, or a file of its own if a name is given."""
    arguments = sys.argv[1:] if bpy.app.module else sys.argv
    if "--" in arguments:
        arguments = arguments[arguments.index("--") + 1 :]
    elif not bpy.app.module:
        arguments = []
    if not arguments:
        make_material()
        return
    path = arguments[0]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    material = make_material()
    if path.endswith(".png"):
        render(material, path)
    elif path.endswith(".blend"):
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(path), compress=True)
    else:
        raise SystemExit(f"the file must end in .blend or .png, got {path}")


if __name__ == "__main__":
    main()
