import assert from "node:assert/strict";
import { test } from "node:test";

import { besides, placed, spotOf } from "../scene/spot.js";

/** @type {import("../model.js").Scene} */
const scene = {
  mesh: "knob", rotation_deg: [0, 0, 0], scale: 2, camera: {},
  film: { exposure: "auto", tone: "none" }, ground: {},
};
const subject = { centre: [0, 1, 0], radius: 3 };
const own = { centre: [0, 0.5, 0.25], radius: 2 };
/** @type {any} */
const extents = { subject, own };

test("an object is where its sliders say", () => {
  for (const spot of [
    { around: 0, distance: 1, height: 0, radius: 0.5 },
    { around: 105, distance: 2.5, height: -0.5, radius: 1 },
    { around: 350, distance: 0.75, height: 2, radius: 0.1 },
  ]) {
    const found = spotOf(placed({ mesh: "ball" }, spot, scene, extents), scene, extents);
    assert.ok(Math.abs(found.around - spot.around) < 1e-9, String(found.around));
    assert.ok(Math.abs(found.distance - spot.distance) < 1e-9);
    assert.ok(Math.abs(found.radius - spot.radius) < 1e-9);
  }
});

test("an object keeps its material, and its height if it does not stand", () => {
  const spot = { around: 90, distance: 1.5, height: 0.5, radius: 0.5 };
  const on = placed({ mesh: "cube", material: "gold", stands: true }, spot, scene, extents);
  assert.deepEqual([on.stands, on.material], [true, "gold"]);
  assert.equal((on.position ?? [])[1], 1 + 0.5 * 6 - 0.5);
});

test("objects stay beside another subject as they were", () => {
  const before = { around: 30, distance: 1.25, height: 0.3, radius: 0.4 };
  const first = placed({ mesh: "ball" }, before, scene, extents);
  const to = { ...scene, mesh: "large", scale: 1 };
  const large = { centre: [5, 0, 0], radius: 40 };
  const [moved] = besides([first], { from: scene, to }, /** @type {any} */ ({ from: subject, to: large, own: [own] }));
  const found = spotOf(moved, to, /** @type {any} */ ({ subject: large, own }));
  for (const name of /** @type {const} */ (["around", "distance", "height", "radius"]))
    assert.ok(Math.abs(found[name] - before[name]) < 1e-9, name);
});
