/**
 * A genome's text as lines to be looked at: its head, its constants, its models, its instructions. Pure functions on text; the
 * grammar is the server's, and what is no constant, of no model and no instruction counts as head.
 *
 * @import { Channel, Inspection, Layer, Locks } from "./types.js"
 */
import { genomeIn, isOfLayer } from "./layers.js";

/**
 * @typedef {{index: number, text: string}} Constant
 * @typedef {{index: number, text: string, live: boolean, channels: string, constants: number[]}} Instruction
 * @typedef {{head: string[], constants: Constant[], layers: Layer[], instructions: Instruction[]}} Listing
 */

/** Indices of the constants that an instruction names. @param {string} text */
const constantsIn = (text) => [...new Set([...text.matchAll(/\bC(\d+)/g)].map((found) => Number(found[1])))];

/** @param {Pick<Inspection, "source"|"counts"|"live"|"channels">} of @returns {Listing} */
export function listingOf({ source, counts, live, channels }) {
  const lines = source.trimEnd().split("\n");
  // All the rest is head where there is no instruction: slice(-0) would be everything.
  const begin = lines.length - counts.instructions;
  const instructions = lines.slice(begin).map((text, index) => ({ index, text, live: live[index], channels: channels[index], constants: constantsIn(text) }));
  const head = [];
  const constants = [];
  for (const line of lines.slice(0, begin)) {
    const constant = /^\.const C(\d+)\s+(.*)$/.exec(line);
    if (constant) constants.push({ index: Number(constant[1]), text: constant[2] });
    else if (!isOfLayer(line)) head.push(line);
  }
  return { head, constants, layers: genomeIn(source).layers, instructions };
}

/** The constants that live instructions read. @param {Listing} of */
export const readConstants = (of) => new Set(of.instructions.filter((one) => one.live).flatMap((one) => one.constants));

/** The locked channels that keep an instruction as it is. @param {Instruction} of @param {Locks} locks @returns {Channel[]} */
export const heldBy = (of, locks) => locks.channels.filter((channel) => of.live && of.channels.includes(channel));

/** The locked channels that keep each constant. @param {Listing} of @param {Locks} locks @returns {Map<number, Set<Channel>>} */
export function heldConstants(of, locks) {
  const held = new Map();
  for (const instruction of of.instructions) {
    const by = heldBy(instruction, locks);
    if (by.length === 0) continue;
    for (const constant of instruction.constants) held.set(constant, new Set([...(held.get(constant) ?? []), ...by]));
  }
  return held;
}
