"""Materials recovered from one picture by Mitsuba: its derivatives with Adam, and its pictures with an evolution strategy (pycma).

The picture is Mitsuba's own, of a unit sphere seen orthographically with one directional light of irradiance pi. Target and
trials share one seed and one sample a pixel, so that there is no noise between them: an error of 0 can be reached. Compiling is
done before a time counts. Writes one JSON object to stdout.
"""

import argparse
import json
import math
import sys
import time

import drjit
import mitsuba
import numpy

mitsuba.set_variant("llvm_ad_rgb")

LIGHT = numpy.array([1.0, 1.0, math.sqrt(2.0)]) / 2.0
SEED = 7
RATES = [0.02, 0.05, 0.1, 0.2]


def rgb(value):
    return {"type": "rgb", "value": list(value)}


# Of each material: the plugin, and its unknowns as (parameter, truth, least, largest, whether ratios matter).
MATERIALS = {
    "rough conductor": (
        {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2,
         "eta": rgb([0.143, 0.375, 1.442]), "k": rgb([3.983, 2.386, 1.603])},
        [("eta.value", [0.143, 0.375, 1.442], 0.02, 10.0, (0.1, 5.0), True),
         ("k.value", [3.983, 2.386, 1.603], 1e-3, 20.0, (0.3, 9.0), True),
         ("alpha.value", 0.2, 1e-3, 1.0, (0.03, 1.0), True)],
    ),
    "rough plastic": (
        {"type": "roughplastic", "distribution": "ggx", "alpha": 0.15, "int_ior": 1.5, "ext_ior": 1.0,
         "diffuse_reflectance": rgb([0.6, 0.25, 0.1])},
        [("diffuse_reflectance.value", [0.6, 0.25, 0.1], 0.0, 1.0, (0.05, 0.95), False),
         ("alpha", 0.15, 1e-3, 1.0, (0.03, 1.0), True)],
    ),
    "principled": (
        {"type": "principled", "base_color": rgb([0.7, 0.3, 0.15]), "roughness": 0.35, "metallic": 0.3,
         "specular": 0.5, "clearcoat": 0.6, "clearcoat_gloss": 0.7},
        [("base_color.value", [0.7, 0.3, 0.15], 0.0, 1.0, (0.05, 0.95), False),
         ("roughness.value", 0.35, 0.03, 1.0, (0.2, 0.95), False),
         ("metallic.value", 0.3, 0.0, 1.0, (0.05, 0.95), False),
         ("clearcoat.value", 0.6, 0.0, 1.0, (0.05, 0.95), False),
         ("clearcoat_gloss.value", 0.7, 0.0, 1.0, (0.05, 0.95), False)],
    ),
}


def scene_of(bsdf, size_px):
    transform = mitsuba.ScalarTransform4f()
    camera = transform.look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0])
    return mitsuba.load_dict({
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0, "hide_emitters": True},
        "sensor": {
            "type": "orthographic", "to_world": camera @ transform.scale([1.05, 1.05, 1.0]),
            "film": {
                "type": "hdrfilm", "width": size_px, "height": size_px, "pixel_format": "rgb",
                "component_format": "float32", "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent", "sample_count": 1},
        },
        "sphere": {"type": "sphere", "bsdf": bsdf},
        "light": {
            "type": "directional", "direction": [float(-x) for x in LIGHT],
            "irradiance": {"type": "rgb", "value": math.pi},
        },
    })


class Problem:
    """A material with its picture."""

    def __init__(self, name, size_px):
        bsdf, self.unknowns = MATERIALS[name]
        self.scene = scene_of(bsdf, size_px)
        self.parameters = mitsuba.traverse(self.scene)
        self.wanted = mitsuba.render(self.scene, spp=1, seed=SEED)
        drjit.eval(self.wanted)
        self.keys = ["sphere.bsdf." + unknown[0] for unknown in self.unknowns]
        missing = [key for key in self.keys if key not in self.parameters]
        if missing:
            raise SystemExit(f"{name}: no parameters {missing} among {list(self.parameters.keys())}")

    def sizes(self):
        return [3 if isinstance(unknown[1], list) else 1 for unknown in self.unknowns]

    def start(self, draw):
        values = []
        for (_, _, _, _, (low, high), ratios), size in zip(self.unknowns, self.sizes()):
            shares = draw.uniform(0.0, 1.0, size)
            value = low * (high / low) ** shares if ratios else low + (high - low) * shares
            values.append(value)
        return values

    def kind(self, size, value):
        if size == 3:
            return mitsuba.Color3f(*[float(v) for v in value])
        return mitsuba.Float(float(value[0]))

    def put(self, values):
        for key, size, value in zip(self.keys, self.sizes(), values):
            self.parameters[key] = self.kind(size, value)
        self.parameters.update()

    def rmse(self):
        image = mitsuba.render(self.scene, spp=1, seed=SEED)
        return float(drjit.sqrt(drjit.mean(drjit.square(image - self.wanted), axis=None)).array[0])


