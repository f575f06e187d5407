/**
 * Geometry of the polar plot: the angle from the normal goes round, reflectance goes outward, and
 * light comes from the left.
 *
 * @import { Curve, Plane } from "../model.js"
 */

/**
 * @typedef {{color: "luminance"|"r"|"g"|"b", cosine: boolean}} Quantity
 *
 * @typedef {{log: boolean, low: number, high: number, rings: number[]}} Axis `low` is at the
 *   middle, `high` at the rim, `rings` are values between.
 */

/** Weights of the channels. Rec. 709, as for the server's luminance. */
const WEIGHTS = { luminance: [0.2126, 0.7152, 0.0722], r: [1, 0, 0], g: [0, 1, 0], b: [0, 0, 1] };
/** Decades of a logarithmic axis, at most: more would squeeze bright values at the rim. */
const DECADES = 5;
/** Rings of a linear axis, at most. */
const RINGS = 4;

/**
 * Values of a curve at the outgoing angles of its plane; NaN where missing.
 * @param {Plane} plane
 * @param {Curve} curve
 * @param {Quantity} quantity
 */
export function valuesOf(plane, curve, { color, cosine }) {
  const weights = WEIGHTS[color];
  return plane.theta_o_deg.map((theta_o, at) => {
    let sum = 0;
    for (const channel of [0, 1, 2])
      if (weights[channel] > 0) sum += weights[channel] * (curve.f[channel][at] ?? Number.NaN);
    return cosine ? sum * Math.cos((theta_o * Math.PI) / 180) : sum;
  });
}

/** Rounds up to the next of 1, 2, 5, 10, ... @param {number} value */
function roundUp(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  const factor = [1, 2, 5, 10].find((one) => one * decade >= value * (1 - 1e-9)) ?? 10;
  return factor * decade;
}

/** Axis that holds all values. @param {number[]} values @param {boolean} log @returns {Axis} */
export function axisFor(values, log) {
  const positive = values.filter((value) => Number.isFinite(value) && value > 0);
  if (positive.length === 0) return { log: false, low: 0, high: 1, rings: [1] };
  const largest = Math.max(...positive);
  if (!log) {
    const step = roundUp(largest / RINGS);
    const count = Math.ceil(largest / step - 1e-9);
    return {
      log,
      low: 0,
      high: count * step,
      rings: [...Array(count).keys()].map((at) => Number(((at + 1) * step).toPrecision(6))),
    };
  }
  const top = Math.ceil(Math.log10(largest) - 1e-9);
  const bottom = Math.min(
    top - 1,
    Math.max(top - DECADES, Math.floor(Math.log10(Math.min(...positive)) + 1e-9)),
  );
  return {
    log,
    low: 10 ** bottom,
    high: 10 ** top,
    rings: [...Array(top - bottom).keys()].map((at) => Number(`1e${bottom + at + 1}`)),
  };
}

/** Radius of a value: 0 at the middle, 1 at the rim. @param {Axis} axis @param {number} value */
export function radiusOf({ log, low, high }, value) {
  const share = log ? Math.log(value / low) / Math.log(high / low) : value / high;
  return Math.max(0, Math.min(1, share));
}

/**
 * Point at an angle from the normal, which points up; x to the right, y down.
 * @param {number} theta_deg
 * @param {number} radius
 * @returns {[number, number]}
 */
export function pointAt(theta_deg, radius) {
  const theta = (theta_deg * Math.PI) / 180;
  return [radius * Math.sin(theta), -radius * Math.cos(theta)];
}

/**
 * SVG path of a curve, interrupted where values are missing.
 * @param {number[]} thetas_deg
 * @param {number[]} values
 * @param {Axis} axis
 * @param {number} rim
 */
export function pathOf(thetas_deg, values, axis, rim) {
  let path = "";
  let pen = "M";
  for (const [at, value] of values.entries()) {
    if (!Number.isFinite(value)) {
      pen = "M";
      continue;
    }
    const [x, y] = pointAt(thetas_deg[at], rim * radiusOf(axis, value));
    path += `${pen}${x.toFixed(2)} ${y.toFixed(2)}`;
    pen = "L";
  }
  return path;
}

/**
 * Maximum of a curve.
 * @param {number[]} thetas_deg
 * @param {number[]} values
 * @returns {{theta_deg: number, value: number}|null}
 */
export function peakOf(thetas_deg, values) {
  let best = -1;
  for (const [at, value] of values.entries())
    if (Number.isFinite(value) && (best < 0 || value > values[best])) best = at;
  return best < 0 ? null : { theta_deg: thetas_deg[best], value: values[best] };
}
