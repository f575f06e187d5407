import assert from "node:assert/strict";
import { test } from "node:test";

import { placed, spotOf } from "../scene/objects.js";

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
    { around: 0, distance: 1, radius: 0.5 },
    { around: 105, distance: 2.5, radius: 1 },
    { around: 350, distance: 0.75, radius: 0.1 },
  ]) {
    const found = spotOf(placed({ mesh: "ball" }, spot, scene, extents), scene, extents);
    assert.ok(Math.abs(found.around - spot.around) < 1e-9, String(found.around));
    assert.ok(Math.abs(found.distance - spot.distance) < 1e-9);
    assert.ok(Math.abs(found.radius - spot.radius) < 1e-9);
  }
});

test("an object stands on the ground if there is one, and keeps its material", () => {
  const spot = { around: 90, distance: 1.5, radius: 0.5 };
  const on = placed({ mesh: "cube", material: "gold" }, spot, scene, extents);
  assert.equal(on.stands, true);
  assert.equal(on.material, "gold");
  const level = placed(on, spot, { ...scene, ground: null }, extents);
  assert.equal(level.stands, undefined);
  assert.equal((level.position ?? [])[1], 0.5);
});
