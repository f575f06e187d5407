/** Keys of ray ends, and constants of clear materials. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { indexOf, passedOf } from "../live/paint.js";
import { endsKey } from "../live/ray_ends.js";

test("ends depend on places, on lights only with shadows, not on materials", () => {
  const scene = /** @type {import("../model.js").Scene} */ ({
    mesh: "knob",
    rotation_deg: [0, 0, 0],
    scale: 1,
    camera: {},
    film: { exposure: "auto", tone: "none" },
    lights: [{ position: [1, 2, 3] }],
    objects: [{ mesh: "sphere", position: [1, 0, 0], material: "gold" }],
  });
  const key = endsKey(scene);
  assert.equal(endsKey({ ...scene, lights: [], light_deg: 40 }), key);
  assert.equal(endsKey({ ...scene, objects: [{ mesh: "sphere", position: [1, 0, 0] }] }), key);
  assert.notEqual(endsKey({ ...scene, scale: 0.9 }), key);
  assert.notEqual(endsKey({ ...scene, ground: {} }), key);
  assert.notEqual(endsKey({ ...scene, shadows: true }), key);
});

test("exported code has the constants of a clear material", () => {
  const clear = "precision highp float;\nconst float STYLED_INDEX = 1.33;\nconst float STYLED_PASSED = 0.875;\n";
  assert.deepEqual([indexOf(clear), passedOf(clear)], [1.33, 0.875]);
  const opaque = "vec3 styled(StyledPoint at) {}";
  assert.deepEqual([indexOf(opaque), passedOf(opaque)], [null, 0]);
});
