/** Genome inspector: lines of the text, geometry of the polar plot, locks, quantities in words. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { channelsKeeping, constantsKept, listingOf, readConstants } from "../lineage/listing.js";
import {
  anyLocked, locksInWords, onlyTwinsInWords, toggled, twinsInWords,
} from "../lineage/locks.js";
import { axisFor, pathOf, peakOf, pointAt, radiusOf, valuesOf } from "../lineage/polar.js";
import { noLocks } from "../lineage/store.js";
import { albedoInWords, amount, decade, reflectsInWords } from "../page/format.js";

const SOURCE = `brood 1
.dialect paper smooth registers 7
.limit on
.const C0 1 2 3 4
.const C1 -0.5 0 0 1e-7
.const C12 1 1 1 1
SUB R3.zw, R1.xxzz, -C12.zyyw
COS R1.yzw, -C1.y
ADD R6.x, C1.yxwz, -C1.zxzw
`;
const FOUND = {
  source: SOURCE,
  counts: /** @type {any} */ ({ instructions: 3 }),
  live: [true, false, true],
  channels: ["gb", "", "g"],
};
/** @param {Partial<import("../model.js").Locks>} some @returns {import("../model.js").Locks} */
const locks = (some) => ({ ...noLocks(), ...some });

test("listingOf splits a genome's text into head, constants and instructions", () => {
  const listing = listingOf(FOUND);
  assert.deepEqual(listing.head, ["brood 1", ".dialect paper smooth registers 7", ".limit on"]);
  assert.deepEqual(
    listing.constants.map((one) => one.index),
    [0, 1, 12],
  );
  assert.equal(listing.constants[1].text, "-0.5 0 0 1e-7");
  assert.deepEqual(listing.instructions[2], {
    index: 2,
    text: "ADD R6.x, C1.yxwz, -C1.zxzw",
    live: true,
    channels: "g",
    constants: [1],
  });
  assert.deepEqual([...readConstants(listing)], [12, 1]);
});

test("listingOf lists models between constants and instructions", () => {
  const source = SOURCE.replace("SUB", ".model lambert\nalbedo 0.3 0.2 0.1\nSUB");
  const listing = listingOf({ ...FOUND, source });
  assert.deepEqual(listing.head, ["brood 1", ".dialect paper smooth registers 7", ".limit on"]);
  assert.deepEqual(listing.layers, [
    { model: "lambert", parameters: [{ name: "albedo", value: [0.3, 0.2, 0.1] }] },
  ]);
  assert.equal(listing.instructions[0].text, "SUB R3.zw, R1.xxzz, -C12.zyyw");
});

test("listingOf finds no instructions in a genome without any", () => {
  const listing = listingOf({
    ...FOUND,
    source: "brood 1\n.const C0 1 2 3 4\n",
    counts: /** @type {any} */ ({ instructions: 0 }),
    live: [],
    channels: [],
  });
  assert.deepEqual(
    [listing.head.length, listing.constants.length, listing.instructions.length],
    [1, 1, 0],
  );
});

test("a locked channel keeps the instructions and constants that it depends on", () => {
  const listing = listingOf(FOUND);
  const blue = locks({ channels: ["b"] });
  assert.deepEqual(
    listing.instructions.map((one) => channelsKeeping(one, blue)),
    [["b"], [], []],
  );
  assert.deepEqual([...constantsKept(listing, blue).keys()], [12]);
});

test("locks are described in words", () => {
  assert.equal(
    locksInWords(locks({ instructions: [1, 2], constants: [7], channels: ["b", "r"] })),
    "2 instructions, 1 constant, red, blue",
  );
  assert.equal(
    locksInWords(
      locks({
        layers: [0],
        parameters: [
          { layer: 1, name: "k" },
          { layer: 1, name: "eta" },
        ],
      }),
    ),
    "1 model, 2 parameters",
  );
  assert.equal(locksInWords(locks({})), "");
  assert.deepEqual([anyLocked(locks({})), anyLocked(locks({ channels: ["g"] }))], [false, true]);
  const by = (/** @type {number} */ a, /** @type {number} */ b) => a - b;
  assert.deepEqual(toggled([2, 11], 9, by), [2, 9, 11]);
  assert.deepEqual(toggled([2, 9, 11], 9, by), [2, 11]);
});

test("twins are explained by locks only when something is locked", () => {
  const individuals = [{ twin: true }, { twin: true }, {}];
  const brood = (/** @type {any} */ kept) => /** @type {any} */ ({ individuals, locks: kept });
  assert.match(twinsInWords(brood(locks({ channels: ["r"] }))), /^2 identical children/);
  assert.equal(twinsInWords(brood(undefined)), "");
  assert.equal(twinsInWords({ ...brood(locks({ channels: ["r"] })), individuals: [{}] }), "");
});

/** @type {import("../model.js").Plane} */
const PLANE = {
  azimuth_deg: 0,
  theta_o_deg: [-60, 0, 60],
  curves: [
    {
      theta_i_deg: 30,
      f: [
        [1, 2, null],
        [0, 1, 4],
        [0, 0, 1],
      ],
    },
  ],
};

test("values are luminance or one channel, with or without the cosine", () => {
  const [curve] = PLANE.curves;
  const luminance = valuesOf(PLANE, curve, { color: "luminance", cosine: false });
  assert.ok(Math.abs(luminance[1] - (0.2126 * 2 + 0.7152)) < 1e-12);
  assert.ok(Number.isNaN(luminance[2]), "a channel is missing");
  const green = valuesOf(PLANE, curve, { color: "g", cosine: true });
  assert.equal(green[1], 1);
  assert.ok(
    Math.abs(green[2] - 2) < 1e-12,
    "a missing channel that is not asked for does not matter",
  );
});

