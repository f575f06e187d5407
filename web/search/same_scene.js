/**
 * Comparison of two scenes by their content.
 *
 * @import { Scene } from "../model.js"
 */

/**
 * True if two scenes render alike; the order of their fields does not matter.
 * @param {Scene} a
 * @param {Scene} b
 */
export function sameScene(a, b) {
  const { id: _, ...one } = a;
  const { id: __, ...other } = b;
  return canonical(one) === canonical(other);
}

/** @param {unknown} of @returns {string} */
function canonical(of) {
  if (Array.isArray(of)) return `[${of.map(canonical).join()}]`;
  if (typeof of !== "object" || of === null) return JSON.stringify(of) ?? "null";
  const fields = Object.entries(of)
    .filter(([, value]) => value !== undefined && value !== null)
    .sort(([a], [b]) => (a < b ? -1 : 1));
  return `{${fields.map(([name, value]) => `${JSON.stringify(name)}:${canonical(value)}`).join()}}`;
}
