import assert from "node:assert/strict";
import { test } from "node:test";

import { mapPixels, nextInWords } from "../search/spread.js";

test("map is red where the material is open and green where pixels are", () => {
  const pixels = mapPixels({ cells: 2, seen: [1, 0, 0, 0], deviation: [0, 0.5, 2, 0] });
  assert.deepEqual([...pixels].slice(0, 12), [0, 180, 32, 255, 128, 0, 32, 255, 255, 0, 32, 255]);
});

test("next picture has the lamp as the camera sees it", () => {
  const scene = /** @type {any} */ ({ light_deg: 90 });
  const words = (/** @type {number[]|null} */ light_deg) => nextInWords({ light_deg, scene, e_log: 0.1 });
  assert.equal(words([-103.6, 42.5]), "the lamp 104° to the left of the camera and 43° above it");
  assert.equal(words([12, -5]), "the lamp 12° to the right of the camera and 5° below it");
  assert.equal(words(null), 'turn the environment: "light_deg" 90');
});
