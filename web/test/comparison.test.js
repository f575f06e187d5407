/** Choice of materials to compare. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import {
  MOST, isChosen, presetChoice, setReference, shownChoices, toggle,
} from "../compare/comparison.js";
import { compareStore } from "../compare/store.js";
import { lineageStore } from "../lineage/store.js";

/** @param {string} key */
const choice = (key) => ({ key, name: key, picture: "" });
/** @param {string} id @param {number} slot */
const individual = (id, slot) => /** @type {any} */ ({ id, slot, thumbnail: `/${id}.png` });

beforeEach(() => {
  compareStore.chosen.value = [];
  compareStore.result.value = null;
});

test("materials are chosen in order, once each, up to the limit", () => {
  for (let at = 0; at < MOST + 2; at += 1) toggle(choice(String(at)));
  assert.deepEqual(
    compareStore.chosen.value.map(({ key }) => key),
    ["0", "1", "2", "3", "4", "5"],
  );
  toggle(choice("2"));
  toggle(choice("7"));
  assert.deepEqual(
    compareStore.chosen.value.map(({ key }) => key),
    ["0", "1", "3", "4", "5", "7"],
  );
  setReference(choice("4"));
  assert.deepEqual(
    compareStore.chosen.value.map(({ key }) => key),
    ["4", "0", "1", "3", "5", "7"],
  );
  assert.ok(isChosen(choice("7")) && !isChosen(choice("2")));
});

test("a result is current only for the same choice in the same order", () => {
  const of = [choice("a"), choice("b")];
  compareStore.result.value = { of, found: /** @type {any} */ ({}) };
  assert.equal(compareStore.resultIsCurrent.value, false);
  compareStore.chosen.value = [...of];
  assert.equal(compareStore.resultIsCurrent.value, true);
  compareStore.chosen.value = [of[1], of[0]];
  assert.equal(compareStore.resultIsCurrent.value, false);
});

test("shownChoices names the centre by its birth and each frame by its place", () => {
  const first = /** @type {any} */ ({
    id: "g0",
    index: 0,
    centre: null,
    individuals: [individual("a", 0), individual("b", 1)],
  });
  const second = /** @type {any} */ ({
    id: "g1",
    index: 1,
    centre: individual("b", 1),
    individuals: [individual("c", 0), individual("d", 20)],
  });
  lineageStore.generations.value = new Map([
    ["g0", first],
    ["g1", second],
  ]);
  lineageStore.shownId.value = "g1";
  assert.deepEqual(
    shownChoices().map(({ key, name }) => [key, name]),
    [
      ["b", "generation 0, frame 2"],
      ["c", "generation 1, frame 1"],
    ],
  );
  lineageStore.shownId.value = "g0";
  assert.deepEqual(
    shownChoices().map(({ key }) => key),
    ["a", "b"],
  );
  lineageStore.generations.value = new Map();
  lineageStore.shownId.value = null;
  assert.deepEqual(shownChoices(), []);
});

test("presetChoice has the preset's name and picture", () => {
  const preset = /** @type {any} */ ({ name: "gold", title: "Gold", text: "brood 1\n" });
  assert.deepEqual(presetChoice(preset), {
    key: "gold",
    name: "Gold",
    picture: "/web/presets/gold.png",
    preset,
  });
});
