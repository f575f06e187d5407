/** Lit angles as the page reads them. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { angleOf, readAngles, shadowKey } from "../live/shadows.js";

test("angles of the light are those of files", () => {
  assert.deepEqual([0, 360, -90, 75.5, 359.999].map(angleOf), [0, 0, 49151, 13744, 65534]);
});

test("a file of lit angles is read, and one of another version is refused", () => {
  const bytes = new ArrayBuffer(20 + 16 * 2 * 9);
  const file = new DataView(bytes);
  [..."broodang"].forEach((letter, k) => file.setUint8(k, letter.charCodeAt(0)));
  [1, 3, 2].forEach((number, k) => file.setUint32(8 + 4 * k, number, true));
  const { side, lights, pairs } = readAngles(bytes);
  assert.deepEqual([side, lights, pairs.length], [3, 2, 72]);
  file.setUint32(8, 2, true);
  assert.throws(() => readAngles(bytes), /another version/);
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
