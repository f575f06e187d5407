/** A/B comparison: pasted links, the flip key, and what the centre shows. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { flipKeyB, individualSeenIn, parsePasted } from "../compare/ab.js";
import { compareStore } from "../compare/store.js";

const HERE = "http://127.0.0.1:7000";
const ID = "01a1ffd9-51b1-75fb-b7c0-def93ade19a9";
const OTHER = "01a1ffd9-51b0-756b-975c-24f457241d68";

test("parsePasted accepts ids, share links with and without a generation, and API addresses", () => {
  assert.deepEqual(parsePasted(` ${ID.toUpperCase()}\n`, HERE), { individual: ID });
  assert.deepEqual(parsePasted(`${HERE}/#/lineage/${OTHER}/generation/${ID}`, HERE), {
    generation: ID,
  });
  assert.deepEqual(parsePasted(`#/lineage/${OTHER}/generation/${ID}`, HERE), { generation: ID });
  assert.deepEqual(parsePasted(`${HERE}/#/lineage/${OTHER}`, HERE), { lineage: OTHER });
  assert.deepEqual(parsePasted(`${HERE}/v1/individuals/${ID}/render.png?size=64`, HERE), {
    individual: ID,
  });
});

test("parsePasted says why a text names nothing", () => {
  /** @param {string} text */
  const wrong = (text) => Object(parsePasted(text, HERE)).wrong;
  assert.match(wrong("the green one"), /neither/);
  assert.match(wrong("http://["), /neither/);
  assert.match(wrong(`#/lineage/x/generation/../../${ID}`), /neither/);
  assert.match(wrong(`https://else.example/#/lineage/${OTHER}/generation/${ID}`), /else\.example/);
});

test("a short press flips, and a held key flips until release", () => {
  compareStore.pinned.value = /** @type {any} */ ({ id: ID });
  compareStore.flipped.value = false;
  flipKeyB.down(1000);
  flipKeyB.up(1100);
  assert.equal(compareStore.flipped.value, true);
  flipKeyB.down(2000);
  assert.equal(compareStore.flipped.value, false);
  flipKeyB.up(2800);
  assert.equal(compareStore.flipped.value, true);
  compareStore.pinned.value = null;
});

test("B replaces the target in the centre, and no individual is visible while the target is", () => {
  const b = /** @type {any} */ ({ id: ID });
  compareStore.pinned.value = b;
  compareStore.flipped.value = true;
  compareStore.targetInCentre.value = true;
  assert.equal(individualSeenIn("centre"), null);
  flipKeyB.down(1000);
  flipKeyB.up(1010);
  assert.equal(compareStore.targetInCentre.value, false);
  compareStore.flipped.value = true;
  assert.equal(individualSeenIn("centre"), b);
  compareStore.flipped.value = false;
  compareStore.pinned.value = null;
});
