import assert from "node:assert/strict";
import { test } from "node:test";
import { hueOf, intensityOf, lampOf, plainIntensity, plainStrength, strengthField } from "../light_color.js";

const extent = { centre: /** @type {[number, number, number]} */ ([0, 1, 0]), radius: 2 };

test("a light that says nothing is white at 0 EV, and back", () => {
  const plain = plainIntensity({}, extent);
  assert.equal(plain, Math.PI * 64);
  assert.deepEqual(lampOf(null, plain), { color: "#ffffff", ev: 0 });
  assert.deepEqual(lampOf([plain, plain, plain], plain), { color: "#ffffff", ev: 0 });
  assert.equal(intensityOf({ color: "#ffffff", ev: 0 }, plain), null);
});

test("a light with a place is counted by its distance", () => {
  assert.equal(plainIntensity({ position: [0, 4, 4] }, extent), Math.PI * 25);
});

test("every colour with a full channel and every stop come back as they were", () => {
  for (const color of ["#ff8000", "#01ff7f", "#0000ff", "#ffffff", "#fffefd"]) {
    for (let ev = -4; ev <= 4; ev += 0.25) {
      assert.deepEqual(lampOf(intensityOf({ color, ev }, 201), 201), { color, ev });
    }
  }
});

test("a dull colour is the hue of its bright one, and black is white", () => {
  const [r, g, b] = hueOf("#804000");
  assert.equal(r, 1);
  assert.ok(g > 0.2 && g < 0.3 && b === 0, `${g}`);
  assert.deepEqual(hueOf("#000000"), [1, 1, 1]);
});

test("a dark light is neither", () => {
  assert.equal(lampOf([0, 0, 0], 50), null);
});

test("every kind of light has one field that is turned, unless the scene has its strength in another", () => {
  assert.equal(strengthField({}), "intensity");
  assert.equal(strengthField({ kind: "directional", irradiance_w_m2: 2 }), "irradiance_w_m2");
  assert.equal(strengthField({ kind: "sphere" }), null);
  assert.equal(strengthField(/** @type {any} */ ({ kind: "point", flux_lm: 800 })), null);
  assert.equal(plainStrength({ kind: "directional" }, extent), Math.PI);
  assert.equal(plainStrength({ kind: "ambient" }, extent), 1);
  assert.equal(plainStrength({ kind: "spot" }, extent), Math.PI * 64);
  assert.deepEqual(lampOf(2, 1), { color: "#ffffff", ev: 1 });
});
