/**
 * Words for what the server says in codes. Owns the words; knows nothing of where they stand.
 *
 * @import { Individual } from "../types.js"
 */

/** @type {Record<string, string>} */
const OPERATORS = { random: "drawn at random", mutate: "mutation", recombine: "recombination", adopt: "brought in" };

/** @param {Individual} of */
export const madeBy = (of) => OPERATORS[of.operator] ?? of.operator;
