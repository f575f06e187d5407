"""Photographs by Mitsuba of materials on objects, and how far a fit's pictures are from Mitsuba's under other lights.

`make` reads a list of photographs, renders what a camera would take, and writes a target for `brood fit` into the folder of each.
What the target says of the scene may differ from what was rendered: that is one of the grades. `score` compares pictures of
results with Mitsuba's. Both write one JSON object to stdout. Knows of no fit.
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

from mitsuba_against import read, scene_of  # noqa: E402, BSDF classes exist only once a variant is set

# Codes of 8 bits: where a pixel of this rank is displayed, the rest is clipped.
BRIGHT_SHARE = 0.995
BRIGHT_CODE = 0.9
DISPLAY_CD_M2 = 100.0


def render(photograph, scene, samples, seed, max_depth=2):
    folder = pathlib.Path(photograph["folder"])
    lights = [light | ({"image": str(folder / light["image"])} if "image" in light else {}) for light in scene["lights"]]
    case = {
        "scene": scene | {"lights": lights}, "mesh": photograph["mesh"], "bsdf": photograph["bsdf"], "others": [],
        "size_px": photograph["size_px"], "samples": samples, "sampler": "multijitter", "max_depth": max_depth,
    }
    return numpy.array(mitsuba.render(scene_of(case), spp=case["samples"], seed=seed))


def display(linear):
    low = linear <= 0.0031308
    return numpy.where(low, 12.92 * linear, 1.055 * numpy.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def linear_of(code):
    return ((code + 0.055) / 1.055) ** 2.4


def bright(linear):
    """Largest channel of the pixel of that rank among those with light."""
    largest = linear.max(axis=2)
    return numpy.quantile(largest[largest > 0], BRIGHT_SHARE)


def write(path, picture):
    """A linear picture as .exr, codes of 8 bits as .png."""
    bitmap = mitsuba.Bitmap(picture)
    if picture.dtype == numpy.uint8:
        bitmap.set_srgb_gamma(True)
    bitmap.write(str(path))


def dusted(linear, share, draw):
    """With specks of 1 to 3 pixels a side on this share of the pixels: half of them bright, half dark."""
    linear = linear.copy()
    height, width = linear.shape[:2]
    light = 0.3 * bright(linear)
    # A speck has 14 / 3 pixels in the mean.
    for number in range(round(share * width * height * 3 / 14)):
        side = draw.integers(1, 4)
        row, column = draw.integers(0, height), draw.integers(0, width)
        speck = linear[row : row + side, column : column + side]
        speck[:] = numpy.maximum(speck, light) if number % 2 else 0.15 * speck
    return linear


def take(photograph, index, picture):
    """One picture: renders the scene as it was, and returns the view that the target states."""
    folder = pathlib.Path(photograph["folder"])
    linear = render(photograph, picture["taken"], photograph["samples"], 1 + index, picture["max_depth"])
    stated = dict(picture["stated"])
    if picture["noise"] is None:
        file = f"picture-{index + 1}.exr"
        write(folder / file, linear.astype(numpy.float32))
    else:
        # As a camera that is set for the bright parts: the noise is added before clipping.
        ev = math.log2(linear_of(BRIGHT_CODE) / bright(linear))
        draw = numpy.random.default_rng(picture["seed"])
        if picture.get("dust"):
            linear = dusted(linear, picture["dust"], numpy.random.default_rng(1000 + picture["seed"]))
        codes = display(linear * 2.0**ev) + draw.normal(0.0, picture["noise"], linear.shape)
        file = f"picture-{index + 1}.png"
        write(folder / file, (codes.clip(0, 1) * 255 + 0.5).astype(numpy.uint8))
        stated["film"] = {"exposure": ev, "tone": "none"}
    view = {"picture": file, "scene": stated}
    if picture["refine"]:
        view["refine"] = picture["refine"]
    return view | ({"mesh": photograph["mesh"]} if photograph["mesh"] else {})


def make(photographs):
    for photograph in photographs:
        folder = pathlib.Path(photograph["folder"])
        folder.mkdir(parents=True, exist_ok=True)
        views = [take(photograph, index, picture) for index, picture in enumerate(photograph["pictures"])]
        (folder / "target.json").write_text(json.dumps({"views": views}))
        for index, test in enumerate(photograph["tests"]):
            name, scene = test["name"], test["scene"]
            picture = render(photograph | {"mesh": test["mesh"]}, scene, photograph["test_samples"], 101 + index)
            write(folder / f"{name}.exr", picture.astype(numpy.float32))
            (folder / f"{name}.json").write_text(json.dumps(scene))
        print(photograph["name"], file=sys.stderr)
    return {"photographs": len(photographs), "mitsuba": mitsuba.__version__}


def score(pairs):
    """Of each pair of (reference, picture): root mean square error over the reference's mean, and the luminance in cd/m2 of
    linear 1 on a display of 100 cd/m2 that is exposed for the reference's bright parts."""
    errors, whites = [], []
    for reference, picture in pairs:
        wanted, found = read(reference), read(picture)
        errors.append(float(numpy.sqrt(numpy.mean((found - wanted) ** 2)) / numpy.mean(wanted)))
        whites.append(float(DISPLAY_CD_M2 * linear_of(BRIGHT_CODE) / bright(wanted)))
    return {"relative_rmse": errors, "white_cd_m2": whites}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("task", choices=["make", "score"])
    parser.add_argument("list", help="a JSON file")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()
    drjit.set_thread_count(options.threads)
    work = json.loads(pathlib.Path(options.list).read_text())
    print(json.dumps({"make": make, "score": score}[options.task](work)))


if __name__ == "__main__":
    main()
