/** Tests of steering: words that fit together and reasons against them. */
import assert from "node:assert/strict";
import { test } from "node:test";

import { STEERS, noSteerInWords, steerInWords, withSteer } from "../lineage/steer.js";

test("a word that is turned on removes those that it contradicts", () => {
  assert.deepEqual(withSteer([], "warmer", true), ["warmer"]);
  assert.deepEqual(withSteer(["warmer", "glossier"], "cooler", true), ["glossier", "cooler"]);
  assert.deepEqual(withSteer(["warmer", "more-pattern", "rougher"], "only-gloss", true), [
    "rougher",
    "only-gloss",
  ]);
  assert.deepEqual(withSteer(["warmer", "rougher"], "warmer", false), ["rougher"]);
  assert.deepEqual(withSteer(["warmer"], "warmer", true), ["warmer"]);
});

test("pattern is refused where children cannot have one", () => {
  const wild = { homogeneous: false, genome: null };
  for (const { word } of STEERS) assert.equal(noSteerInWords(word, wild), "");
  assert.match(noSteerInWords("more-pattern", { ...wild, homogeneous: true }), /^Homogeneous/);
  const model = { instructions: 0, machine: "", layers: [], effects: [] };
  assert.match(noSteerInWords("less-pattern", { ...wild, genome: model }), /^Models/);
  assert.equal(noSteerInWords("warmer", { homogeneous: true, genome: model }), "");
  const painted = { ...model, effects: [{ effect: "light", parameters: [] }] };
  assert.match(noSteerInWords("warmer", { ...wild, genome: painted }), /^Painted/);
});

test("steers have names for people", () => {
  assert.equal(steerInWords(["keep-colour", "rougher"]), "keep colour, rougher");
  assert.equal(steerInWords(undefined), "");
});
