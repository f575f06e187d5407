/**
 * Divides a picture into square cells and finds those that no light can reach, which need no
 * shading. Conservative: never calls a lit pixel dark.
 *
 * A light is above a pixel's horizon if n . light > n . p. Over a cell, the left side is bounded
 * from above by the box around its normals, and the right side from below by its least value.
 *
 * @import { PointLight } from "./camera.js"
 */

/**
 * Side of a cell in pixels. Even, because software shades blocks of 2 x 2 pixels and shades blocks
 * on a border twice.
 */
export const CELL = 8;
/** Rounding error of the GPU for numbers as large as 1. */
const ROUNDING = 1e-5;
/**
 * Numbers per cell: the least and largest of each component of its normals, and the least n . p.
 */
const BOUNDS = 7;

/**
 * @typedef {{across: number, count: number, middles: Float32Array, bounds: Float64Array}} Cells
 *   `across`: cells in a row of the picture; `count`: cells that hold part of the object;
 *   `middles`: x and y of each of them, from -1 to 1 over `across` cells.
 */

/**
 * Bounds each cell together with the pixels to its left and below, because it may be drawn one
 * pixel further that way.
 * @param {Float32Array} points four numbers a pixel, row by row
 * @param {Float32Array} normals likewise; the fourth is 0 outside of the object
 * @param {number} side of the picture in pixels
 * @returns {Cells}
 */
export function cellsOf(points, normals, side) {
  const across = Math.ceil((side + 1) / CELL);
  const middles = new Float32Array(2 * across * across);
  const bounds = new Float64Array(BOUNDS * across * across);
  let count = 0;
  for (let cell = 0; cell < across * across; cell += 1) {
    const [column, row] = [cell % across, Math.floor(cell / across)];
    const bound = bounds
      .subarray(BOUNDS * count, BOUNDS * (count + 1))
      .fill(Number.POSITIVE_INFINITY);
    bound.fill(Number.NEGATIVE_INFINITY, 3, 6);
    let empty = true;
    for (let y = Math.max(0, CELL * row - 1); y < Math.min(side, CELL * (row + 1)); y += 1) {
      for (
        let x = Math.max(0, CELL * column - 1);
        x < Math.min(side, CELL * (column + 1));
        x += 1
      ) {
        const at = 4 * (y * side + x);
        if (normals[at + 3] === 0) continue;
        empty = false;
        let height = 0;
        for (let axis = 0; axis < 3; axis += 1) {
          const part = normals[at + axis];
          bound[axis] = Math.min(bound[axis], part);
          bound[3 + axis] = Math.max(bound[3 + axis], part);
          height += part * points[at + axis];
        }
        bound[6] = Math.min(bound[6], height);
      }
    }
    if (empty) continue;
    middles.set([(2 * column + 1) / across - 1, (2 * row + 1) / across - 1], 2 * count);
    count += 1;
  }
  return {
    across,
    count,
    middles: middles.slice(0, 2 * count),
    bounds: bounds.slice(0, BOUNDS * count),
  };
}

/**
 * True if a light may be above the horizon of some pixel of a cell.
 * @param {Float64Array} bounds
 * @param {number} first index of the cell's bounds
 * @param {PointLight} light
 */
function reaches(bounds, first, { place }) {
  let most = 0;
  for (let axis = 0; axis < 3; axis += 1)
    most += Math.max(bounds[first + axis] * place[axis], bounds[first + 3 + axis] * place[axis]);
  const margin = ROUNDING * (1 + Math.abs(place[0]) + Math.abs(place[1]) + Math.abs(place[2]));
  // Written as a negation, so that NaN counts as lit.
  return !(most < bounds[first + 6] - margin);
}

/**
 * Middles of the cells that a light may reach.
 * @param {Cells} cells
 * @param {PointLight[]} lights
 */
export function litMiddles({ count, middles, bounds }, lights) {
  const found = new Float32Array(2 * count);
  let lit = 0;
  for (let cell = 0; cell < count; cell += 1) {
    if (!lights.some((light) => reaches(bounds, BOUNDS * cell, light))) continue;
    found[2 * lit] = middles[2 * cell];
    found[2 * lit + 1] = middles[2 * cell + 1];
    lit += 1;
  }
  return found.subarray(0, 2 * lit);
}
