/**
 * Values and codes of the server in words.
 *
 * @import { Energy, Individual } from "../model.js"
 */

/** @type {Record<string, string>} */
const OPERATORS = {
  random: "drawn at random",
  mutate: "mutation",
  recombine: "recombination",
  adopt: "imported",
  fit: "a search",
};

/** @param {Individual} of */
export const madeBy = (of) =>
  of.operator === "adopt" && of.parents.length > 0
    ? "editing its parent"
    : (OPERATORS[of.operator] ?? of.operator);

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
/** @param {number} power */
const raised = (power) =>
  (power < 0 ? "⁻" : "") +
  [...String(Math.abs(power))].map((digit) => SUPERSCRIPTS[Number(digit)]).join("");

/**
 * A quantity with few digits; very small and very large ones as powers of ten.
 * @param {number|null} value
 * @param {number} [digits]
 */
export function amount(value, digits = 3) {
  if (value === null || !Number.isFinite(value)) return "not finite";
  const rounded = Number(value.toPrecision(digits));
  if (rounded === 0 || (Math.abs(rounded) >= 1e-3 && Math.abs(rounded) < 1e5))
    return String(rounded);
  const power = Number(rounded.toExponential().split("e")[1]);
  const mantissa = Number((rounded / 10 ** power).toPrecision(digits));
  return mantissa === 1 ? `10${raised(power)}` : `${mantissa} × 10${raised(power)}`;
}

/** A power of ten. @param {number} value */
export function decade(value) {
  const power = Math.round(Math.log10(value));
  return power === 0 || power === 1 ? String(10 ** power) : `10${raised(power)}`;
}

/** Largest albedo in words. @param {Energy} of */
export function reflectsInWords({ max_albedo: most, limited }) {
  // Near 1 the second digit shows that the value is exact.
  const words = most !== null && most >= 0.1 && most < 9.95 ? most.toPrecision(2) : amount(most, 2);
  return words + (limited ? " (limited)" : "");
}

/** How the largest albedo was found, and what it means. @param {Energy} of */
export function albedoInWords(of) {
  const parts = [
    `Largest directional albedo: in light at ${Math.round(of.theta_deg)}° from the normal`,
  ];
  if (of.error_bound !== null) parts[0] += `, known to ${amount(100 * of.error_bound, 2)} %`;
  if (of.limited) parts.push(`${amount(of.unlimited_albedo, 2)} without the limit`);
  else if ((of.max_albedo ?? Infinity) > 1)
    parts.push("above 1 the material reflects more light than it receives");
  return `${parts.join("; ")}.`;
}

/** @param {number} bytes */
export const bytesInWords = (bytes) =>
  bytes < 1024
    ? `${bytes} bytes`
    : bytes < 2 ** 20
      ? `${(bytes / 1024).toFixed(0)} KiB`
      : `${(bytes / 2 ** 20).toFixed(1)} MiB`;
