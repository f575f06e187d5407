/** Ray ends as the page reads them. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { indexOf } from "../live/paint.js";
import { endsKey, readRayEnds } from "../live/ray_ends.js";

test("a file of ray ends is read in blocks, and one of another version is refused", () => {
  const [pixels, side, rows] = [3, 2, [0, 1, 1]];
  const bytes = new ArrayBuffer(28 + 4 * 3 + 24 * 9 + (48 + 2 * 16) * side * 2);
  const file = new DataView(bytes);
  [..."broodend"].forEach((letter, k) => file.setUint8(k, letter.charCodeAt(0)));
  [1, pixels, side, 3, 2, ...rows].forEach((number, k) => file.setUint32(8 + 4 * k, number, true));
  const positions = 40 + 24 * 9;
  file.setFloat32(positions + 16, 2.5, true);
  file.setUint16(bytes.byteLength - 2, 7, true);
  const found = readRayEnds(bytes);
  assert.deepEqual([found.pixels, found.side, found.rows], [pixels, side, rows]);
  assert.deepEqual([found.numbers.length, found.lengths.length], [36, 36]);
  assert.equal(found.positions[4], 2.5, "the second end");
  assert.equal(found.angles.length, 2);
  assert.equal(found.angles[1].at(-1), 7 << 16, "the last block ends with the file");
  file.setUint32(8, 2, true);
  assert.throws(() => readRayEnds(bytes), /another version/);
});

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

test("exported code names the index of refraction of a clear material", () => {
  assert.equal(indexOf("precision highp float;\nconst float STYLED_INDEX = 1.33;\n"), 1.33);
  assert.equal(indexOf("vec3 styled(StyledPoint at) {}"), null);
});
