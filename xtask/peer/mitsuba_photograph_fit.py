"""Materials fitted to photographs by Mitsuba's derivatives with Adam, and pictures of the results in unseen scenes.

Reads photographs that mitsuba_photographs.py made. A fit reads target.json, as `brood fit` does: pictures, stated scenes and the
environment's image. It optimises the material and nothing of the scene: samples and their light are traced once, and the material
alone is evaluated in each step. `principled` knows nothing of the material; `generating`
knows its plugin and all that is not a number of PROPERTIES. All starts share one budget of wall time in ROUNDS; each
round continues with the best starts of the round before.

The clock starts when scene and pictures are loaded, and stops when the material is chosen. It includes tracing and loading of
kernels. `warm` makes some steps of each kind of fit, so that their kernels are in the cache on disk; the measured time includes
compiling those that are not. Writes one JSON object to stdout.
"""

import argparse
import json
import math
import pathlib
import sys
import time

import drjit
import mitsuba
import numpy

mitsuba.set_variant("llvm_ad_rgb")

from mitsuba_against import read, scene_of  # noqa: E402, BSDF classes exist only once a variant is set
from mitsuba_photographs import display, render, write  # noqa: E402

STARTS = 10
# For each round: the number of starts, its share of the budget, the square root of samples per pixel, and Adam's first and
# last rate. Faster ones end at the borders of the domain more often.
ROUNDS = [(STARTS, 0.6, 1, 0.04, 0.01), (3, 0.2, 2, 0.03, 0.005), (1, 0.2, 3, 0.01, 0.0005)]
# The same root, of the pictures that materials are compared by, and that show which pixels are at an edge.
CHECK_SIDE = 4
EDGE_SIDE = 4
# Number of checks of the material in the last round.
CHECKS = 10
# An environment is sampled in directions that stay: this number of each of PROPOSALS and of the environment's own, of pixels that
# are squares of this size.
DIRECTIONS = 8
ENVIRONMENT_PX = 3
PROPOSALS = [{"type": "roughconductor", "distribution": "ggx", "alpha": alpha} for alpha in (0.06, 0.25)] + [{"type": "diffuse"}]
# Weights of squared differences are those of noise of light: one over the value, to which this share of the mean is added, to twice
# this power.
POWER = 0.5
DARK_SHARE = 0.05
# Largest ratio to the least error at which a fit counts as finished.
NEAR = 1.05

# Properties: the least and the largest value, those of starts, and whether ratios matter.
UNIT = (0.0, 1.0, 0.05, 0.95, False)
FAINT = (0.0, 1.0, 0.02, 0.3, False)
PROPERTIES = {
    "roughconductor": {
        "alpha": (1e-3, 1.0, 0.03, 1.0, True), "eta": (0.02, 10.0, 0.1, 5.0, True), "k": (1e-3, 20.0, 0.3, 9.0, True),
    },
    "roughplastic": {"alpha": (1e-3, 1.0, 0.03, 1.0, True), "diffuse_reflectance": UNIT},
    "principled": {
        "base_color": UNIT, "roughness": (0.03, 1.0, 0.1, 0.95, False), "metallic": UNIT, "specular": UNIT,
        "eta": (1.01, 3.0, 1.3, 1.8, True), "spec_tint": FAINT, "sheen": FAINT, "sheen_tint": UNIT, "clearcoat": UNIT,
        "clearcoat_gloss": UNIT,
    },
}
KINDS = {"metallic": [(0.02, 0.2), (0.8, 0.98)], "clearcoat": [(0.5, 0.95), (0.02, 0.2)]}
# These take no texture.
PLAIN = [("principled", "eta"), ("principled", "specular"), ("roughplastic", "alpha")]
COLOURS = ["base_color", "diffuse_reflectance", "eta", "k"]
# A principled material of which nothing is known.
PRINCIPLED = {"type": "principled", "base_color": [0.5] * 3} | {
    name: 0.5 for name in ("roughness", "metallic", "spec_tint", "sheen", "sheen_tint", "clearcoat", "clearcoat_gloss")
} | {"eta": 1.5}


