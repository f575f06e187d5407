/**
 * Splits a genome's text into lines to show: head, constants, models, instructions. Lines of no
 * other kind count as head.
 *
 * @import { Channel, Inspection, Layer, Locks } from "../model.js"
 */
import { genomeIn, isOfLayer } from "./layers.js";

/**
 * @typedef {{index: number, text: string}} Constant
 *
 * @typedef {{index: number, text: string, live: boolean, channels: string, constants:
 *   number[]}} Instruction
 *
 * @typedef {{head: string[], constants: Constant[], layers: Layer[], instructions:
 *   Instruction[]}} Listing
 */

/** Indices of the constants that an instruction reads. @param {string} text */
const constantsIn = (text) => [
  ...new Set([...text.matchAll(/\bC(\d+)/g)].map((found) => Number(found[1]))),
];

/** @param {Pick<Inspection, "source"|"counts"|"live"|"channels">} of @returns {Listing} */
export function listingOf({ source, counts, live, channels }) {
  const lines = source.trimEnd().split("\n");
  // Without instructions all lines are head; slice(-0) would take them all for instructions.
  const begin = lines.length - counts.instructions;
  const instructions = lines
    .slice(begin)
    .map((text, index) => ({
      index,
      text,
      live: live[index],
      channels: channels[index],
      constants: constantsIn(text),
    }));
  const head = [];
  const constants = [];
  for (const line of lines.slice(0, begin)) {
    const constant = /^\.const C(\d+)\s+(.*)$/.exec(line);
    if (constant) constants.push({ index: Number(constant[1]), text: constant[2] });
    else if (!isOfLayer(line)) head.push(line);
  }
  return { head, constants, layers: genomeIn(source).layers, instructions };
}

/** Indices of constants that live instructions read. @param {Listing} of */
export const readConstants = (of) =>
  new Set(of.instructions.filter((one) => one.live).flatMap((one) => one.constants));

/**
 * Locked channels that keep an instruction.
 * @param {Instruction} of
 * @param {Locks} locks
 * @returns {Channel[]}
 */
export const channelsKeeping = (of, locks) =>
  locks.channels.filter((channel) => of.live && of.channels.includes(channel));

/**
 * Locked channels that keep each constant.
 * @param {Listing} of
 * @param {Locks} locks
 * @returns {Map<number, Set<Channel>>}
 */
export function constantsKept(of, locks) {
  const held = new Map();
  for (const instruction of of.instructions) {
    const by = channelsKeeping(instruction, locks);
    if (by.length === 0) continue;
    for (const constant of instruction.constants)
      held.set(constant, new Set([...(held.get(constant) ?? []), ...by]));
  }
  return held;
}
