/** Models of genomes: parsing, words, locks; and the light of the server's pictures. */
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  codesOf, colorOf, genomeIn, isPainted, locksFor, makeupInWords, modelsInWords, parameterKeptBy, plainName,
} from "../lineage/layers.js";
import { fits } from "../lineage/presets.js";
import { noLocks } from "../lineage/store.js";
import { nextStill } from "../live/stills.js";

const TEXT = `brood 1
.dialect paper smooth registers 7
.limit on
.matrix 0.72 0.25 0.03 0.07 0.9 0.03 0.07 0.25 0.68
.const C0 1 2 3 4
.model lambert
albedo 0.3 0.13 0.05
.model cook-torrance
f0 1 0.7 0.3
roughness 1e-4
distribution ggx
MUL R2.x, R0.x, R0.x
EX2 R3, R2.x
`;
const GENOME = genomeIn(TEXT);
/** @param {Partial<import("../model.js").Locks>} some @returns {import("../model.js").Locks} */
const locks = (some) => ({ ...noLocks(), ...some });

test("models are read from a genome's text with numbers, colours and words", () => {
  assert.deepEqual(GENOME, {
    instructions: 2,
    machine: "paper smooth registers 7",
    constants: [],
    layers: [
      { model: "lambert", parameters: [{ name: "albedo", value: [0.3, 0.13, 0.05] }] },
      {
        model: "cook-torrance",
        parameters: [
          { name: "f0", value: [1, 0.7, 0.3] },
          { name: "roughness", value: [1e-4] },
          { name: "distribution", value: "ggx" },
        ],
      },
    ],
    effects: [],
  });
  assert.deepEqual(genomeIn("brood 1\nADD R0, R1, C12.x\n"), {
    instructions: 1,
    machine: "",
    constants: [12],
    layers: [],
    effects: [],
  });
});

const PAINTED = genomeIn(`brood 1
.effect light
palette #2b1e46 #f2a65a
edges 0.5
basis cubic
.effect silhouette
color #1a1020
MUL R0.x, R1.x, R2.x
`);

test("effects are read from a genome's text, with the colours of palettes", () => {
  const [light, silhouette] = PAINTED.effects;
  assert.deepEqual([light.effect, silhouette.effect], ["light", "silhouette"]);
  assert.deepEqual(light.parameters.map(codesOf), [["#2b1e46", "#f2a65a"], [], []]);
  assert.deepEqual(light.parameters[1], { name: "edges", value: [0.5] });
  assert.deepEqual(silhouette.parameters.map(codesOf), [["#1a1020"]]);
  assert.equal(PAINTED.instructions, 1);
  assert.ok(isPainted(PAINTED) && !isPainted(GENOME) && !isPainted(null));
});

test("locks of effects that a parent lacks are removed, and channels of painted ones", () => {
  const { kept, gone } = locksFor(
    locks({
      channels: ["r"],
      effects: ["light", "highlight"],
      effect_parameters: [
        { effect: "light", name: "palette" },
        { effect: "silhouette", name: "from" },
      ],
    }),
    PAINTED,
  );
  assert.deepEqual(kept.effects, ["light"]);
  assert.deepEqual(kept.effect_parameters, [{ effect: "light", name: "palette" }]);
  assert.deepEqual(gone, ["highlight", "from of silhouette", "channel r"]);
});

test("makeupInWords lists instructions and models that exist", () => {
  const of = (/** @type {number} */ live_instructions, /** @type {string[]|undefined} */ layers) =>
    makeupInWords(/** @type {any} */ ({ live_instructions, layers }));
  assert.equal(modelsInWords(["lambert", "cook-torrance", "lambert"]), "2 lambert, cook-torrance");
  assert.equal(
    of(12, ["lambert", "cook-torrance"]),
    "12 live instructions, lambert, cook-torrance",
  );
  assert.equal(of(0, ["lambert"]), "lambert");
  assert.equal(of(12, undefined), "12 live instructions");
  assert.equal(of(0, undefined), "0 live instructions");
  assert.equal(plainName("base_color"), "base color");
});

