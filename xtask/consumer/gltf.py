"""Tests exported glTF previews: python gltf.py DIR

DIR holds cases.json and files of `brood bench consumer --format gltf`. Khronos's validator reads
each file, and the material in it is evaluated by the formulas of the specification (appendix B and
the extensions), written here a second time. Sheen's share of the light is integrated. The values
are compared with those that brood states and with the reference. Prints one line of JSON for each
material, then one with the summary. Exits with 1 if a file has errors or a bound is exceeded.
"""

import json
import math
import struct
import subprocess
import sys
from pathlib import Path

import numpy

from cases import doubles, finish, listed

# Bound of the difference from brood's own values, mean |df cos| / mean f cos: brood interpolates
# sheen's share of the light.
FIT_ERROR = 0.01


def unit(vectors):
    return vectors / numpy.linalg.norm(vectors, axis=-1, keepdims=True)


def document(path):
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length])


def ggx(light, eye, half, along, across):
    """D V of the specification, of the extension for anisotropy."""
    along, across = max(along, 1e-3), max(across, 1e-3)
    squared = (half[:, 0] / along) ** 2 + (half[:, 1] / across) ** 2 + half[:, 2] ** 2
    density = 1 / (math.pi * along * across * squared**2)

    def stretched(w):
        return numpy.sqrt((along * w[:, 0]) ** 2 + (across * w[:, 1]) ** 2 + w[:, 2] ** 2)

    return density * 0.5 / (eye[:, 2] * stretched(light) + light[:, 2] * stretched(eye))


def sheen(light, eye, roughness):
    alpha = max(roughness**2, 1e-3)
    half = unit(light + eye)
    sin2 = numpy.maximum(1 - half[..., 2] ** 2, 0)
    density = (2 + 1 / alpha) * sin2 ** (0.5 / alpha) / (2 * math.pi)
    rough = numpy.array([21.5473, 3.82987, 0.19823, -1.97760, -4.32054])
    smooth = numpy.array([25.3245, 3.32435, 0.16801, -1.27393, -4.85967])
    a, b, c, d, e = rough + (smooth - rough) * (1 - alpha) ** 2

    def line(x):
        return a / (1 + b * x**c) + d * x + e

    def shadowing(x):
        return numpy.exp(numpy.where(x < 0.5, line(x), 2 * line(0.5) - line(1 - x)))

    light_z, eye_z = light[..., 2], eye[..., 2]
    return density / ((1 + shadowing(light_z) + shadowing(eye_z)) * 4 * light_z * eye_z)


def sheen_shares(eye, roughness):
    """Light that sheen of weight 1 reflects, for each direction to the eye."""
    cosines = numpy.linspace(0.01, 1, 65)
    heights = (numpy.arange(64) + 0.5) / 64
    turns = (numpy.arange(64) + 0.5) * 2 * math.pi / 64
    z, turn = (grid.ravel() for grid in numpy.meshgrid(heights, turns))
    sine = numpy.sqrt(1 - z * z)
    light = numpy.stack([sine * numpy.cos(turn), sine * numpy.sin(turn), z], axis=-1)
    shares = []
    for cosine in cosines:
        view = numpy.array([math.sqrt(1 - cosine * cosine), 0, cosine])
        shares.append((sheen(light, view, roughness) * z).mean() * 2 * math.pi)
    return numpy.interp(eye[:, 2], cosines, shares)


def values(material, light, eye):
    """f of each pair: red, green, blue."""
    extensions = material.get("extensions", {})
    core = material["pbrMetallicRoughness"]
    base = numpy.array(core["baseColorFactor"][:3])
    half = unit(light + eye)
    schlick = (1 - numpy.minimum(abs((half * eye).sum(axis=1)), 1))[:, None] ** 5
    alpha = core["roughnessFactor"] ** 2
    anisotropy = extensions.get("KHR_materials_anisotropy", {})
    stretched = alpha + (1 - alpha) * anisotropy.get("anisotropyStrength", 0) ** 2
    is_across = anisotropy.get("anisotropyRotation", 0) > 1
    widths = (alpha, stretched) if is_across else (stretched, alpha)
    highlight = ggx(light, eye, half, *widths)[:, None]
    metal = highlight * (base + (1 - base) * schlick)
    specular = extensions.get("KHR_materials_specular", {})
    weight = specular.get("specularFactor", 1)
    normal = numpy.minimum(0.04 * numpy.array(specular.get("specularColorFactor", [1] * 3)), 1)
    normal = normal * weight
    fresnel = normal + (weight - normal) * schlick
    kept = 1 - fresnel.max(axis=1, keepdims=True)
    dielectric = kept * base / math.pi + fresnel * highlight
    metallic = core["metallicFactor"]
    f = (1 - metallic) * dielectric + metallic * metal
    if "KHR_materials_sheen" in extensions:
        cloth = extensions["KHR_materials_sheen"]
        colour = numpy.array(cloth["sheenColorFactor"])
        roughness = cloth["sheenRoughnessFactor"]
        kept = 1 - colour.max() * sheen_shares(eye, roughness)[:, None]
        f = colour * sheen(light, eye, roughness)[:, None] + numpy.maximum(kept, 0) * f
    if "KHR_materials_clearcoat" in extensions:
        coat = extensions["KHR_materials_clearcoat"]
        width = coat["clearcoatRoughnessFactor"] ** 2
        share = coat["clearcoatFactor"] * (0.04 + 0.96 * (1 - eye[:, 2:3]) ** 5)
        f = (1 - share) * f + share * ggx(light, eye, half, width, width)[:, None]
    return f


def relative(found, wanted):
    total = abs(wanted).sum()
    return float(abs(found - wanted).sum() / (total if total > 0 else 1))


def main():
    folder = Path(sys.argv[1])
    script = Path(__file__).with_suffix(".mjs")
    printed = subprocess.run(
        ["node", script, folder], check=True, capture_output=True, text=True
    ).stdout
    validated = json.loads(printed)
    given = listed(folder)
    pairs = doubles(given["pairs"]).reshape(-1, 8)
    light, eye = unit(pairs[:, :3]), unit(pairs[:, 3:6])
    cosine = light[:, 2:3]
    results = []
    for case in given["cases"]:
        if "file" not in case:
            continue
        material = document(folder / case["file"])["materials"][0]
        found = values(material, light, eye) * cosine
        result = {
            "name": case["name"],
            "errors": validated["errors"][case["file"]],
            "fit_error": relative(found, doubles(case["fit"]).reshape(-1, 3) * cosine),
            "value_error": relative(found, doubles(case["f"]).reshape(-1, 3) * cosine),
            "note": case["note"],
        }
        is_stated = material["extras"]["description"] == case["note"]
        is_valid = result["errors"] == 0 and is_stated
        result["passed"] = is_valid and result["fit_error"] <= FIT_ERROR
        print(json.dumps(result), flush=True)
        results.append(result)
    worst = max(result["fit_error"] for result in results)
    return finish(f"gltf-validator {validated['version']}", given["cases"], results, worst_fit_error=worst)


if __name__ == "__main__":
    sys.exit(main())
