/** Cells of a picture that lights may reach. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { CELL, cellsOf, litMiddles } from "../live/cells.js";

const SIDE = 61;

/** Pseudo-random numbers, the same in each run. @param {number} seed */
function thrown(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** A bumpy ball with a hole, seen by a camera along -z. @param {number} bumps */
function seen(bumps) {
  const points = new Float32Array(4 * SIDE * SIDE);
  const normals = new Float32Array(4 * SIDE * SIDE);
  for (let at = 0; at < SIDE * SIDE; at += 1) {
    const [x, y] = [(at % SIDE) / 30 - 1, Math.floor(at / SIDE) / 30 - 1];
    const z = Math.sqrt(Math.max(0, 1 - x * x - y * y));
    if (z === 0 || Math.hypot(x - 0.3, y) < 0.1) continue;
    const [a, b] = [x + bumps * Math.sin(9 * x), y + bumps * Math.cos(7 * y)];
    const length = Math.hypot(a, b, z);
    points.set([x, y, z, 1], 4 * at);
    normals.set([a / length, b / length, z / length, 1], 4 * at);
  }
  return { points, normals };
}

/**
 * Lower left corners of the cells as they are drawn.
 * @param {number} across
 * @param {Float32Array} middles
 * @param {number} shift
 */
function corners(across, middles, shift) {
  return Array.from({ length: middles.length / 2 }, (_, k) =>
    [0, 1].map(
      (axis) => Math.round(((middles[2 * k + axis] + 1) * across * CELL - CELL) / 2) - shift,
    ),
  );
}

test("cells without light contain no lit pixel, wherever cells are drawn", () => {
  const random = thrown(1);
  for (const bumps of [0, 0.2, 0.8]) {
    const { points, normals } = seen(bumps);
    const cells = cellsOf(points, normals, SIDE);
    for (let round = 0; round < 60; round += 1) {
      const lights = Array.from({ length: 1 + (round % 3) }, () => {
        const far = 0.5 + 10 * random() ** 3;
        return {
          place: /** @type {[number, number, number]} */ (
            [0, 1, 2].map(() => far * (2 * random() - 1))
          ),
          intensity: /** @type {[number, number, number]} */ ([1, 1, 1]),
        };
      });
      const middles = litMiddles(cells, lights);
      for (const shift of [0, 1]) {
        const drawn = new Uint8Array(SIDE * SIDE);
        corners(cells.across, middles, shift).forEach(([left, low]) => {
          for (let y = Math.max(0, low); y < Math.min(SIDE, low + CELL); y += 1) {
            for (let x = Math.max(0, left); x < Math.min(SIDE, left + CELL); x += 1)
              drawn[y * SIDE + x] += 1;
          }
        });
        for (let at = 0; at < SIDE * SIDE; at += 1) {
          if (normals[4 * at + 3] === 0) continue;
          const [p, n] = [
            points.subarray(4 * at, 4 * at + 3),
            normals.subarray(4 * at, 4 * at + 3),
          ];
          const wanted = lights.some(
            ({ place }) =>
              n.reduce((sum, part, axis) => sum + part * (place[axis] - p[axis]), 0) > 0,
          );
          assert.ok(drawn[at] === 1 || (drawn[at] === 0 && !wanted), `${drawn[at]} at ${at}`);
        }
      }
    }
  }
});

test("about half of a ball is dark under a light from the side", () => {
  const { points, normals } = seen(0);
  const cells = cellsOf(points, normals, SIDE);
  /** @param {[number, number, number][]} places */
  const lit = (...places) =>
    litMiddles(
      cells,
      places.map((place) => ({ place, intensity: [1, 1, 1] })),
    ).length / 2;
  const half = lit([100, 0, 0]);
  assert.ok(half > 0.45 * cells.count && half < 0.65 * cells.count, `${half} of ${cells.count}`);
  assert.ok(lit([0, 0, -4]) < 0.4 * cells.count);
  assert.equal(lit(), 0);
});

test("cells outside of the object do not exist, and NaN counts as lit", () => {
  assert.equal(cellsOf(new Float32Array(4), new Float32Array(4), 1).count, 0);
  const cells = cellsOf(new Float32Array([0, 0, Number.NaN, 1]), new Float32Array([0, 0, 1, 1]), 1);
  assert.deepEqual([cells.across, cells.count], [1, 1]);
  assert.equal(litMiddles(cells, [{ place: [0, 0, -4], intensity: [1, 1, 1] }]).length, 2);
});