def adam(problem, draw, options):
    """One start of Adam on the mean square of the picture; numbers that matter by ratios are optimised as logarithms."""
    sizes = problem.sizes()
    values = problem.start(draw)
    optimizer = mitsuba.ad.Adam(lr=options.rate)
    for key, size, value, unknown in zip(problem.keys, sizes, values, problem.unknowns):
        optimizer[key] = problem.kind(size, numpy.log(value) if unknown[5] else value)
    start = time.perf_counter()
    best, least, steps = math.inf, options.rmse**2, 0
    for step in range(options.steps):
        # From the first rate to a hundredth of it, so that it settles.
        optimizer.set_learning_rate(options.rate * 0.01 ** (step / options.steps))
        for key, unknown in zip(problem.keys, problem.unknowns):
            low, high = (math.log(unknown[2]), math.log(unknown[3])) if unknown[5] else unknown[2:4]
            optimizer[key] = drjit.clip(optimizer[key], low, high)
            problem.parameters[key] = drjit.exp(optimizer[key]) if unknown[5] else optimizer[key]
        problem.parameters.update()
        image = mitsuba.render(problem.scene, problem.parameters, spp=1, seed=SEED, seed_grad=SEED + 1)
        loss = drjit.mean(drjit.square(image - problem.wanted), axis=None)
        drjit.backward(loss)
        error = float(loss.array[0])
        steps = step + 1
        best = min(best, error) if math.isfinite(error) else best
        if error <= least:
            break
        optimizer.step()
    return {"seconds": time.perf_counter() - start, "rmse": math.sqrt(best), "steps": steps}


def evolution(problem, draw, options):
    """One start of pycma on Mitsuba's pictures: shares of the unknowns' ranges, ranges of ratios by logarithms."""
    import cma

    sizes = problem.sizes()

    def into(values):
        shares = []
        for value, unknown in zip(values, problem.unknowns):
            low, high = unknown[2:4]
            share = numpy.log(value / low) / math.log(high / low) if unknown[5] else (value - low) / (high - low)
            shares.extend(numpy.atleast_1d(share))
        return shares

    def out(shares):
        values, at = [], 0
        for unknown, size in zip(problem.unknowns, sizes):
            low, high = unknown[2:4]
            share = numpy.asarray(shares[at:at + size])
            values.append(low * (high / low) ** share if unknown[5] else low + (high - low) * share)
            at += size
        return values

    evaluations = 0
    start = time.perf_counter()
    settings = {"bounds": [0.0, 1.0], "verbose": -9, "seed": int(draw.integers(1, 2**31)), "maxfevals": options.evaluations}
    strategy = cma.CMAEvolutionStrategy(into(problem.start(draw)), 0.2, settings)
    best = math.inf
    while not strategy.stop() and best > options.rmse:
        asked, told = strategy.ask(), []
        for shares in asked:
            problem.put(out(shares))
            told.append(problem.rmse())
            evaluations += 1
            if told[-1] <= options.rmse:
                told.extend([told[-1]] * (len(asked) - len(told)))
                break
        best = min(best, min(told))
        strategy.tell(asked, told)
    return {"seconds": time.perf_counter() - start, "rmse": best, "steps": evaluations}


def best_rate(problem, options):
    """The first learning rate of Adam that serves a material best on starts that do not count: by successes, then by how close."""

    def merit(rate):
        tried = argparse.Namespace(**(vars(options) | {"rate": rate}))
        runs = [adam(problem, numpy.random.default_rng([options.seed + 1, k]), tried) for k in range(options.tune)]
        rmse = [max(run["rmse"], options.rmse) for run in runs]
        return sum(math.log(value) for value in rmse), sum(run["seconds"] for run in runs)

    return min(RATES, key=merit)


def figures(values):
    values = numpy.array(values)
    return {
        "min": float(values.min()), "median": float(numpy.median(values)), "mean": float(values.mean()),
        "p95": float(numpy.quantile(values, 0.95)), "max": float(values.max()),
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--starts", type=int, default=50)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rmse", type=float, default=1e-4)
    parser.add_argument("--rate", type=float, default=0.05, help="the first learning rate of Adam")
    parser.add_argument("--tune", type=int, default=0, help="starts that choose the rate for each material instead")
    parser.add_argument("--steps", type=int, default=400, help="of Adam at most")
    parser.add_argument("--evaluations", type=int, default=2000, help="of the evolution strategy at most")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--method", choices=["adam", "cma"], action="append")
    parser.add_argument("--material", choices=MATERIALS, action="append")
    options = parser.parse_args()
    drjit.set_thread_count(options.threads)
    rows = []
    for name in options.material or MATERIALS:
        problem = Problem(name, options.size)
        for method in options.method or ["adam", "cma"]:
            work = {"adam": adam, "cma": evolution}[method]
            # Compiles the kernels.
            warm = argparse.Namespace(**(vars(options) | {"steps": 3, "evaluations": 30}))
            work(problem, numpy.random.default_rng(0), warm)
            own = options
            if method == "adam" and options.tune > 0:
                own = argparse.Namespace(**(vars(options) | {"rate": best_rate(problem, options)}))
            runs = [work(problem, numpy.random.default_rng([options.seed, k]), own) for k in range(options.starts)]
            rows.append({
                "material": name, "method": method, "rate": own.rate if method == "adam" else None,
                "unknowns": sum(problem.sizes()), "starts": options.starts,
                "successes": sum(run["rmse"] <= options.rmse for run in runs),
                "seconds": figures([run["seconds"] for run in runs]),
                "rmse": figures([run["rmse"] for run in runs]),
                "steps": figures([run["steps"] for run in runs]),
            })
            row = rows[-1]
            print(
                f"{name}, {method}: {row['successes']} of {row['starts']}, {row['seconds']['median']:.2f} s in the median, "
                f"RMSE {row['rmse']['median']:.1e}, {row['steps']['median']:.0f} steps",
                file=sys.stderr, flush=True,
            )
    print(json.dumps({
        "size_px": options.size, "rmse": options.rmse, "threads": options.threads,
        "steps_most": options.steps, "evaluations_most": options.evaluations, "rows": rows,
    }))


if __name__ == "__main__":
    main()
