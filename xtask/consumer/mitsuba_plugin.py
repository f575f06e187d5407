"""Tests exported plugins in Mitsuba: python mitsuba_plugin.py DIR

DIR holds cases.json and files of `brood bench consumer --format mitsuba`. Each material is loaded as
a user would, then

- f times the cosine is compared with the values of the reference,
- Mitsuba's chi-square test compares samples with the density, for three directions of the eye,
- the derivative by f's direction is compared with differences, for some materials,
- the variance of one sample in an even sky is measured, with the plugin's samples and by the cosine,
- a sphere is rendered under an environment with a small sun, with the plugin's samples and by the
  cosine, both beside samples of the environment; the variances of the pixels are compared, for some
  materials.

Prints one line of JSON for each material, then one with the summary. Exits with 1 if a bound is
exceeded.
"""

import importlib.util
import json
import statistics
import sys
import time

import drjit as dr
import mitsuba as mi
from mitsuba_shared import VIEWS, doubles, interaction, tested, variances

# Bounds of the error of values, mean |df cos| / mean f cos: the larger of this, and of this times
# the change by rounding directions and texture positions to numbers of 32 bits.
VALUE_ERROR = 1e-5
ROUNDING_RATIO = 2
# Level of significance of the chi-square test, over all directions of a material.
SIGNIFICANCE = 0.01
# Materials that are rendered, and samples per pixel.
RENDERED = ["red-plastic", "car-paint", "velvet", "gold", "brushed-metal", "random-0", "random-12"]
RENDERED_SAMPLES = 256


