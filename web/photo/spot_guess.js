/**
 * First guess of the spot that the light makes on a ball. Pure functions.
 *
 * The shading of a matt ball is fitted to the picture: brightness = normal times a vector, without
 * the pixels that are much brighter. If some are, they are a highlight, and the spot is its middle;
 * otherwise the ball is matt, and the spot is where its normal is along the vector.
 *
 * @import { Vec3 } from "../model.js"
 * @import { Extent } from "../live/camera.js"
 * @import { Surface } from "./highlight.js"
 * @import { Grey } from "./pixels.js"
 * @import { Area, Circle, PhotoCamera, Point } from "./placement.js"
 */
import { solve3 } from "./circle_guess.js";
import { angleBetween, lightFrom, spotOf } from "./highlight.js";
import { dot, surfaceAt } from "./placement.js";

/** Part of the radius in which pixels are read: the rim is blurred and often lit from behind. */
const INSIDE = 0.93;
/** Number of pixels read across the ball. */
const ACROSS = 120;
/** Brightness above that of a matt ball, relative to the largest, from which it is a highlight. */
const EXCESS = 0.2;
/** Brightness of a matt ball, relative to the largest, from which its light is known. */
const BRIGHT = 0.15;
/** Angle to that light within which a highlight is likely to be of the same light, in degrees. */
const SPREAD_DEG = 20;
/** Share of the ball that a highlight covers at most. */
const LARGEST_SHARE = 0.2;
/** Rounds in which pixels that do not fit are left out. */
const ROUNDS = 8;

/** @typedef {{at: Point, normal: Vec3, value: number, clipped: boolean}} Reading */

/**
 * Reads the brightness over the ball: means of squares, which are the same number in large pictures
 * and small ones.
 * @param {Grey} grey
 * @param {Circle} circle
 * @param {(at: Point) => Vec3|null} normalAt
 */
function readings(grey, circle, normalAt) {
  const step = Math.max(1, Math.round((2 * circle.radius) / ACROSS));
  /** @type {Reading[]} */
  const read = [];
  const from = (/** @type {number} */ middle) => Math.max(0, Math.floor(middle - circle.radius));
  const [right, below] = [circle.x + circle.radius, circle.y + circle.radius];
  for (let y = from(circle.y); y + step <= Math.min(grey.height, below); y += step) {
    for (let x = from(circle.x); x + step <= Math.min(grey.width, right); x += step) {
      const at = { x: x + step / 2, y: y + step / 2 };
      if (Math.hypot(at.x - circle.x, at.y - circle.y) > INSIDE * circle.radius) continue;
      const normal = normalAt(at);
      if (!normal) continue;
      let [sum, clipped] = [0, 0];
      for (let row = y; row < y + step; row += 1) {
        for (let column = x; column < x + step; column += 1) {
          sum += grey.values[row * grey.width + column];
          clipped += grey.clipped[row * grey.width + column];
        }
      }
      read.push({ at, normal, value: sum / step ** 2, clipped: clipped > 0 });
    }
  }
  return { read, step };
}

/**
 * Vector whose product with the normal is the brightness of a matt ball, fitted to the lit pixels
 * that are not much brighter; null if too few are lit.
 * @param {Reading[]} read
 * @param {number} largest
 * @returns {Vec3|null}
 */
function mattLight(read, largest) {
  let used = read.filter(({ value, clipped }) => !clipped && value > 0.03 * largest);
  /** @type {Vec3|null} */
  let light = null;
  for (let round = 0; round < ROUNDS; round += 1) {
    if (used.length < 20) return light;
    const m = [0, 0, 0, 0, 0, 0];
    const v = [0, 0, 0];
    for (const { normal: [x, y, z], value } of used) {
      [x * x, x * y, x * z, y * y, y * z, z * z].forEach((product, at) => (m[at] += product));
      [x, y, z].forEach((part, at) => (v[at] += part * value));
    }
    const solved = solve3(m, v);
    if (!solved) return light;
    light = /** @type {Vec3} */ (solved);
    const fit = light;
    const errors = used.map(({ normal, value }) => Math.abs(value - dot(normal, fit)));
    const typical = errors.sort((a, b) => a - b)[Math.floor(0.6 * errors.length)];
    const most = Math.max(0.02 * largest, 2.5 * typical);
    used = read.filter(({ normal, value, clipped }) => {
      const expected = dot(normal, fit);
      return !clipped && expected > 0 && Math.abs(value - expected) < most;
    });
  }
  return light;
}

