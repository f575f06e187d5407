/** Colour and strength of a light, from controls to scene and back. */
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  hueOf, intensityOf, neutralIntensity, neutralStrength, settingOf, strengthField,
} from "../scene/light_color.js";

const extent = { centre: /** @type {[number, number, number]} */ ([0, 1, 0]), radius: 2 };

test("the default light is white at 0 EV, in both directions", () => {
  const plain = neutralIntensity({}, extent);
  assert.equal(plain, Math.PI * 64);
  assert.deepEqual(settingOf(null, plain), { color: "#ffffff", ev: 0 });
  assert.deepEqual(settingOf([plain, plain, plain], plain), { color: "#ffffff", ev: 0 });
  assert.equal(intensityOf({ color: "#ffffff", ev: 0 }, plain), null);
});

test("the neutral strength of a placed light depends on its distance", () => {
  assert.equal(neutralIntensity({ position: [0, 4, 4] }, extent), Math.PI * 25);
});

test("colours with a full channel and stops survive a round trip", () => {
  for (const color of ["#ff8000", "#01ff7f", "#0000ff", "#ffffff", "#fffefd"]) {
    for (let ev = -4; ev <= 4; ev += 0.25) {
      assert.deepEqual(settingOf(intensityOf({ color, ev }, 201), 201), { color, ev });
    }
  }
});

test("a dark colour has the hue of its bright one, and black counts as white", () => {
  const [r, g, b] = hueOf("#804000");
  assert.equal(r, 1);
  assert.ok(g > 0.2 && g < 0.3 && b === 0, `${g}`);
  assert.deepEqual(hueOf("#000000"), [1, 1, 1]);
});

test("a dark light has no setting", () => {
  assert.equal(settingOf([0, 0, 0], 50), null);
});

test("strengthField is the adjustable field of each kind, or null if another one is set", () => {
  assert.equal(strengthField({}), "intensity");
  assert.equal(strengthField({ kind: "directional", irradiance_w_m2: 2 }), "irradiance_w_m2");
  assert.equal(strengthField({ kind: "sphere" }), null);
  assert.equal(strengthField(/** @type {any} */ ({ kind: "point", flux_lm: 800 })), null);
  assert.equal(neutralStrength({ kind: "directional" }, extent), Math.PI);
  assert.equal(neutralStrength({ kind: "ambient" }, extent), 1);
  assert.equal(neutralStrength({ kind: "spot" }, extent), Math.PI * 64);
  assert.deepEqual(settingOf(2, 1), { color: "#ffffff", ev: 1 });
});
