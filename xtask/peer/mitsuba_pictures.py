"""Mitsuba's llvm variant on the pictures that brood makes: a Lambert sphere, known materials, new materials.

Writes one JSON object to stdout. Pictures come back to numpy as linear float RGB; nothing is encoded. The scene is
loaded and the kernel compiled before a time counts, except for new materials, where that is the work.
"""

import argparse
import json
import math
import time

import drjit
import mitsuba
import numpy

mitsuba.set_variant("llvm_ad_rgb")

from expression_bsdf import Expression  # noqa: E402, a BSDF class exists only once a variant is set

LIGHT = numpy.array([1.0, 1.0, math.sqrt(2.0)]) / 2.0
REFERENCE_SPP = 4096
# Multijittered samples fill a grid; these are products that it does not have to round up.
SPP = [4, 16, 36, 64, 100, 144, 196, 256, 289, 324, 342, 361, 400, 484, 576, 784, 1024]


def scene_of(bsdf, size_px, spp):
    """A unit sphere seen orthographically over [-1.05, 1.05]^2 with one directional light of irradiance pi."""
    transform = mitsuba.ScalarTransform4f()
    camera = transform.look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0])
    return mitsuba.load_dict({
        "type": "scene",
        # The light is a delta: only sampling it finds it, so half of the integrator's work can be left out.
        "integrator": {
            "type": "direct", "emitter_samples": 1, "bsdf_samples": 0, "hide_emitters": True,
        },
        "sensor": {
            "type": "orthographic",
            "to_world": camera @ transform.scale([1.05, 1.05, 1.0]),
            "film": {
                "type": "hdrfilm", "width": size_px, "height": size_px,
                "pixel_format": "rgb", "component_format": "float32",
                # Any other filter blurs over pixels, which is another picture.
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "multijitter", "sample_count": spp},
        },
        "sphere": {"type": "sphere", "bsdf": bsdf},
        "light": {
            "type": "directional",
            "direction": [float(-x) for x in LIGHT],
            "irradiance": {"type": "rgb", "value": math.pi},
        },
    })


def render(scene, spp, seed):
    image = mitsuba.render(scene, spp=spp, seed=seed)
    return numpy.array(image)


def rmse(a, b):
    return float(numpy.sqrt(numpy.mean((a.astype(numpy.float64) - b) ** 2)))


def exact_lambert(size_px, spp, albedo):
    """The same picture by arithmetic alone, to see that the scene is the one that is meant."""
    grid = (numpy.arange(size_px * spp) + 0.5) / (size_px * spp) * 2.1 - 1.05
    x, y = numpy.meshgrid(grid, -grid)
    inside = x * x + y * y < 1.0
    z = numpy.sqrt(numpy.where(inside, 1.0 - x * x - y * y, 0.0))
    cosine = numpy.where(inside, numpy.maximum(LIGHT[0] * x + LIGHT[1] * y + LIGHT[2] * z, 0.0), 0.0)
    mean = cosine.reshape(size_px, spp, size_px, spp).mean(axis=(1, 3))
    return numpy.repeat(mean[:, :, None] * albedo, 3, axis=2)


def sphere(options):
    """Error and time of a Lambert sphere for each number of samples, up to the first one that is exact enough."""
    reflectance = {"type": "rgb", "value": [options.albedo] * 3}
    scene = scene_of({"type": "diffuse", "reflectance": reflectance}, 256, 16)
    reference = render(scene, REFERENCE_SPP, 1_000_003).astype(numpy.float64)
    # The second reference shows what the first one's own noise adds: it has to be far below what is measured.
    noise = rmse(render(scene, REFERENCE_SPP, 2_000_003), reference) / math.sqrt(2.0)
    exact = rmse(exact_lambert(256, 32, options.albedo), reference)
    if exact > 1e-3 * options.albedo:
        raise SystemExit(f"the scene is not the one that is meant: off by {exact}")
    rows = []
    for spp in SPP:
        rows.append(sphere_row(scene, reference, spp, options.repeats))
        if rows[-1]["rmse"] <= options.rmse:
            break
    if options.picture:
        mitsuba.util.write_bitmap(options.picture, mitsuba.Bitmap(reference.astype(numpy.float32)))
    return {
        "size_px": 256, "albedo": options.albedo, "reference_spp": REFERENCE_SPP,
        "reference_noise": noise, "rmse_against_arithmetic": exact, "rmse_wanted": options.rmse,
        "rows": rows,
    }


def sphere_row(scene, reference, spp, repeats):
    # Compiles for this number of samples.
    render(scene, spp, 0)
    times, errors = [], []
    for seed in range(1, repeats + 1):
        start = time.perf_counter()
        image = render(scene, spp, seed)
        times.append((time.perf_counter() - start) * 1e3)
        errors.append(rmse(image, reference))
        if len(times) >= 5 and sum(times) > 4e3:
            break
    return {
        "spp": spp, "rmse": float(numpy.mean(errors)), "rmse_largest": max(errors),
        "ms": min(times), "median_ms": float(numpy.median(times)), "repeats": len(times),
    }