class Unknown:
    """A property of the material, as a number or a colour."""

    def __init__(self, plugin, name):
        self.name = name
        self.low, self.high, *self.start, self.ratios = PROPERTIES[plugin][name]
        self.is_colour = name in COLOURS and not (plugin, name) == ("principled", "eta")
        self.is_plain = (plugin, name) in PLAIN
        self.is_table = (plugin, name) == ("roughplastic", "alpha")
        self.key = f"shape.bsdf.{name}" if self.is_plain else f"shape.bsdf.{name}.data"

    def draw(self, draw, number):
        low, high = self.into(self.start)
        if self.name in KINDS:
            # Metals or not, with a coat or almost without: starts between end in minima that are neither.
            low, high = KINDS[self.name][number // (1 if self.name == "metallic" else 2) % 2]
        return self.kind(draw.uniform(low, high, 3 if self.is_colour else 1))

    def into(self, value):
        return numpy.log(value) if self.ratios else numpy.asarray(value)

    def kind(self, values):
        values = [float(value) for value in values]
        return mitsuba.Color3f(*values) if self.is_colour else mitsuba.Float(*values)

    def clamped(self, value):
        low, high = (float(x) for x in self.into([self.low, self.high]))
        return drjit.clip(value, low, high)

    def out(self, value):
        return drjit.exp(value) if self.ratios else value

    def parameter(self, value, lanes):
        """As the scene takes it."""
        value = self.out(value)
        if self.is_table or (self.is_plain and lanes == 1):
            return value
        if self.is_plain:
            return drjit.gather(mitsuba.Float, value, drjit.zeros(mitsuba.UInt, lanes))
        texels = [channel for _ in range(4) for channel in (value if self.is_colour else [value])]
        return mitsuba.TensorXf(drjit.concat(texels), (2, 2, len(texels) // 4))

    def number(self, value):
        values = numpy.array(self.out(value), dtype=float).ravel().tolist()
        return values if self.is_colour else values[0]


def texture(value):
    """Of equal texels: derivatives of all of them are added up by one kernel, those of numbers by one for each use."""
    texel = numpy.full((2, 2, 3 if isinstance(value, list) else 1), value, dtype=numpy.float32)
    return {"type": "bitmap", "bitmap": mitsuba.Bitmap(texel), "raw": True, "filter_type": "nearest"}


class View:
    """A picture with its stated scene, and the error of renderings. Pixels count that show nothing but the lit object."""

    def __init__(self, folder, view, bsdf):
        scene = view["scene"]
        lights = [light | ({"image": str(folder / light["image"])} if "image" in light else {}) for light in scene["lights"]]
        film = scene.get("film")
        self.is_coded = film is not None
        if film:
            self.reference = numpy.array(mitsuba.Bitmap(str(folder / view["picture"]))).astype(numpy.float64)[:, :, :3] / 255
        else:
            self.reference = read(folder / view["picture"])
        self.scale = drjit.opaque(mitsuba.Float, 2.0 ** film["exposure"] if film else 1.0)
        # Samples stay, and only the material is evaluated again.
        self.is_point = lights[0]["kind"] == "point"
        coarse = 1 if self.is_point else ENVIRONMENT_PX
        self.size = self.reference.shape[0] // coarse
        self.matched = self.reference.reshape(self.size, coarse, self.size, coarse, 3).mean(axis=(1, 3))
        self.scene = scene_of({
            "scene": scene | {"lights": lights}, "mesh": view.get("mesh"), "bsdf": bsdf, "others": [],
            "size_px": self.size, "samples": 1, "sampler": "independent",
        })
        self.parameters = mitsuba.traverse(self.scene)
        self.hits = {}

    def prepare(self):
        lit = self.trace(drjit.arange(mitsuba.UInt, self.size**2), EDGE_SIDE, 1)[0]
        count = drjit.block_sum(drjit.select(lit, mitsuba.UInt(1), mitsuba.UInt(0)), EDGE_SIDE**2)
        self.used = drjit.compress(count == EDGE_SIDE**2)
        flat = self.matched.reshape(-1, 3)[self.used.numpy()]
        self.wanted = mitsuba.Color3f(flat.T.astype(numpy.float32))
        mean = flat.mean()
        weight = 1 / (flat.mean(axis=1) / mean + DARK_SHARE) ** POWER / mean
        self.weight = mitsuba.Float(weight.astype(numpy.float32))

    def trace(self, pixels, side, directions):
        """Samples of pixels, side x side of each and as many directions of each: whether they are lit, and all that the material is
        evaluated with."""
        count = side * side * directions
        index = drjit.arange(mitsuba.UInt, drjit.width(pixels) * count)
        pixel, part = drjit.gather(mitsuba.UInt, pixels, index // count), index % count
        draw = mitsuba.PCG32(drjit.width(index), initstate=side)
        x = mitsuba.Float(pixel % self.size) + (mitsuba.Float(part % side) + draw.next_float32()) / side
        y = mitsuba.Float(pixel // self.size) + (mitsuba.Float(part // side % side) + draw.next_float32()) / side
        place = mitsuba.Point2f(x, y) / self.size
        ray, _ = self.scene.sensors()[0].sample_ray(0.0, 0.5, place, mitsuba.Point2f(0.5))
        hit = self.scene.ray_intersect(ray)
        lit = hit.is_valid() & (hit.wi.z > 0)
        if directions == 1 and not self.is_point:
            return lit, None
        if self.is_point:
            to_light, light = self.scene.emitters()[0].sample_direction(hit, mitsuba.Point2f(0.5))
            wo, shadow = hit.to_local(to_light.d), hit.spawn_ray_to(to_light.p)
        else:
            wo, light = self.surrounded(hit, part // (side * side) % (len(PROPOSALS) + 1), draw)
            shadow = hit.spawn_ray(hit.to_world(wo))
        lit &= (wo.z > 0) & ~self.scene.ray_test(shadow)
        light = drjit.select(lit, light, 0)
        drjit.eval(lit, hit, wo, light)
        return lit, (hit, wo, light)

    def surrounded(self, hit, kind, draw):
        """A direction by one of the proposals, and the environment's light from it over the density of all of them."""
        context, light = mitsuba.BSDFContext(), self.scene.environment()
        place = mitsuba.Point2f(draw.next_float32(), draw.next_float32())
        wo = hit.to_local(light.sample_direction(hit, place)[0].d)
        bsdfs = [mitsuba.load_dict(proposal) for proposal in PROPOSALS]
        for number, bsdf in enumerate(bsdfs):
            sample, _ = bsdf.sample(context, hit, draw.next_float32(), place)
            wo = drjit.select(kind == number + 1, sample.wo, wo)
        seen = drjit.zeros(mitsuba.DirectionSample3f, drjit.width(wo))
        seen.d = hit.to_world(wo)
        away = drjit.zeros(mitsuba.SurfaceInteraction3f, drjit.width(wo))
        away.wi = -seen.d
        density = light.pdf_direction(hit, seen)
        for bsdf in bsdfs:
            density += bsdf.pdf(context, hit, wo)
        density /= len(bsdfs) + 1
        return wo, drjit.select(density > 0, light.eval(away) / density, 0)

    def picture(self, side):
        directions = 1 if self.is_point else DIRECTIONS * (len(PROPOSALS) + 1)
        if side not in self.hits:
            self.hits[side] = self.trace(self.used, side, directions)[1]
        hit, wo, light = self.hits[side]
        value = self.scene.shapes()[0].bsdf().eval(mitsuba.BSDFContext(), hit, wo) * light
        # All channels by one kernel.
        drjit.eval(value)
        count = side * side * directions
        return mitsuba.Color3f(*[drjit.block_sum(channel, count) for channel in value]) / count

    def lanes(self, side):
        """Number of evaluations of the material."""
        directions = 1 if self.is_point else DIRECTIONS * (len(PROPOSALS) + 1)
        return side * side * drjit.width(self.used) * directions

    def put(self, values):
        for key, value in values.items():
            self.parameters[key] = value
        self.parameters.update()

    def loss(self, values, side):
        self.put(values)
        picture = self.picture(side)
        if self.is_coded:
            off = self.shown(picture) - self.wanted
            # Clipped pixels bound the light from one side.
            off = drjit.select(self.wanted >= 1, drjit.minimum(off, 0), off)
            off = drjit.select(self.wanted <= 0, drjit.maximum(off, 0), off)
        else:
            off = (picture - self.wanted) * self.weight
        return drjit.mean(drjit.squared_norm(off))

    def shown(self, picture):
        """As displayed, without an upper limit."""
        linear = picture * self.scale
        bright = 1.055 * drjit.power(drjit.maximum(linear, 0.0031308), 1 / 2.4) - 0.055
        return drjit.select(linear <= 0.0031308, 12.92 * linear, bright)


class Fit:
    """A material with the pictures to match."""

    def __init__(self, folder, bsdf, names, pictures=1):
        views = json.loads((folder / "target.json").read_text())["views"][:pictures]
        textured = bsdf | {name: texture(bsdf[name]) for name in names if (bsdf["type"], name) not in PLAIN}
        self.views = [View(folder, view, textured) for view in views]
        self.bsdf = bsdf
        self.unknowns = [Unknown(bsdf["type"], name) for name in names]
        self.steps = 0

    def start(self, draw, number):
        return {unknown.key: unknown.draw(draw, number) for unknown in self.unknowns}

    def out(self, values, lanes):
        return {unknown.key: unknown.parameter(values[unknown.key], lanes) for unknown in self.unknowns}

    def error(self, values):
        losses = [float(view.loss(self.out(values, view.lanes(CHECK_SIDE)), CHECK_SIDE)[0]) for view in self.views]
        mean = sum(losses) / len(losses)
        return mean if math.isfinite(mean) else math.inf

    def descend(self, values, side, rates, until, look=lambda share, values: None):
        """Adam from one start until a time; rates fall by equal ratios."""
        begun = time.perf_counter()
        adam = mitsuba.ad.Adam(lr=rates[0])
        for unknown in self.unknowns:
            adam[unknown.key] = values[unknown.key]
        while (now := time.perf_counter()) < until:
            share = (now - begun) / (until - begun)
            adam.set_learning_rate(rates[0] * (rates[1] / rates[0]) ** share)
            view = self.views[self.steps % len(self.views)]
            drjit.backward(view.loss(self.out(adam, view.lanes(side)), side))
            for unknown in self.unknowns:
                slope = drjit.grad(adam[unknown.key])
                # A pixel without a finite derivative leaves the material as it is.
                drjit.set_grad(adam[unknown.key], drjit.select(drjit.isfinite(slope), slope, 0))
            adam.step()
            for unknown in self.unknowns:
                adam[unknown.key] = unknown.clamped(adam[unknown.key])
            drjit.eval(*[adam[unknown.key] for unknown in self.unknowns])
            # Steps are only queued otherwise, and the clock would be wrong.
            drjit.sync_thread()
            self.steps += 1
            look(share, self.detached(adam))
        return self.detached(adam)

    def detached(self, values):
        return {unknown.key: drjit.detach(values[unknown.key]) for unknown in self.unknowns}

    def run(self, seconds, seed):
        """The best material, its error, and when it was found."""
        begun = time.perf_counter()
        for view in self.views:
            view.prepare()
        draw = numpy.random.default_rng(seed)
        starts = [(math.inf, self.start(draw, number)) for number in range(STARTS)]
        history, spent, by_round = [], 0.0, []

        def check(values):
            error = self.error(values)
            history.append((time.perf_counter() - begun, error))
            return error, values

        for number, (count, share, side, first, last) in enumerate(ROUNDS):
            before, spent = spent, spent + share
            is_last = number + 1 == len(ROUNDS)
            best = starts[:count]
            found = [check(best[0][1])] if is_last else []

            def look(share, values):
                if is_last and share * CHECKS >= len(found):
                    found.append(check(values))

            for index, (_, values) in enumerate(best):
                until = begun + seconds * (before + (spent - before) * (index + 1) / len(best))
                values = self.descend(values, side, (first, last), until, look)
                found.append(check(values))
            starts = sorted(found, key=lambda each: each[0])
            by_round.append([error for error, _ in starts])
        for view in self.views:
            # Mitsuba's renderings trace all materials that there are, and take no copies of numbers.
            view.put(self.out(starts[0][1], 1))
        taken = time.perf_counter() - begun
        error, values = starts[0]
        near = next(seconds for seconds, each in history if each <= NEAR * error)
        bsdf = self.bsdf | {unknown.name: unknown.number(values[unknown.key]) for unknown in self.unknowns}
        return bsdf, {
            "seconds": taken, "seconds_to_best": near, "steps": self.steps, "loss": error, "losses_by_round": by_round,
            "bsdf": bsdf,
        }


def unknown_material(job, model):
    """The material without its values, and the names of those; `None` if there is no such model."""
    if model == "principled":
        return PRINCIPLED, [name for name in PRINCIPLED if name != "type"]
    bsdf = job["bsdf"]
    if bsdf["type"] not in PROPERTIES:
        return None
    names = [name for name in PROPERTIES[bsdf["type"]] if name in bsdf]
    return bsdf | {name: [0.5] * 3 if isinstance(bsdf[name], list) else 0.5 for name in names}, names


def fit(job, options):
    folder, out = pathlib.Path(job["folder"]), pathlib.Path(options.output)
    out.mkdir(parents=True, exist_ok=True)
    found = unknown_material(job, options.model)
    if found is None:
        return {"model": None}
    problem = Fit(folder, *found, options.pictures)
    bsdf, report = problem.run(options.seconds, options.seed)
    (out / "report.json").write_text(json.dumps(report))
    fitted = job | {"bsdf": bsdf}
    for index, test in enumerate(job["tests"]):
        picture = render(fitted | {"mesh": test["mesh"]}, test["scene"], job["test_samples"], 201 + index)
        write(out / f"{test['name']}.exr", picture.astype(numpy.float32))
    write_sheet(out / "sheet.png", problem.views[0], fitted, job)
    return report


def write_sheet(path, view, fitted, job):
    """The first picture, and the material in its stated scene, for looking at."""
    target = json.loads((pathlib.Path(job["folder"]) / "target.json").read_text())
    own = render(fitted, target["views"][0]["scene"], job["test_samples"], 301)
    if view.is_coded:
        sheet = numpy.concatenate([view.reference, display(own * float(view.scale[0]))], axis=1)
    else:
        sheet = display(numpy.concatenate([view.reference, own], axis=1) / numpy.quantile(view.reference, 0.995))
    write(path, (sheet.clip(0, 1) * 255 + 0.5).astype(numpy.uint8))


def warm(jobs, options):
    """Compiles the kernels of one fit of each kind."""
    kinds = {}
    for job in jobs:
        view = json.loads((pathlib.Path(job["folder"]) / "target.json").read_text())["views"][0]
        scene = view["scene"]
        for model in options.models.split(","):
            found = unknown_material(job, model)
            if found is None:
                continue
            fixed = {name: value for name, value in found[0].items() if name not in found[1]}
            kind = json.dumps([scene["lights"][0]["kind"], "film" in scene, view.get("mesh"), found[1], fixed], sort_keys=True)
            kinds.setdefault(kind, (job, found))
    for job, found in kinds.values():
        problem = Fit(pathlib.Path(job["folder"]), *found)
        for view in problem.views:
            view.prepare()
        values = problem.start(numpy.random.default_rng(0), 0)
        for _, _, side, first, last in ROUNDS:
            problem.descend(values, side, (first, last), time.perf_counter() + 1.0)
            problem.error(values)
    return {"kinds": len(kinds)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("task", choices=["warm", "fit"])
    parser.add_argument("list", help="the JSON file that mitsuba_photographs.py made pictures of")
    parser.add_argument("--index", type=int, default=0, help="of the photograph in the list")
    parser.add_argument("--model", choices=["principled", "generating"], default="principled")
    parser.add_argument("--models", default="principled,generating", help="those to compile")
    parser.add_argument("--pictures", type=int, default=1, help="the number of pictures of the photograph to fit")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", help="a folder for report and pictures")
    options = parser.parse_args()
    drjit.set_thread_count(options.threads)
    jobs = json.loads(pathlib.Path(options.list).read_text())
    if options.task == "warm":
        print(json.dumps(warm(jobs, options)))
    else:
        print(json.dumps(fit(jobs[options.index], options)))


if __name__ == "__main__":
    main()