test("colorOf returns colours in gamut, and null for an index of refraction", () => {
  assert.equal(colorOf({ name: "f0", value: [1, 0.2158605, 0] }), "#ff8000");
  assert.equal(colorOf({ name: "eta", value: [0.1, 0.4, 0.9] }), null);
  assert.equal(colorOf({ name: "specular", value: [0.5] }), null);
  assert.equal(colorOf({ name: "rho_s", value: [0.5, 1.2, 0] }), null);
  assert.equal(colorOf({ name: "diffuse", value: "grey" }), null);
});

test("locksFor removes and names locks that a parent does not have", () => {
  const parameters = [
    { layer: 1, name: "roughness" },
    { layer: 0, name: "roughness" },
    { layer: 3, name: "base_color" },
  ];
  const { kept, gone } = locksFor(
    locks({ instructions: [1, 2], constants: [0], layers: [1, 2], channels: ["r"], parameters }),
    GENOME,
  );
  assert.deepEqual(
    kept,
    locks({
      instructions: [1],
      constants: [0],
      layers: [1],
      channels: ["r"],
      parameters: [parameters[0]],
    }),
  );
  assert.deepEqual(gone, [
    "instruction 2",
    "model 3",
    "roughness of model 1",
    "base color of model 4",
  ]);
  assert.deepEqual(locksFor(locks({ constants: [3] }), { ...GENOME, instructions: 0 }).gone, [
    "constant 3",
  ]);
  assert.deepEqual(locksFor(locks({ instructions: [0] }), GENOME).gone, []);
});

test("a parameter is kept by its model and by all its channels", () => {
  const [f0, roughness] = GENOME.layers[1].parameters;
  assert.equal(parameterKeptBy(locks({}), 1, roughness), "");
  assert.match(parameterKeptBy(locks({ layers: [1] }), 1, f0), /model/);
  assert.equal(parameterKeptBy(locks({ layers: [0] }), 1, f0), "");
  assert.match(parameterKeptBy(locks({ channels: ["g"] }), 1, roughness), /channels/);
  assert.equal(parameterKeptBy(locks({ channels: ["r", "g"] }), 1, f0), "");
  assert.match(parameterKeptBy(locks({ channels: ["r", "g", "b"] }), 1, f0), /channels/);
});

test("stills follow a moving light in steps, and are sharp where it rests", () => {
  assert.equal(nextStill(null, 0, true, 0), null);
  assert.equal(nextStill(null, 7, true, 0), null);
  assert.equal(nextStill(null, 356, true, 0), null);
  assert.equal(nextStill(null, 360, false, 0), null);
  const moving = nextStill(null, 8, true, 0);
  assert.deepEqual(moving, { degrees: 15, sharp: false });
  assert.equal(nextStill(moving, 17, true, 0), moving);
  const rested = nextStill(moving, 22.4, false, 0);
  assert.deepEqual(rested, { degrees: 22.4, sharp: false });
  const whole = nextStill(rested, 22.4, false, 0);
  assert.deepEqual(whole, { degrees: 22.4, sharp: true });
  assert.equal(nextStill(whole, 22.4, false, 0), whole);
  assert.deepEqual(nextStill(whole, 30, true, 0), { degrees: 30, sharp: false });
  assert.deepEqual(nextStill(null, 0, true, 40), { degrees: 0, sharp: false });
  assert.equal(nextStill(null, 400, false, 40), null);
});

test("models fit every lineage, programs only those of the same machine", () => {
  const paper = { opcodes: "paper", parametrisation: "smooth", registers: 7, length: 100 };
  const extended = { ...paper, opcodes: "extended", registers: 10 };
  const of = (/** @type {any} */ dialect) => /** @type {any} */ ({ dialect });
  const models = { ...paper, length: 0 };
  assert.deepEqual(
    [fits(of(paper), null, models), fits(of(paper), null, paper), fits(of(paper), null, extended)],
    [true, true, false],
  );
  assert.equal(fits(of({ ...paper, length: 40 }), null, paper), false);
  assert.deepEqual(
    [
      fits(of(models), { ...GENOME, instructions: 0 }, extended),
      fits(of(models), GENOME, extended),
      fits(of(models), GENOME, paper),
    ],
    [true, false, true],
  );
});
