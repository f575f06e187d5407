import assert from "node:assert/strict";
import { test } from "node:test";
import { flipKeyDown, flipKeyUp, flipped, namedIn, pinned } from "../compare.js";

const HERE = "http://127.0.0.1:7000";
const ID = "01a1ffd9-51b1-75fb-b7c0-def93ade19a9";
const OTHER = "01a1ffd9-51b0-756b-975c-24f457241d68";

test("an id, a shared link, a link without a generation and an address of the interface are understood", () => {
  assert.deepEqual(namedIn(` ${ID.toUpperCase()}\n`, HERE), { individual: ID });
  assert.deepEqual(namedIn(`${HERE}/#/lineage/${OTHER}/generation/${ID}`, HERE), { generation: ID });
  assert.deepEqual(namedIn(`#/lineage/${OTHER}/generation/${ID}`, HERE), { generation: ID });
  assert.deepEqual(namedIn(`${HERE}/#/lineage/${OTHER}`, HERE), { lineage: OTHER });
  assert.deepEqual(namedIn(`${HERE}/v1/individuals/${ID}/render.png?size=64`, HERE), { individual: ID });
});

test("what names nothing is told apart by its reason", () => {
  /** @param {string} text */
  const wrong = (text) => Object(namedIn(text, HERE)).wrong;
  assert.match(wrong("the green one"), /neither/);
  assert.match(wrong("http://["), /neither/);
  assert.match(wrong(`#/lineage/x/generation/../../${ID}`), /neither/);
  assert.match(wrong(`https://else.example/#/lineage/${OTHER}/generation/${ID}`), /else\.example/);
});

test("a short press flips, and a held one only for as long as it is held", () => {
  pinned.value = /** @type {any} */ ({ id: ID });
  flipped.value = false;
  flipKeyDown(1000);
  flipKeyUp(1100);
  assert.equal(flipped.value, true);
  flipKeyDown(2000);
  assert.equal(flipped.value, false);
  flipKeyUp(2800);
  assert.equal(flipped.value, true);
  pinned.value = null;
});
