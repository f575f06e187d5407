/** Files of workers as the page reads them. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { readRayEnds } from "../live/ray_ends.js";
import { readAngles } from "../live/shadows.js";

/**
 * A file of zeros behind its head.
 * @param {string} magic
 * @param {number} size in bytes
 * @param {number[]} numbers of the head, the version first
 */
function fileOf(magic, size, numbers) {
  const bytes = new ArrayBuffer(size);
  const file = new DataView(bytes);
  [...magic].forEach((letter, k) => file.setUint8(k, letter.charCodeAt(0)));
  numbers.forEach((number, k) => file.setUint32(8 + 4 * k, number, true));
  return { bytes, file };
}

test("a file of lit angles is read, and one of another version is refused", () => {
  const { bytes, file } = fileOf("broodang", 20 + 16 * 2 * 9, [1, 3, 2]);
  const { side, lights, pairs } = readAngles(bytes);
  assert.deepEqual([side, lights, pairs.length], [3, 2, 72]);
  file.setUint32(8, 2, true);
  assert.throws(() => readAngles(bytes), /another version/);
});

test("a file of ray ends is read in blocks, and one of another version is refused", () => {
  const [pixels, side, rows] = [3, 2, [0, 1, 1]];
  const size = 28 + 4 * 3 + 24 * 9 + (48 + 2 * 16) * side * 2;
  const { bytes, file } = fileOf("broodend", size, [1, pixels, side, 3, 2, ...rows]);
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
