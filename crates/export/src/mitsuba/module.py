import base64
import collections
import struct
import sys
import zlib

import drjit as dr
import mitsuba as mi

# Name of the plugin: {"type": NAME} in scenes.
NAME = "@NAME@"
# Share of the samples that the table chooses; the others are chosen by the cosine.
TABLE_SHARE = @SHARE@
# Samples of the density over half vectors: inclinations and azimuths of the eye, rows, columns.
TABLE_SHAPE = @SHAPE@
# The column of a half vector is (2 / pi inclination)^(1 / TABLE_POWER).
TABLE_POWER = @POWER@
# True if rows are azimuths about the normal, false if they begin at the azimuth of the eye.
TABLE_IS_FIXED = @FIXED@
# Angle that the azimuths of the eye cover, after which the material repeats.
TABLE_PERIOD = @PERIOD@
# Numbers of 16 bits, compressed.
TABLE_BYTES = """
@BYTES@
"""


class Table:
    """Numbers that are read at computed places."""

    def __init__(self, numbers):
        self.numbers = numbers

    def __getitem__(self, index):
        return dr.gather(mi.Float, mi.Float(self.numbers), mi.UInt32(index))


def vec2f(*parts):
    return mi.Vector2f(*parts)


def vec3f(*parts):
    if len(parts) == 2:
        return mi.Vector3f(parts[0].x, parts[0].y, parts[1])
    return mi.Vector3f(*parts)


def select(otherwise, value, condition):
    return dr.select(condition, value, otherwise)


def step(edge, x):
    return dr.select(x >= edge, mi.Float(1), mi.Float(0))


def as_u32(x):
    return mi.UInt32(x) if isinstance(x, int) else dr.reinterpret_array(mi.UInt32, mi.Float(x))


def as_i32(x):
    return dr.reinterpret_array(mi.Int32, x)


def as_f32(x):
    return dr.reinterpret_array(mi.Float, mi.UInt32(x))


def with_derivative(value, other):
    """The value, with the derivative of another one."""
    return dr.replace_grad(mi.Float(value), mi.Float(other))


@CODE@


def density():
    """The density over half vectors, one function for each inclination and azimuth of the eye."""
    inclinations, azimuths, rows, columns = TABLE_SHAPE
    count = inclinations * azimuths * rows * columns
    numbers = struct.unpack(f"<{count}e", zlib.decompress(base64.b64decode(TABLE_BYTES)))
    shape = (inclinations, azimuths, rows, columns)
    angles = [k * dr.pi / 2 / (inclinations - 1) for k in range(inclinations)]
    if azimuths == 1:
        return mi.MarginalContinuous2D1(floats(numbers, (inclinations, rows, columns)), [angles])
    turns = [k * TABLE_PERIOD / (azimuths - 1) for k in range(azimuths)]
    return mi.MarginalContinuous2D2(floats(numbers, shape), [angles, turns])


def floats(numbers, shape):
    """An array that Mitsuba reads, without numpy."""
    data = struct.pack(f"={len(numbers)}f", *numbers)
    return memoryview(bytearray(data)).cast("f", shape)


