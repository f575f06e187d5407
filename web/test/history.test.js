/** Undo, redo and the arcs of the strip. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { ancestry, descentOf, links, redoTarget, step, undoTarget } from "../lineage/history.js";

/** Generation `g<index>` with children `i<index>.0` and `i<index>.1`. */
function generation(index, ...parents) {
  const individuals = [0, 1].map((slot) => ({
    id: `i${index}.${slot}`,
    hash: `h${index}.${slot}`,
    slot,
  }));
  return { id: `g${index}`, index, parents, individuals };
}

// g0 -> g1 -> g2, and a branch g0 -> g3; g4 is a random brood.
const descent = descentOf([
  generation(0),
  generation(1, "i0.1"),
  generation(2, "i1.0", "i0.0"),
  generation(3, "h0.0"),
  generation(4),
]);
const empty = { past: [], future: [] };

test("a generation descends from where its first parent was born, also by hash", () => {
  assert.deepEqual(
    [...descent.parents],
    [
      ["g1", "g0"],
      ["g2", "g1"],
      ["g3", "g0"],
    ],
  );
  assert.deepEqual([...ancestry(descent.parents, "g2")], ["g2", "g1", "g0"]);
});

test("undo follows the trail and falls back to descent when a link was opened", () => {
  assert.equal(undoTarget({ past: ["g1", "g3"], future: [] }, descent, "g2"), "g3");
  assert.equal(undoTarget(empty, descent, "g3"), "g0");
  assert.equal(undoTarget(empty, descent, "g4"), "g3");
  assert.equal(undoTarget(empty, descent, "g0"), null);
});

test("undo skips the shown generation and unknown ones", () => {
  assert.equal(undoTarget({ past: ["g0", "gone", "g2"], future: [] }, descent, "g2"), "g0");
});

test("redo shows the newest child when nothing was undone", () => {
  assert.equal(redoTarget(empty, descent, "g0"), "g3");
  assert.equal(redoTarget(empty, descent, "g2"), null);
});

test("undo then redo restores the trail, and a branch drops only the redo trail", () => {
  const bred = step(step(empty, "g0", "g1", "visit"), "g1", "g2", "visit");
  const undone = step(bred, "g2", "g1", "undo");
  assert.deepEqual(undone, { past: ["g0"], future: ["g2"] });
  assert.deepEqual(step(undone, "g1", "g2", "redo"), bred);
  assert.deepEqual(step(undone, "g1", "g3", "visit"), { past: ["g0", "g1"], future: [] });
});

test("links join columns and mark the ancestry of the shown generation", () => {
  const path = ancestry(descent.parents, "g3");
  const found = links(descent, path).map(({ from, to, onPath }) => [from, to, onPath]);
  assert.deepEqual(found, [
    [0, 1, false],
    [1, 2, false],
    [0, 3, true],
  ]);
});
