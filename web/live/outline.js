/**
 * A polygon around the object as the camera sees it: what lies outside it is neither lit nor shaded. A sphere leaves a fifth
 * of its square empty, most things more.
 *
 * @import { View } from "./view.js"
 */

/** Sides of the polygon; around a circle its area is 0.6 % too large. */
export const SIDES = 24;
const DIRECTIONS = Array.from({ length: SIDES }, (_, k) => [Math.cos((2 * Math.PI * k) / SIDES), Math.sin((2 * Math.PI * k) / SIDES)]);
/** With more vertices than this, looking at each of them takes longer than shading nothing. */
const MOST = 200_000;
/** Coverage reaches so many pixels beyond the object, and rounding a little further. */
const MARGIN_PX = 2;

/** All of the square. */
const SQUARE = new Float32Array([-1, -1, 1, -1, 1, 1, -1, 1]);

/**
 * A polygon as triangles that are as thick as can be: software shades pixels between two of them twice.
 * @param {Float32Array} corners
 */
export function triangles(corners) {
  const found = [];
  let left = Array.from({ length: corners.length / 2 }, (_, k) => k);
  while (left.length > 2) {
    // Every other corner is cut off.
    for (let k = 0; k + 1 < left.length; k += 2) found.push(left[k], left[k + 1], left[(k + 2) % left.length]);
    left = left.filter((_, k) => k % 2 === 0);
  }
  return new Float32Array(found.flatMap((k) => [corners[2 * k], corners[2 * k + 1]]));
}

/** What was looked at last: one view is drawn into several pictures. @type {{positions: Float32Array, view: View, reaches: Float64Array|null}|null} */
let last = null;

/**
 * How far the object reaches in each direction of the picture; null where it may be seen anywhere.
 * @param {Float32Array} positions
 * @param {View} view
 * @returns {Float64Array|null}
 */
function reachesOf(positions, view) {
  const { eye, right, up, forward, half, near } = view;
  const reaches = new Float64Array(SIDES).fill(Number.NEGATIVE_INFINITY);
  for (let at = 0; at < positions.length; at += 3) {
    const [x, y, z] = [positions[at] - eye[0], positions[at + 1] - eye[1], positions[at + 2] - eye[2]];
    const depth = x * forward[0] + y * forward[1] + z * forward[2];
    // What is beside or behind the eye may be seen anywhere.
    if (!view.parallel && depth < near) return null;
    const scale = 1 / (half * (view.parallel ? 1 : depth));
    const across = (x * right[0] + y * right[1] + z * right[2]) * scale;
    const upwards = (x * up[0] + y * up[1] + z * up[2]) * scale;
    for (let k = 0; k < SIDES; k += 1) reaches[k] = Math.max(reaches[k], across * DIRECTIONS[k][0] + upwards * DIRECTIONS[k][1]);
  }
  return reaches;
}

/**
 * The corners of the polygon in their order, x and y from -1 to 1 in the picture.
 * @param {Float32Array} positions three numbers a vertex
 * @param {View} view
 * @param {number} side of the picture in pixels
 */
export function outline(positions, view, side) {
  if (positions.length > 3 * MOST || positions.length === 0) return SQUARE;
  if (last?.positions !== positions || last.view !== view) last = { positions, view, reaches: reachesOf(positions, view) };
  const { reaches } = last;
  if (!reaches) return SQUARE;
  const margin = (2 * MARGIN_PX) / side;
  const corners = new Float32Array(2 * SIDES);
  const sine = Math.sin((2 * Math.PI) / SIDES);
  for (let k = 0; k < SIDES; k += 1) {
    // Where the lines across this direction and the next meet.
    const next = (k + 1) % SIDES;
    const [a, b] = [reaches[k] + margin, reaches[next] + margin];
    corners[2 * k] = (a * DIRECTIONS[next][1] - b * DIRECTIONS[k][1]) / sine;
    corners[2 * k + 1] = (b * DIRECTIONS[k][0] - a * DIRECTIONS[next][0]) / sine;
  }
  return corners;
}
