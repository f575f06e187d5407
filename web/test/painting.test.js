/** Tests of colours of a painting: words, and files that may be one. */
import assert from "node:assert/strict";
import { test } from "node:test";

import { isPicture, regionsInWords, shareInWords } from "../lineage/painting.js";

const region = { dark: "#000000", middle: "#808080", bright: "#ffffff", share: 0.6127 };

test("regions and their shares have words", () => {
  assert.equal(regionsInWords({ regions: [region] }), "colours of 1 region");
  assert.equal(regionsInWords({ regions: [region, region] }), "colours of 2 regions");
  assert.equal(shareInWords(region), "61 % of the picture");
  assert.equal(shareInWords({ ...region, share: 0.0042 }), "0.4 % of the picture");
});

test("pictures are known by their names", () => {
  for (const name of ["a.png", "b.JPG", "c.jpeg"]) assert.ok(isPicture(new File([], name)), name);
  for (const name of ["a.exr", "png", "b.png.obj"]) assert.ok(!isPicture(new File([], name)), name);
});
