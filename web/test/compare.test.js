import assert from "node:assert/strict";
import { test } from "node:test";
import { flipped, keyOfB, namedIn, pinned, seenIn, targetSeen } from "../compare.js";

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
  keyOfB.down(1000);
  keyOfB.up(1100);
  assert.equal(flipped.value, true);
  keyOfB.down(2000);
  assert.equal(flipped.value, false);
  keyOfB.up(2800);
  assert.equal(flipped.value, true);
  pinned.value = null;
});

test("B takes the target's place in the centre, where no individual is seen while the target is", () => {
  const b = /** @type {any} */ ({ id: ID });
  pinned.value = b;
  flipped.value = true;
  targetSeen.value = true;
  assert.equal(seenIn("centre"), null);
  keyOfB.down(1000);
  keyOfB.up(1010);
  assert.equal(targetSeen.value, false);
  flipped.value = true;
  assert.equal(seenIn("centre"), b);
  flipped.value = false;
  pinned.value = null;
});