def load(path):
    """Imports a file of Python."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def value_error(bsdf, pairs, wanted):
    si = interaction(pairs.to_eye, pairs.uv)
    found = bsdf.eval(mi.BSDFContext(), si, pairs.to_light)
    difference, total = 0.0, 0.0
    for channel in range(3):
        for value, f, cosine in zip(found[channel], wanted[channel::3], pairs.cosine):
            difference += abs(value - f * cosine)
            total += f * cosine
    return difference / total if total > 0 else difference


class HalfDomain:
    """Half vectors, for highlights that are too narrow for the sphere's even cells.

    The first coordinate is (1 - cos theta_h)^(1/4), the second the azimuth.
    """

    def __init__(self, eye):
        self.eye = mi.Vector3f(eye)

    def bounds(self):
        return mi.ScalarBoundingBox2f([0, -dr.pi], [1, dr.pi])

    def aspect(self):
        return 1

    def map_forward(self, p):
        off = p.x**4
        sin_theta = dr.safe_sqrt(off * (2 - off))
        sin_phi, cos_phi = dr.sincos(p.y)
        half = mi.Vector3f(sin_theta * cos_phi, sin_theta * sin_phi, 1 - off)
        return 2 * dr.dot(half, self.eye) * half - self.eye

    def map_backward(self, to_light):
        half = dr.normalize(to_light + self.eye)
        off = dr.squared_norm(half.xy) / (1 + half.z)
        return mi.Vector2f(off**0.25, dr.atan2(half.y, half.x))

    def area(self, to_light):
        """Solid angle of directions to the light for the unit of area of the domain."""
        half = dr.normalize(to_light + self.eye)
        off = dr.squared_norm(half.xy) / (1 + half.z)
        return 16 * off**0.75 * dr.abs(dr.dot(half, self.eye))


def adapter(bsdf, eye):
    """As mitsuba.chi2.BSDFAdapter, which leaves out samples of value 0: they are valid too."""
    context = mi.BSDFContext()

    def at(count):
        return interaction(dr.repeat(mi.Vector3f(eye), count), mi.Point2f(0.5, 0.5))

    def sample(u):
        found, _ = bsdf.sample(context, at(dr.width(u)), u[0], mi.Point2f(u[1], u[2]))
        return found.wo, dr.select(found.pdf > 0, mi.Float(1), mi.Float(0))

    def pdf(to_light):
        return bsdf.pdf(context, at(dr.width(to_light)), to_light)

    return sample, pdf


def chi_square(bsdf):
    """The domain in which the test passes for all directions of the eye, or None."""
    from mitsuba.chi2 import ChiSquareTest, SphericalDomain

    is_even = True
    for inclination, azimuth in VIEWS:
        theta, phi = inclination * dr.pi / 180, azimuth * dr.pi / 180
        eye = [dr.sin(theta) * dr.cos(phi), dr.sin(theta) * dr.sin(phi), dr.cos(theta)]
        sample, pdf = adapter(bsdf, eye)
        half = HalfDomain(eye)

        def pdf_of_half(to_light):
            return pdf(to_light) * half.area(to_light)

        # The last two integrate the density over more places of a cell.
        sphere = SphericalDomain()
        coarse = [(sphere, pdf, 16), (half, pdf_of_half, 16)]
        tries = coarse + [(sphere, pdf, 48), (half, pdf_of_half, 48)]
        for domain, pdf_func, places in tries:
            test = ChiSquareTest(
                domain=domain, sample_func=sample, pdf_func=pdf_func, sample_dim=3,
                sample_count=1000000, res=101, ires=places,
            )
            if test.run(SIGNIFICANCE, test_count=len(VIEWS), quiet=True):
                break
            is_even = False
        else:
            return None
    return "sphere" if is_even else "half vectors"


def environment():
    """A sky that is brighter above, with a sun of two degrees."""
    width, height = 128, 64
    numbers = []
    for row in range(height):
        for column in range(width):
            sky = 0.2 + 0.8 * (1 - row / height)
            is_sun = abs(row - 18) < 1 and abs(column - 40) < 1
            numbers += [200.0 if is_sun else sky] * 3
    return mi.Bitmap(mi.TensorXf(mi.Float(numbers), shape=(height, width, 3)))


def rendered_variance(name):
    """Mean variance of a sample of a pixel, relative to the square of the mean brightness."""
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "moment", "nested": {"type": "path", "max_depth": 2}},
        "sensor": {
            "type": "perspective",
            "fov": 28,
            "to_world": mi.ScalarTransform4f().look_at([0, -4, 0.8], [0, 0, 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": 96, "height": 96, "rfilter": {"type": "box"}},
        },
        "sky": {"type": "envmap", "bitmap": environment()},
        "ball": {"type": "sphere", "material": {"type": name}},
    })
    picture = mi.render(scene, spp=RENDERED_SAMPLES)
    channels = picture.shape[2]
    values = picture.array
    pixels = dr.arange(mi.UInt32, picture.shape[0] * picture.shape[1]) * channels
    # The last channels are first and second moments of X, Y, Z.
    first, second = (dr.gather(mi.Float, values, pixels + channels - k) for k in (5, 2))
    return (dr.mean(second - first * first) / dr.mean(first) ** 2)[0]


def derivative_error(bsdf, pairs):
    """The median relative error of the derivative of f cos by a turn of the light."""
    angle = mi.Float(0)
    dr.enable_grad(angle)

    def turned(angle):
        sin, cos = dr.sincos(angle)
        light = pairs.to_light
        return mi.Vector3f(light.x, cos * light.y - sin * light.z, sin * light.y + cos * light.z)

    si = interaction(pairs.to_eye, pairs.uv)
    f = bsdf.eval(mi.BSDFContext(), si, turned(angle))
    dr.forward(angle)
    derivative = list(dr.grad(f)[1])
    step = 1e-3
    high, low = (bsdf.eval(mi.BSDFContext(), si, turned(mi.Float(x)))[1] for x in (step, -step))
    values = zip(derivative, (high - low) / (2 * step), high + low)
    errors = [abs(a - b) / max(abs(b), 1e-2 * c, 1e-6) for a, b, c in values]
    return statistics.median(errors)


def test(case, folder, pairs):
    started = time.time()
    module = load(folder / case["file"])
    bsdf = mi.load_dict({"type": module.NAME})
    wanted = doubles(case["f"])
    error = value_error(bsdf, pairs, wanted)
    table, cosine = variances(bsdf)
    found = {
        "name": case["name"],
        "value_error": error,
        "chi_square": chi_square(bsdf),
        "derivative_error": derivative_error(bsdf, pairs),
        "variance": table,
        "cosine_variance": cosine,
        "seconds": round(time.time() - started, 2),
    }
    if case["name"] in RENDERED:
        found["rendered_variance"] = rendered_variance(module.NAME)
        module.TABLE_SHARE = 0.0
        found["rendered_cosine_variance"] = rendered_variance(module.NAME)
    bound = max(VALUE_ERROR, ROUNDING_RATIO * case["rounding"])
    found["bound"] = bound
    found["passed"] = error <= bound and found["chi_square"] is not None
    return found


def main():
    found, refused = tested(test)
    errors = [result["value_error"] for result in found]
    # Variances below 1e-3 are noise of the estimate.
    ratios = [(r["cosine_variance"] + 1e-3) / (r["variance"] + 1e-3) for r in found]
    failed = [result["name"] for result in found if not result["passed"]]
    summary = {
        "consumer": f"mitsuba {mi.__version__}",
        "materials": len(found),
        "refused": refused,
        "worst_error": max(errors),
        "median_error": statistics.median(errors),
        "median_derivative_error": statistics.median(r["derivative_error"] for r in found),
        "variance_ratio": {"median": statistics.median(ratios), "worst": min(ratios)},
        "failed": failed,
    }
    print(json.dumps(summary))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
