// Distance to the server, and the addresses of pictures.

import assert from "node:assert/strict";
import { test } from "node:test";

import { isFar, pictureOfSource, pictureSource } from "../page/distance.js";

/** @param {number} late_ms @param {number} sending_ms @param {number} transferSize */
const timing = (late_ms, sending_ms, transferSize) => ({
  requestStart: 5,
  responseStart: 5 + late_ms,
  responseEnd: 5 + late_ms + sending_ms,
  transferSize,
});

test("a server is far if it answers late or sends slowly", () => {
  assert.equal(isFar([]), false);
  assert.equal(isFar([timing(2, 1, 100_000)]), false, "the same machine");
  assert.equal(isFar([timing(20, 40, 100_000)]), false, "20 Mbit/s");
  assert.equal(isFar([timing(300, 1, 1300)]), true, "300 ms away");
  assert.equal(isFar([timing(20, 500, 100_000)]), true, "1.6 Mbit/s");
  assert.equal(isFar([timing(20, 10, 1300)]), false, "few bytes are no measure");
  assert.equal(isFar([timing(300, 1, 1300), timing(9, 1, 1300)]), false, "late once");
  const cached = { requestStart: 0, responseStart: 400, responseEnd: 401, transferSize: 0 };
  assert.equal(isFar([cached]), false, "the browser's cache");
});

test("only thumbnails have two addresses, and state is kept by one of them", () => {
  const key = "0f".repeat(32);
  const url = `/v1/thumbnails/${key}.png`;
  assert.equal(pictureSource(url), url, "near a server");
  assert.equal(pictureOfSource(`/v1/thumbnails/${key}.webp`), url);
  assert.equal(pictureOfSource(url), url);
  for (const other of ["/v1/targets/1/picture.png", "blob:http://h/1", "/v1/thumbnails/x.webp"])
    assert.equal(pictureOfSource(other), other);
});
