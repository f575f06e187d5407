/**
 * Words for what the server says in codes. Owns the words; knows nothing of where they stand.
 *
 * @import { Energy, Individual } from "../types.js"
 */

/** @type {Record<string, string>} */
const OPERATORS = { random: "drawn at random", mutate: "mutation", recombine: "recombination", adopt: "brought in", fit: "a search" };

/** @param {Individual} of */
export const madeBy = (of) => OPERATORS[of.operator] ?? of.operator;

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
/** @param {number} power */
const raised = (power) => (power < 0 ? "⁻" : "") + [...String(Math.abs(power))].map((digit) => SUPERSCRIPTS[Number(digit)]).join("");

/** A quantity with few digits, very small and very large ones by a power of ten. @param {number|null} value @param {number} [digits] */
export function amount(value, digits = 3) {
  if (value === null || !Number.isFinite(value)) return "not finite";
  const rounded = Number(value.toPrecision(digits));
  if (rounded === 0 || (Math.abs(rounded) >= 1e-3 && Math.abs(rounded) < 1e5)) return String(rounded);
  const power = Number(rounded.toExponential().split("e")[1]);
  const mantissa = Number((rounded / 10 ** power).toPrecision(digits));
  return mantissa === 1 ? `10${raised(power)}` : `${mantissa} × 10${raised(power)}`;
}

/** A power of ten, as short for a thousandth as for a millionth. @param {number} value */
export function decade(value) {
  const power = Math.round(Math.log10(value));
  return power === 0 || power === 1 ? String(10 ** power) : `10${raised(power)}`;
}

/** The most that is reflected of the light from any direction. @param {Energy} of */
export function reflectsInWords({ max_albedo: most, limited }) {
  // Near 1 the second digit says that it was looked at.
  const words = most !== null && most >= 0.1 && most < 9.95 ? most.toPrecision(2) : amount(most, 2);
  return words + (limited ? " (limited)" : "");
}

/** How that was found, and what it means. @param {Energy} of */
export function albedoInWords(of) {
  const parts = [`Largest directional albedo: in light at ${Math.round(of.theta_deg)}° from the normal`];
  if (of.error_bound !== null) parts[0] += `, known to ${amount(100 * of.error_bound, 2)} %`;
  if (of.limited) parts.push(`${amount(of.unlimited_albedo, 2)} without the limit`);
  else if ((of.max_albedo ?? Infinity) > 1) parts.push("above 1 it gives back more light than it receives");
  return `${parts.join("; ")}.`;
}