test("a linear axis ends at a round value", () => {
  assert.deepEqual(axisFor([0, 0.33, Number.NaN], false), {
    log: false,
    low: 0,
    high: 0.4,
    rings: [0.1, 0.2, 0.3, 0.4],
  });
  assert.deepEqual(axisFor([7], false).rings, [2, 4, 6, 8]);
  assert.deepEqual(axisFor([1], false).rings, [0.5, 1]);
  assert.deepEqual(axisFor([0, Number.NaN], false).rings, [1]);
});

test("a logarithmic axis has one to five whole decades", () => {
  assert.deepEqual(axisFor([0.02, 0.5], true).rings, [0.1, 1]);
  assert.deepEqual(axisFor([1], true).rings, [1]);
  assert.equal(axisFor([1e-12, 300], true).rings.length, 5);
  assert.equal(axisFor([1e-12, 300], true).high, 1000);
});

test("radiusOf goes from 0 at the middle to 1 at the rim", () => {
  const linear = axisFor([0.33], false);
  assert.equal(radiusOf(linear, 0), 0);
  assert.equal(radiusOf(linear, 0.2), 0.5);
  const log = axisFor([0.01, 1], true);
  assert.ok(Math.abs(radiusOf(log, 0.1) - 0.5) < 1e-12);
  assert.equal(radiusOf(log, 0), 0);
});

test("the normal points up, and the light's side is left", () => {
  const [x, y] = pointAt(0, 2);
  assert.deepEqual([x, y], [0, -2]);
  assert.ok(pointAt(-80, 1)[0] < -0.9);
});

test("a path is interrupted where a value is missing", () => {
  const axis = axisFor([1], false);
  assert.equal(pathOf([-90, 0, 90], [1, Number.NaN, 1], axis, 10), "M-10.00 -0.00M10.00 -0.00");
  assert.equal(pathOf([0, 90], [1, 0.5], axis, 10), "M0.00 -10.00L5.00 -0.00");
  assert.deepEqual(peakOf([-60, 0, 60], [1, Number.NaN, 3]), { theta_deg: 60, value: 3 });
  assert.equal(peakOf([0], [Number.NaN]), null);
});

test("quantities have few digits", () => {
  assert.deepEqual(
    [0, 0.98029, 4768.97, 1e-3, 1.7175e-5, 1e-5, 123456, null].map((value) => amount(value)),
    ["0", "0.98", "4770", "0.001", "1.72 × 10⁻⁵", "10⁻⁵", "1.23 × 10⁵", "not finite"],
  );
});

test("a decade is written as a power of ten", () => {
  assert.deepEqual([1e-4, 0.001, 0.1, 1, 10, 1000].map(decade), [
    "10⁻⁴",
    "10⁻³",
    "10⁻¹",
    "1",
    "10",
    "10³",
  ]);
});

test("the largest albedo is described with its error bound and the energy limit", () => {
  const energy = {
    max_albedo: 0.99996,
    unlimited_albedo: 4768.97,
    error_bound: 0.0201,
    divisor: 4864.8,
    theta_deg: 8.3,
    limited: true,
  };
  assert.equal(reflectsInWords(energy), "1.0 (limited)");
  assert.equal(
    albedoInWords(energy),
    "Largest directional albedo: in light at 8° from the normal, known to 2 %; 4800 without the limit.",
  );
  const free = { ...energy, max_albedo: 12.34, limited: false };
  assert.equal(reflectsInWords(free), "12");
  assert.match(albedoInWords(free), /more light than it receives/);
});

test("a brood of identical children is known before it is bred", () => {
  const free = { mutation: 0.3, recombination: 0.5, hasMate: false, locks: noLocks(), genome: null };
  assert.equal(onlyTwinsInWords(free), "");
  assert.match(onlyTwinsInWords({ ...free, mutation: 0 }), /^Mutation 0 gives 20 identical/);
  assert.equal(onlyTwinsInWords({ ...free, mutation: 0, hasMate: true }), "");
  const recoloured = { ...free, mutation: 0, recoloured: true };
  assert.equal(onlyTwinsInWords(recoloured), "");
  const kept = { ...noLocks(), effect_parameters: [{ effect: "light", name: "palette" }] };
  assert.match(onlyTwinsInWords({ ...recoloured, locks: kept }), /^Mutation 0 gives 20 identical/);
  const same = { ...free, mutation: 0, recombination: 0, hasMate: true };
  assert.match(onlyTwinsInWords(same), /^Mutation and recombination 0/);
  const channels = locks({ channels: ["r", "g", "b"] });
  assert.match(onlyTwinsInWords({ ...free, locks: channels }), /^All channels are locked/);
  const metal = { model: "ward", parameters: [{ name: "alpha_x", value: [1] }] };
  const genome = { instructions: 0, machine: "", constants: [], layers: [metal, metal], effects: [] };
  const half = locks({ layers: [0] });
  assert.equal(onlyTwinsInWords({ ...free, locks: half, genome }), "");
  const whole = locks({ layers: [0], parameters: [{ layer: 1, name: "alpha_x" }] });
  assert.match(onlyTwinsInWords({ ...free, locks: whole, genome }), /^Everything is locked/);
  const program = { ...genome, instructions: 2, constants: [4], layers: [] };
  const steps = locks({ instructions: [0, 1] });
  assert.equal(onlyTwinsInWords({ ...free, locks: steps, genome: program }), "", "a constant is free");
  const all = locks({ instructions: [0, 1], constants: [4] });
  assert.match(onlyTwinsInWords({ ...free, locks: all, genome: program }), /^Everything is locked/);
});