def make_class():
    """Makes the class of the material for the variant of Mitsuba that is set."""

    class Material(mi.BSDF):
        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            reflection = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
            self.m_components = [reflection@FLAGS@]
            self.m_flags = self.m_components[0]
            self.density = density()

        def f(self, ctx, si, wo):
            """f in 1/sr for si.wi and wo; both are above the surface where it is used."""
            to_light, to_eye = wo, si.wi
            if ctx.mode == mi.TransportMode.Importance:
                to_light, to_eye = si.wi, wo
            normal, tangent = mi.Vector3f(0, 0, 1), mi.Vector3f(1, 0, 0)
            across = mi.Vector3f(0, @ACROSS@, 0)
            f = evolved(to_light, to_eye, normal, tangent, across, si.uv)
            if mi.is_monochromatic:
                f = mi.luminance(mi.Color3f(f))
            f = mi.UnpolarizedSpectrum(f)
            return mi.depolarizer(f) if mi.is_polarized else f

        def eval(self, ctx, si, wo, active=True):
            active = self.is_above(ctx, si, wo, active)
            f = self.f(ctx, si, wo) * mi.Frame3f.cos_theta(wo)
            return dr.select(active, f, dr.zeros(mi.Spectrum))

        def pdf(self, ctx, si, wo, active=True):
            active = self.is_above(ctx, si, wo, active)
            half = dr.normalize(si.wi + wo)
            # Not 0, where the density has no limit.
            inclination = dr.maximum(dr.atan2(dr.norm(half.xy), half.z), 1e-6)
            x = (2 / dr.pi * inclination) ** (1 / TABLE_POWER)
            azimuth = dr.atan2(half.y, half.x) - self.origin(si)
            y = azimuth / dr.two_pi
            y -= dr.floor(y)
            area = self.area(x, inclination, dr.dot(half, wo))
            table = self.density.eval(mi.Point2f(x, y), self.view(si), active) / area
            cosine = mi.Frame3f.cos_theta(wo) / dr.pi
            pdf = TABLE_SHARE * table + (1 - TABLE_SHARE) * cosine
            return dr.select(active, pdf, 0)

        def eval_pdf(self, ctx, si, wo, active=True):
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def sample(self, ctx, si, sample1, sample2, active=True):
            active = active & (mi.Frame3f.cos_theta(si.wi) > 0)
            place, _ = self.density.sample(sample2, self.view(si), active)
            sin, cos = dr.sincos(dr.pi / 2 * place.x**TABLE_POWER)
            sin_turn, cos_turn = dr.sincos(dr.two_pi * place.y + self.origin(si))
            half = mi.Vector3f(sin * cos_turn, sin * sin_turn, cos)
            mirrored = 2 * dr.dot(half, si.wi) * half - si.wi
            by_cosine = mi.warp.square_to_cosine_hemisphere(sample2)
            sample = mi.BSDFSample3f()
            sample.wo = dr.select(sample1 < TABLE_SHARE, mirrored, by_cosine)
            sample.eta = 1
            sample.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            sample.sampled_component = mi.UInt32(0)
            f, sample.pdf = self.eval_pdf(ctx, si, sample.wo, active)
            active = active & (sample.pdf > 0)
            return sample, dr.select(active, f / sample.pdf, dr.zeros(mi.Spectrum))

        def is_above(self, ctx, si, wo, active):
            if not ctx.is_enabled(mi.BSDFFlags.GlossyReflection):
                return mi.Bool(False)
            cos_theta = mi.Frame3f.cos_theta
            return active & (cos_theta(si.wi) > 0) & (cos_theta(wo) > 0)

        def view(self, si):
            """Arguments of the density: inclination of the eye, and azimuth if it matters."""
            inclination = dr.atan2(dr.norm(si.wi.xy), si.wi.z)
            if TABLE_SHAPE[1] == 1:
                return [inclination]
            turn = dr.atan2(si.wi.y, si.wi.x) / TABLE_PERIOD
            return [inclination, TABLE_PERIOD * (turn - dr.floor(turn))]

        def origin(self, si):
            """Azimuth at which rows of the density begin."""
            azimuth = dr.atan2(si.wi.y, si.wi.x)
            if not TABLE_IS_FIXED:
                return azimuth
            return TABLE_PERIOD * dr.floor(azimuth / TABLE_PERIOD)

        def area(self, x, inclination, half_dot_wo):
            """Solid angle of wo for the unit of area of the density."""
            stretch = 4 * TABLE_POWER * dr.pi * dr.pi * x ** (TABLE_POWER - 1)
            return stretch * dr.sin(inclination) * dr.abs(half_dot_wo)

        def to_string(self):
            return f"{NAME}[]"

    return Material


def register():
    """Makes the plugin known to Mitsuba. Is called again when another variant is set."""
    variant = mi.variant()
    if variant is None:
        return
    if variant.startswith("scalar") or "double" in variant or mi.is_spectral:
        mi.register_bsdf(NAME, lambda props: refuse(variant))
        return
    material = make_class()
    mi.register_bsdf(NAME, lambda props: material(props))


def refuse(variant):
    raise RuntimeError(
        f"{NAME} cannot be used with {variant}: it needs a variant that compiles, with numbers of "
        "32 bits and colours of three channels or one: llvm_ad_rgb, cuda_ad_rgb, llvm_ad_mono"
    )


def scene(size=512):
    """A scene that shows the material: a sphere on a ground, in an even sky and a large lamp."""
    to_world = mi.ScalarTransform4f
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6},
        "sensor": {
            "type": "perspective",
            "fov": 28,
            "to_world": to_world().look_at([0, -6, 2.2], [0, 0, 0.95], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": size, "height": size},
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.4}},
        "lamp": {
            "type": "rectangle",
            "to_world": to_world().look_at([-3, -3, 5], [0, 0, 1], [0, 1, 0]),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 6}},
        },
        "ground": {
            "type": "rectangle",
            "to_world": to_world().scale([20, 20, 1]),
            "material": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.3}},
        },
        "ball": {
            "type": "sphere",
            "to_world": to_world().translate([0, 0, 1]),
            "material": {"type": NAME},
        },
    }


mi.detail.add_variant_callback(lambda old, new: register())
register()

if __name__ == "__main__":
    if mi.variant() is None:
        mi.set_variant("cuda_ad_rgb", "llvm_ad_rgb")
    name = sys.argv[1] if len(sys.argv) > 1 else f"{NAME}.png"
    mi.util.write_bitmap(name, mi.render(mi.load_dict(scene()), spp=256))
    print(name)
