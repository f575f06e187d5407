"""Tests exported shaders in Godot 3: python godot.py DIR

DIR holds cases.json and files of `brood bench consumer --format godot-3`. Writes a project that
draws each material at points, one for each pair of directions, under a directional light, and reads
the pixels of a viewport of half floats. Needs godot3-runner and xvfb-run. Prints one line of JSON
for each material, then one with the summary. Exits with 1 if a bound is exceeded.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy

import scene
from cases import compared, doubles, finish, listed

# Bounds of the error of values, mean |df cos| / mean f cos: the larger of the first, which is the
# rounding of pixels to 11 bits, and of the second times the change by rounding directions and
# texture positions to numbers of 32 bits. The vertices of the mesh round them once more.
VALUE_ERROR = 1e-3
ROUNDING_RATIO = 4
# Brightest value of a picture; pixels hold values up to 65504.
BRIGHTEST = 16384.0
# Time for all materials.
LIMIT_S = 1800

PROJECT = """config_version=4
[application]
run/main_scene="res://main.tscn"
[display]
window/vsync/use_vsync=false
[rendering]
quality/driver/driver_name="GLES3"
quality/driver/fallback_to_gles2=false
"""
MAIN = """[gd_scene load_steps=2 format=2]
[ext_resource path="res://main.gd" type="Script" id=1]
[node name="Main" type="Node"]
script = ExtResource( 1 )
"""


def values(folder, names):
    """Values of f cos times the energy of the light, of each pair."""
    run = subprocess.run(
        ["xvfb-run", "-a", "godot3-runner", "--path", str(folder), "--audio-driver", "Dummy"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
    )
    # Godot draws a material whose shader has errors in white.
    if run.returncode != 0 or "SHADER ERROR" in run.stdout:
        sys.exit(run.stdout)
    pixels = numpy.fromfile(folder / "pixels.bin", dtype="<f2")
    return pixels.reshape(len(names), len(scene.LIGHTS), scene.SIDE * scene.SIDE, 4)


def main():
    folder = Path(sys.argv[1])
    given = listed(folder)
    pairs = scene.Pairs(given["pairs"])
    only = sys.argv[2:]
    cases = [case for case in given["cases"] if "f" in case]
    cases = [case for case in cases if not only or case["name"] in only]
    project = folder / "project"
    project.mkdir(exist_ok=True)
    (project / "project.godot").write_text(PROJECT)
    (project / "main.tscn").write_text(MAIN)
    shutil.copy(Path(__file__).parent / "godot.gd", project / "main.gd")
    # Godot's v grows downwards, and its binormal to smaller v.
    uv = numpy.stack([pairs.uv[:, 0], 1 - pairs.uv[:, 1]], 1)
    energies = []
    for case in cases:
        shutil.copy(folder / case["file"], project)
        wanted = doubles(case["f"]).reshape(-1, 3)
        most = (wanted * pairs.cosine[:, None]).max() * numpy.pi
        energies.append(float(numpy.float32(BRIGHTEST / most)) if most > 0 else 1.0)
    columns = [pairs.picture[:, None], pairs.place, pairs.normal, pairs.tangent, uv]
    description = {
        "side": scene.SIDE,
        "lights": scene.LIGHTS.tolist(),
        "points": numpy.concatenate(columns, axis=1).tolist(),
        "files": [case["file"] for case in cases],
        "energies": energies,
    }
    (project / "scene.json").write_text(json.dumps(description))
    pixels = values(project, cases)
    results = []
    for case, energy, picture in zip(cases, energies, pixels):
        wanted = doubles(case["f"]).reshape(-1, 3)
        found = picture[pairs.picture, pairs.pixel, :3].astype(float) / (energy * numpy.pi)
        # Godot's lights have pi times their energy.
        error = pairs.error(found, wanted)
        result = compared(case, error, VALUE_ERROR, ROUNDING_RATIO)
        print(json.dumps(result), flush=True)
        results.append(result)
    version = subprocess.run(["godot3-runner", "--version"], capture_output=True, text=True)
    return finish(f"Godot {version.stdout.split()[0]}", given["cases"], results)


if __name__ == "__main__":
    sys.exit(main())
