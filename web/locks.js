/**
 * What children of the open lineage keep of their parent: instructions and constants by position, and whole channels. Owns
 * the changing of locks and their words; positions stay from parent to child, so locks stay while generations come and go.
 *
 * @import { Channel, Generation, Locks } from "./types.js"
 */
import { announcement, locks } from "./state.js";

/** @type {Channel[]} */
export const CHANNELS = ["r", "g", "b"];
/** @type {Record<Channel, string>} */
export const CHANNEL_WORDS = { r: "red", g: "green", b: "blue" };

/** @param {Locks} of */
export const anyLocked = (of) => of.instructions.length + of.constants.length + of.channels.length > 0;

/** @param {number} count @param {string} noun */
const counted = (count, noun) => (count === 0 ? [] : [`${count} ${noun}${count === 1 ? "" : "s"}`]);

/** What is locked, in words; empty where nothing is. @param {Locks} of */
export function locksInWords(of) {
  const channels = CHANNELS.filter((channel) => of.channels.includes(channel)).map((channel) => CHANNEL_WORDS[channel]);
  return [...counted(of.instructions.length, "instruction"), ...counted(of.constants.length, "constant"), ...channels].join(", ");
}

/**
 * A list with an item more, or without it where it is there already.
 * @template T
 * @param {T[]} list
 * @param {T} item
 * @param {(a: T, b: T) => number} by
 */
export const toggled = (list, item, by) => (list.includes(item) ? list.filter((one) => one !== item) : [...list, item].sort(by));

/** @param {number} a @param {number} b */
const byNumber = (a, b) => a - b;

function tellLocks() {
  const words = locksInWords(locks.value);
  announcement.value = words ? `Locked: ${words}.` : "Nothing is locked.";
}

/** @param {"instructions"|"constants"} kind @param {number} at */
export function toggleLock(kind, at) {
  locks.value = { ...locks.value, [kind]: toggled(locks.value[kind], at, byNumber) };
  tellLocks();
}

/** @param {Channel} channel */
export function toggleChannel(channel) {
  const channels = toggled(locks.value.channels, channel, (a, b) => CHANNELS.indexOf(a) - CHANNELS.indexOf(b));
  locks.value = { ...locks.value, channels };
  tellLocks();
}

export function unlockAll() {
  locks.value = { instructions: [], constants: [], channels: [] };
  tellLocks();
}

/** What locks have done to a brood, where it is more than was wanted; empty otherwise. @param {Generation} of */
export function twinsInWords(of) {
  const twins = of.individuals.filter((one) => one.twin).length;
  if (twins === 0 || !of.locks || !anyLocked(of.locks)) return "";
  return `${twins} ${twins === 1 ? "twin" : "twins"}: much is locked`;
}