def known_materials(options):
    """Analytic materials with other parameters each time; the kernels are warm."""
    rows = []
    grey = {"type": "rgb", "value": [0.5, 0.5, 0.5]}
    materials = {
        "diffuse": ({"type": "diffuse", "reflectance": grey}, "reflectance.value", None),
        "roughconductor": (
            {"type": "roughconductor", "material": "Au", "alpha": 0.2, "specular_reflectance": grey},
            "specular_reflectance.value", "alpha.value",
        ),
        "principled": (
            {"type": "principled", "base_color": grey, "roughness": 0.3, "metallic": 0.2, "clearcoat": 0.5},
            "base_color.value", "roughness.value",
        ),
    }
    draw = numpy.random.default_rng(options.seed)
    for name, (bsdf, colour, number) in materials.items():
        scene = scene_of(bsdf, options.size, options.spp)
        parameters = mitsuba.traverse(scene)

        def one(seed):
            parameters["sphere.bsdf." + colour] = mitsuba.Color3f(*map(float, draw.uniform(0.05, 0.9, 3)))
            if number:
                parameters["sphere.bsdf." + number] = float(draw.uniform(0.1, 0.5))
            parameters.update()
            return render(scene, options.spp, seed)

        for seed in range(3):
            one(seed)
        times = []
        for repeat in range(options.repeats):
            start = time.perf_counter()
            for index in range(options.materials):
                one(100 + repeat * options.materials + index)
            times.append((time.perf_counter() - start) * 1e3)
        rows.append({"material": name, "total_ms": min(times), "median_total_ms": float(numpy.median(times))})
    return {"size_px": options.size, "spp": options.spp, "materials": options.materials, "rows": rows}


def nested(draw, depth):
    """A random nest of blended built-in materials; its structure, not only its numbers, is random."""
    if depth == 0 or draw.random() < 0.15:
        leaf = draw.choice(["diffuse", "roughconductor", "roughplastic", "principled", "plastic"])
        colour = {"type": "rgb", "value": [float(v) for v in draw.uniform(0.1, 0.9, 3)]}
        alpha = float(draw.uniform(0.1, 0.5))
        return {
            "diffuse": {"type": "diffuse", "reflectance": colour},
            "roughconductor": {"type": "roughconductor", "specular_reflectance": colour, "alpha": alpha},
            "roughplastic": {"type": "roughplastic", "diffuse_reflectance": colour, "alpha": alpha},
            "principled": {"type": "principled", "base_color": colour, "roughness": alpha},
            "plastic": {"type": "plastic", "diffuse_reflectance": colour},
        }[leaf]
    return {
        "type": "blendbsdf", "weight": float(draw.uniform(0.2, 0.8)),
        "first": nested(draw, depth - 1), "second": nested(draw, depth - 1),
    }


def new_materials(options):
    """Materials of a structure never seen before: Dr.Jit traces and compiles a kernel for each."""
    drjit.set_flag(drjit.JitFlag.KernelHistory, True)
    draw = numpy.random.default_rng(options.seed)
    # Loads plugins and compiles what does not depend on the material.
    render(scene_of(nested(draw, 2), options.size, options.spp), options.spp, 0)
    kinds = {
        "nested built-in materials": lambda: nested(draw, 3),
        "expressions": lambda: Expression.random(draw, options.operations),
    }
    rows = []
    for name, make in kinds.items():
        drjit.kernel_history_clear()
        times, pictures = [], []
        for index in range(options.materials):
            bsdf = make()
            start = time.perf_counter()
            pictures.append(render(scene_of(bsdf, options.size, options.spp), options.spp, index))
            times.append((time.perf_counter() - start) * 1e3)
        kernels = [k for k in drjit.kernel_history() if k["type"] == drjit.KernelType.JIT]
        compiled = [k for k in kernels if not k["cache_hit"]]
        rows.append({
            "kind": name, "total_ms": sum(times), "fastest_ms": min(times), "slowest_ms": max(times),
            "kernels_compiled": len(compiled),
            "compile_ms": float(sum(k["backend_time"] for k in compiled)),
            "finite_share": float(numpy.mean([numpy.isfinite(p).all() for p in pictures])),
        })
        if options.picture:
            sheet = numpy.concatenate([p.astype(numpy.float32) for p in pictures[:10]], axis=1)
            mitsuba.util.write_bitmap(f"{options.picture}-{name.split()[0]}.png", mitsuba.Bitmap(sheet))
    return {
        "size_px": options.size, "spp": options.spp, "materials": options.materials,
        "operations": options.operations, "rows": rows,
    }


def main():
    work = {"sphere": sphere, "known": known_materials, "new": new_materials}
    parser = argparse.ArgumentParser()
    parser.add_argument("work", choices=work)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--rmse", type=float, default=1.7e-4)
    parser.add_argument("--albedo", type=float, default=1.0)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--materials", type=int, default=20)
    parser.add_argument("--operations", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--picture", help="write what was rendered here, for looking at")
    options = parser.parse_args()
    drjit.set_thread_count(options.threads)
    result = work[options.work](options)
    print(json.dumps(result | {"threads": options.threads}))


if __name__ == "__main__":
    main()
