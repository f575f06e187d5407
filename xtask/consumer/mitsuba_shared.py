"""Functions of the scripts that test exports in Mitsuba."""

import base64
import json
import statistics
import struct
import sys
from pathlib import Path

import drjit as dr
import mitsuba as mi

# Directions of the eye of the test: inclination and azimuth in degrees.
VIEWS = [(12, 20), (45, 130), (75, 250)]
# Samples for the variance.
COUNT = 1 << 18


def doubles(text):
    data = base64.b64decode(text)
    return struct.unpack(f"<{len(data) // 8}d", data)


def interaction(to_eye, uv):
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(to_eye))
    si.wi = to_eye
    si.uv = uv
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(si.n)
    si.sh_frame.s, si.sh_frame.t = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    return si


class Pairs:
    """Pairs of directions and texture positions of the reference."""

    def __init__(self, text):
        values = doubles(text)
        column = [mi.Float(list(values[k::8])) for k in range(8)]
        self.to_light = mi.Vector3f(*column[0:3])
        self.to_eye = mi.Vector3f(*column[3:6])
        self.uv = mi.Point2f(*column[6:8])
        self.cosine = list(values[2::8])


def variances(bsdf):
    """Relative variances of one sample in an even sky, mean over views: plugin and cosine."""
    sampler = mi.load_dict({"type": "independent"})
    found = []
    for inclination, azimuth in VIEWS:
        theta, phi = inclination * dr.pi / 180, azimuth * dr.pi / 180
        eye = mi.Vector3f(dr.sin(theta) * dr.cos(phi), dr.sin(theta) * dr.sin(phi), dr.cos(theta))
        sampler.seed(7, COUNT)
        uv = mi.Point2f(sampler.next_2d())
        si = interaction(dr.repeat(eye, COUNT), uv)
        context = mi.BSDFContext()
        sample, weight = bsdf.sample(context, si, sampler.next_1d(), sampler.next_2d())
        by_plugin = relative_variance(weight)
        to_light = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        f = bsdf.eval(context, si, to_light)
        by_cosine = relative_variance(f * dr.pi / to_light.z)
        found.append((by_plugin, by_cosine))
    return [statistics.fmean(column) for column in zip(*found)]


def relative_variance(weight):
    mean = (weight[0] + weight[1] + weight[2]) / 3
    mean = dr.select(dr.isfinite(mean), mean, 0)
    first, second = dr.mean(mean)[0], dr.mean(mean * mean)[0]
    return second / (first * first) - 1 if first > 0 else 0


def tested(test):
    """Tests the materials of the folder that the command line names, or those whose names follow.

    Prints and returns the result of each, and the number of refused materials.
    """
    folder, only = Path(sys.argv[1]), sys.argv[2:]
    mi.set_variant("llvm_ad_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    listed = json.loads((folder / "cases.json").read_text())
    pairs = Pairs(listed["pairs"])
    found = []
    for case in listed["cases"]:
        if "file" in case and (not only or case["name"] in only):
            result = test(case, folder, pairs)
            print(json.dumps(result), flush=True)
            found.append(result)
    return found, sum("refused" in case for case in listed["cases"])