/**
 * The highlight: middle of the connected pixels around the one that is most too bright; null if
 * there is none, or it is no spot.
 * @param {Reading[]} read
 * @param {(of: Reading) => number} excess
 * @param {(of: Reading) => number} likely weight of a pixel among several highlights
 * @param {number} largest
 * @param {number} step between readings, in pixels
 * @returns {Point|null}
 */
function highlight(read, excess, likely, largest, step) {
  let most = read[0];
  let best = 0;
  for (const one of read) {
    if (excess(one) < EXCESS * largest) continue;
    const score = excess(one) * likely(one);
    if (score > best) [most, best] = [one, score];
  }
  if (excess(most) < EXCESS * largest) return null;
  const threshold = 0.5 * excess(most);
  /** @param {Point} at */
  const key = ({ x, y }) => `${Math.round(x / step)} ${Math.round(y / step)}`;
  const left = new Map(
    read.filter((one) => excess(one) >= threshold).map((one) => [key(one.at), one]),
  );
  const queue = [most];
  left.delete(key(most.at));
  let [x, y, weight, count] = [0, 0, 0, 0];
  for (let one = queue.pop(); one; one = queue.pop()) {
    const own = excess(one);
    [x, y, weight, count] = [x + own * one.at.x, y + own * one.at.y, weight + own, count + 1];
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      const beside = key({ x: one.at.x + dx * step, y: one.at.y + dy * step });
      const next = left.get(beside);
      if (!next) continue;
      left.delete(beside);
      queue.push(next);
    }
  }
  return count > LARGEST_SHARE * read.length ? null : { x: x / weight, y: y / weight };
}

/**
 * Guesses the spot, and whether the ball is glossy or matt; null if the ball is dark.
 * @param {Grey} grey
 * @param {Circle} circle
 * @param {PhotoCamera} camera
 * @param {Area} crop
 * @param {Extent} extent
 * @returns {{spot: Point, surface: Surface}|null}
 */
export function guessSpot(grey, circle, camera, crop, extent) {
  const { read, step } = readings(
    grey,
    circle,
    (at) => surfaceAt(at, camera, crop, extent)?.normal ?? null,
  );
  let largest = 0;
  for (const { value } of read) largest = Math.max(largest, value);
  if (read.length < 50 || largest < 1e-4) return null;
  const light = mattLight(read, largest);
  /** @param {Reading} of */
  const excess = ({ normal, value }) => value - Math.max(0, light ? dot(normal, light) : 0);
  const seemsFrom = light && Math.hypot(...light) > BRIGHT * largest ? light : null;
  /** @param {Reading} of */
  const likely = ({ at, normal }) => {
    const own = lightFrom(surfaceAt(at, camera, crop, extent), "glossy");
    if (!own || !seemsFrom) return 1;
    return 0.02 + Math.exp(-((angleBetween(own, seemsFrom) / SPREAD_DEG) ** 2));
  };
  const spot = highlight(read, excess, likely, largest, step);
  if (spot) return { spot, surface: "glossy" };
  if (!light) return null;
  const seen = spotOf(light, "matt", camera, crop, extent) ?? rim(light, circle);
  return { spot: seen, surface: "matt" };
}

/**
 * Point near the rim on the side of a light behind the ball.
 * @param {Vec3} light
 * @param {Circle} circle
 */
function rim([x, y], circle) {
  const length = Math.hypot(x, y) || 1;
  return {
    x: circle.x + (INSIDE * circle.radius * x) / length,
    y: circle.y - (INSIDE * circle.radius * y) / length,
  };
}
