/** Sizes of pictures. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { requestedSize, sidesOf, sizeInWords } from "../page/size.js";

test("a size of the server is a side or width and height", () => {
  assert.deepEqual(sidesOf(64), [64, 64]);
  assert.deepEqual(sidesOf([640, 360]), [640, 360]);
  assert.equal(sizeInWords(64), "64 × 64");
  assert.equal(sizeInWords([640, 360]), "640 × 360");
});

test("a requested size has two sides that the server renders", () => {
  assert.equal(requestedSize({ width: "640", height: " 360 " }), "640x360");
  assert.equal(requestedSize({ width: "16", height: "2048" }), "16x2048");
  for (const wrong of ["", "15", "2049", "1e3", "-64", "64.5", "wide"]) {
    assert.equal(requestedSize({ width: wrong, height: "64" }), null, wrong);
    assert.equal(requestedSize({ width: "64", height: wrong }), null, wrong);
  }
});
