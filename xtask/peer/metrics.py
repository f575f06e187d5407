"""FLIP, SSIM and Delta E_ITP of two PNG pictures by packages of others, as one JSON object on stdout."""

import json
import sys
import warnings

import numpy

warnings.filterwarnings("ignore")

import colour
import flip_evaluator
from PIL import Image
from skimage.metrics import structural_similarity

# Luminance of linear 1 in cd/m2.
WHITE = 100.0


def read(path):
    """sRGB over black, the light of edges being added up, not their codes."""
    codes = numpy.asarray(Image.open(path).convert("RGBA"), dtype=numpy.float64) / 255.0
    light = colour.models.eotf_sRGB(codes[..., :3]) * codes[..., 3:]
    return colour.models.eotf_inverse_sRGB(light)


def itp(picture):
    spaces = colour.RGB_COLOURSPACES
    to_2020 = colour.matrix_RGB_to_RGB(spaces["sRGB"], spaces["ITU-R BT.2020"], chromatic_adaptation_transform=None)
    linear = colour.models.eotf_sRGB(picture) * WHITE
    return colour.RGB_to_ICtCp(linear @ to_2020.T, method="Dolby 2016")


def main():
    a, b = (read(path) for path in sys.argv[1:3])
    flip = flip_evaluator.evaluate(a.astype(numpy.float32), b.astype(numpy.float32), "LDR")[1]
    ssim = structural_similarity(
        a, b, channel_axis=2, data_range=1.0, gaussian_weights=True, sigma=1.5, use_sample_covariance=False
    )
    difference = float(numpy.mean(colour.difference.delta_E_ITP(itp(a), itp(b))))
    print(json.dumps({"flip": float(flip), "ssim": float(ssim), "itp": difference}))


if __name__ == "__main__":
    main()
