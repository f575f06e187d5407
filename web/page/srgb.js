/**
 * Colours of the screen, `#rrggbb`, and linear light.
 *
 * @import { Vec3 } from "../model.js"
 */

/** @param {number} code 0 to 255 @returns {number} 0 to 1 */
function linear(code) {
  const c = code / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

/** @param {number} x 0 to 1 @returns {number} 0 to 255 */
const encoded = (x) =>
  Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));

/** @param {string} color @returns {Vec3} linear, each 0 to 1 */
export function linearOf(color) {
  const code = (/** @type {number} */ at) => linear(Number.parseInt(color.slice(at, at + 2), 16));
  return [code(1), code(3), code(5)];
}

/** @param {number[]} channels linear, each 0 to 1 */
export const colorCode = (channels) =>
  `#${channels.map((x) => encoded(x).toString(16).padStart(2, "0")).join("")}`;
