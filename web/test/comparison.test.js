/** What is compared: chosen in order, up to six, and left out again. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { MOST, chosen, compared, isChosen, isCurrent, ofPreset, onStage, putFirst, toggle } from "../comparison.js";
import { generations, shown } from "../state.js";

/** @param {string} key */
const choice = (key) => ({ key, name: key, picture: "" });
/** @param {string} id @param {number} slot */
const individual = (id, slot) => /** @type {any} */ ({ id, slot, thumbnail: `/${id}.png` });

beforeEach(() => {
  chosen.value = [];
  compared.value = null;
});

test("materials are chosen in order, once each, and no more than fit", () => {
  for (let at = 0; at < MOST + 2; at += 1) toggle(choice(String(at)));
  assert.deepEqual(chosen.value.map(({ key }) => key), ["0", "1", "2", "3", "4", "5"]);
  toggle(choice("2"));
  toggle(choice("7"));
  assert.deepEqual(chosen.value.map(({ key }) => key), ["0", "1", "3", "4", "5", "7"]);
  putFirst(choice("4"));
  assert.deepEqual(chosen.value.map(({ key }) => key), ["4", "0", "1", "3", "5", "7"]);
  assert.ok(isChosen(choice("7")) && !isChosen(choice("2")));
});

test("an answer is of the choice that was asked for, in its order", () => {
  const of = [choice("a"), choice("b")];
  compared.value = { of, found: /** @type {any} */ ({}) };
  assert.equal(isCurrent.value, false);
  chosen.value = [...of];
  assert.equal(isCurrent.value, true);
  chosen.value = [of[1], of[0]];
  assert.equal(isCurrent.value, false);
});

test("the stage offers the centre by where it was born, and each frame by its own place", () => {
  const first = /** @type {any} */ ({ id: "g0", index: 0, centre: null, individuals: [individual("a", 0), individual("b", 1)] });
  const second = /** @type {any} */ ({ id: "g1", index: 1, centre: individual("b", 1), individuals: [individual("c", 0), individual("d", 20)] });
  generations.value = new Map([["g0", first], ["g1", second]]);
  shown.value = "g1";
  assert.deepEqual(onStage().map(({ key, name }) => [key, name]), [["b", "generation 0, frame 2"], ["c", "generation 1, frame 1"]]);
  shown.value = "g0";
  assert.deepEqual(onStage().map(({ key }) => key), ["a", "b"]);
  generations.value = new Map();
  shown.value = null;
  assert.deepEqual(onStage(), []);
});

test("a preset is known by its name and shown by its picture", () => {
  const preset = /** @type {any} */ ({ name: "gold", title: "Gold", text: "brood 1\n" });
  assert.deepEqual(ofPreset(preset), { key: "gold", name: "Gold", picture: "/web/presets/gold.png", preset });
});
