/**
 * What children of the open lineage keep of their parent: instructions and constants by position, models and their parameters,
 * and whole channels. Owns the changing of locks and their words; positions stay from parent to child, so locks stay while
 * generations come and go.
 *
 * @import { Channel, Generation, Locks } from "./types.js"
 */
import { announcement, locks, noLocks } from "./state.js";

/** @type {Channel[]} */
export const CHANNELS = ["r", "g", "b"];
/** @type {Record<Channel, string>} */
export const CHANNEL_WORDS = { r: "red", g: "green", b: "blue" };

/** @param {Locks} of */
export const anyLocked = (of) => Object.values(of).some((list) => list.length > 0);

/** @param {number} count @param {string} noun */
const counted = (count, noun) => (count === 0 ? [] : [`${count} ${noun}${count === 1 ? "" : "s"}`]);

/** What is locked, in words; empty where nothing is. @param {Locks} of */
export function locksInWords(of) {
  const channels = CHANNELS.filter((channel) => of.channels.includes(channel)).map((channel) => CHANNEL_WORDS[channel]);
  const kinds = /** @type {const} */ ([["instructions", "instruction"], ["constants", "constant"], ["layers", "model"], ["parameters", "parameter"]]);
  return [...kinds.flatMap(([kind, noun]) => counted(of[kind].length, noun)), ...channels].join(", ");
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

/** @param {"instructions"|"constants"|"layers"} kind @param {number} at */
export function toggleLock(kind, at) {
  locks.value = { ...locks.value, [kind]: toggled(locks.value[kind], at, byNumber) };
  tellLocks();
}

/** @param {Locks} of @param {number} layer @param {string} name */
export const hasParameter = (of, layer, name) => of.parameters.some((one) => one.layer === layer && one.name === name);

/** @param {number} layer @param {string} name */
export function toggleParameter(layer, name) {
  const { parameters } = locks.value;
  const others = parameters.filter((one) => one.layer !== layer || one.name !== name);
  locks.value = { ...locks.value, parameters: others.length < parameters.length ? others : [...others, { layer, name }] };
  tellLocks();
}

/** @param {Channel} channel */
export function toggleChannel(channel) {
  const channels = toggled(locks.value.channels, channel, (a, b) => CHANNELS.indexOf(a) - CHANNELS.indexOf(b));
  locks.value = { ...locks.value, channels };
  tellLocks();
}

export function unlockAll() {
  locks.value = noLocks();
  tellLocks();
}

/** What locks have done to a brood, where it is more than was wanted; empty otherwise. @param {Generation} of */
export function twinsInWords(of) {
  const twins = of.individuals.filter((one) => one.twin).length;
  if (twins === 0 || !of.locks || !anyLocked(of.locks)) return "";
  return `${twins} ${twins === 1 ? "twin" : "twins"}: much is locked`;
}
