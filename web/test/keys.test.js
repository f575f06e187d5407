/** Arrow keys on the frames, and the address. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { format, parse } from "../page/route.js";
import { PLACES, neighbour } from "../view/keys.js";

const UP = [-1, 0];
const DOWN = [1, 0];
const LEFT = [0, -1];
const RIGHT = [0, 1];

test("slots go row by row around the centre", () => {
  assert.equal(PLACES.length, 20);
  assert.deepEqual(
    [PLACES[5], PLACES[6], PLACES[7], PLACES[13], PLACES[14]],
    [
      [0, 5],
      [1, 0],
      [1, 5],
      [4, 5],
      [5, 0],
    ],
  );
});

test("arrow keys cross the centre in the row or column where they entered", () => {
  assert.equal(neighbour(2, DOWN), "centre");
  assert.equal(neighbour("centre", DOWN), 16);
  assert.equal(neighbour(10, RIGHT), "centre");
  assert.equal(neighbour("centre", RIGHT), 11);
  assert.equal(neighbour(3, DOWN), "centre");
  assert.equal(neighbour("centre", UP), 3);
});

test("arrow keys stop at the border", () => {
  assert.equal(neighbour(0, UP), 0);
  assert.equal(neighbour(0, LEFT), 0);
  assert.equal(neighbour(0, RIGHT), 1);
});

test("parse returns what format wrote", () => {
  assert.deepEqual(parse(format("a-1", "b-2")), {
    lineage: "a-1",
    generation: "b-2",
    search: null,
    favourites: null,
  });
  const none = { lineage: null, generation: null, search: null, favourites: null };
  assert.deepEqual(parse(format("a-1", null)), { ...none, lineage: "a-1" });
  assert.deepEqual(parse(""), none);
  assert.equal(format("a-1", "b-2", null, "all"), "#/lineage/a-1/generation/b-2/favourites/all");
  assert.deepEqual(parse("#/favourites/a-1"), { ...none, favourites: "a-1" });
  assert.deepEqual(parse(format("a-1", "b-2", "c-3")), {
    lineage: "a-1",
    generation: "b-2",
    search: "c-3",
    favourites: null,
  });
  assert.deepEqual(parse(format(null, null, "all")), {
    lineage: null,
    generation: null,
    search: "all",
    favourites: null,
  });
});
