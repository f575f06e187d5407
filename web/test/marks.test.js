/** Marks of burnt-out and black pixels. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { marked } from "../view/marks.js";

test("a pixel is burnt out if any channel is full, black if all are empty, and an edge pixel is neither", () => {
  const { burnt, black } = marked(
    new Uint8ClampedArray([
      255, 3, 0, 255, 254, 254, 254, 255, 0, 0, 0, 255, 0, 1, 0, 255, 255, 255, 255, 128, 0, 0, 0,
      0,
    ]),
  );
  /** @param {Uint8ClampedArray} mask */
  const where = (mask) => [...mask].filter((_, at) => at % 4 === 3).map((alpha) => alpha === 255);
  assert.deepEqual(where(burnt), [true, false, false, false, false, false]);
  assert.deepEqual(where(black), [false, false, true, false, false, false]);
});
