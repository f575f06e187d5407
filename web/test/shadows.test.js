/** Keys and angles of shadows. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { angleOf, shadowKey } from "../live/shadows.js";

test("angles of the light are those of files", () => {
  assert.deepEqual([0, 360, -90, 75.5, 359.999].map(angleOf), [0, 0, 49151, 13744, 65534]);
});

test("shadows depend on places, not on strengths or the present angle", () => {
  const scene = /** @type {import("../model.js").Scene} */ ({
    mesh: "knob",
    rotation_deg: [0, 0, 0],
    scale: 1,
    camera: {},
    film: { exposure: "auto", tone: "none" },
    shadows: true,
    lights: [{ position: [1, 2, 3], intensity: [1, 1, 1] }],
  });
  const same = { ...scene, light_deg: 30, lights: [{ ...scene.lights?.[0], intensity: 4 }] };
  assert.equal(shadowKey(same), shadowKey(scene));
  assert.notEqual(shadowKey({ ...scene, lights: [{}] }), shadowKey(scene));
  assert.notEqual(shadowKey({ ...scene, rotation_deg: [0, 9, 0] }), shadowKey(scene));
  assert.equal(shadowKey({ ...scene, shadows: false }), "");
  const objects = [{ scale: 0.5, material: "gold" }];
  const beside = shadowKey({ ...scene, objects, ground: {} });
  assert.notEqual(beside, shadowKey({ ...scene, objects }));
  const grey = [{ scale: 0.5 }];
  assert.equal(shadowKey({ ...scene, objects: grey, ground: { material: "gold" } }), beside);
  assert.notEqual(shadowKey({ ...scene, objects: grey, ground: { height: 0 } }), beside);
});
