/**
 * A polygon around the object as the camera sees it. Nothing outside of it is lit or shaded: a
 * sphere leaves a fifth of its square empty, most objects more.
 *
 * @import { View } from "./camera.js"
 */

/** Sides of the polygon. Around a circle its area is 0.6 % too large. */
export const SIDES = 24;
const DIRECTIONS = Array.from({ length: SIDES }, (_, k) => [
  Math.cos((2 * Math.PI * k) / SIDES),
  Math.sin((2 * Math.PI * k) / SIDES),
]);
/** Largest number of vertices; with more, the search takes longer than shading the empty part. */
const MOST = 200_000;
/** Margin in pixels: coverage extends this far beyond the object, plus rounding. */
const MARGIN_PX = 2;

/** The whole square. */
const SQUARE = new Float32Array([-1, -1, 1, -1, 1, 1, -1, 1]);

/**
 * Splits a polygon into triangles that are as thick as possible, because software shades pixels
 * between two triangles twice.
 * @param {Float32Array} corners
 */
export function triangles(corners) {
  const found = [];
  let left = Array.from({ length: corners.length / 2 }, (_, k) => k);
  while (left.length > 2) {
    // Cuts off every other corner.
    for (let k = 0; k + 1 < left.length; k += 2)
      found.push(left[k], left[k + 1], left[(k + 2) % left.length]);
    left = left.filter((_, k) => k % 2 === 0);
  }
  return new Float32Array(found.flatMap((k) => [corners[2 * k], corners[2 * k + 1]]));
}

/**
 * The last result: one view is drawn into several pictures.
 * @type {{positions: Float32Array, view: View, reaches: Float64Array|null}|null}
 */
let last = null;

/**
 * Reach of the object in each direction of the picture; null if it may be anywhere.
 * @param {Float32Array} positions
 * @param {View} view
 * @returns {Float64Array|null}
 */
function reachesOf(positions, view) {
  const { eye, right, up, forward, half, near } = view;
  const reaches = new Float64Array(SIDES).fill(Number.NEGATIVE_INFINITY);
  for (let at = 0; at < positions.length; at += 3) {
    const [x, y, z] = [
      positions[at] - eye[0],
      positions[at + 1] - eye[1],
      positions[at + 2] - eye[2],
    ];
    const depth = x * forward[0] + y * forward[1] + z * forward[2];
    // Points beside or behind the eye may be seen anywhere.
    if (!view.parallel && depth < near) return null;
    const scale = 1 / (half * (view.parallel ? 1 : depth));
    const across = (x * right[0] + y * right[1] + z * right[2]) * scale;
    const upwards = (x * up[0] + y * up[1] + z * up[2]) * scale;
    for (let k = 0; k < SIDES; k += 1)
      reaches[k] = Math.max(reaches[k], across * DIRECTIONS[k][0] + upwards * DIRECTIONS[k][1]);
  }
  return reaches;
}

/**
 * Corners of the polygon in order, x and y from -1 to 1 in the picture.
 * @param {Float32Array} positions three numbers a vertex
 * @param {View} view
 * @param {number} side of the picture in pixels
 */
export function outline(positions, view, side) {
  if (positions.length > 3 * MOST || positions.length === 0) return SQUARE;
  if (last?.positions !== positions || last.view !== view)
    last = { positions, view, reaches: reachesOf(positions, view) };
  const { reaches } = last;
  if (!reaches) return SQUARE;
  const margin = (2 * MARGIN_PX) / side;
  const corners = new Float32Array(2 * SIDES);
  const sine = Math.sin((2 * Math.PI) / SIDES);
  for (let k = 0; k < SIDES; k += 1) {
    // Intersection of the lines across this direction and the next.
    const next = (k + 1) % SIDES;
    const [a, b] = [reaches[k] + margin, reaches[next] + margin];
    corners[2 * k] = (a * DIRECTIONS[next][1] - b * DIRECTIONS[k][1]) / sine;
    corners[2 * k + 1] = (b * DIRECTIONS[k][0] - a * DIRECTIONS[next][0]) / sine;
  }
  return corners;
}
