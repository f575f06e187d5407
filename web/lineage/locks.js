/**
 * Locks: parts of the parent that children keep. Instructions and constants are named by position,
 * which stays from parent to child, so locks stay while generations change.
 *
 * @import { Channel, Generation, Genome, Locks } from "../model.js"
 */
import { pageStore } from "../page/store.js";
import { lineageStore, noLocks } from "./store.js";

/** @type {Channel[]} */
export const CHANNELS = ["r", "g", "b"];
/** @type {Record<Channel, string>} */
export const CHANNEL_WORDS = { r: "red", g: "green", b: "blue" };

/** @param {Locks} of */
export const anyLocked = (of) =>
  Object.values(of).some((part) => (Array.isArray(part) ? part.length > 0 : part));

/** @param {number} count @param {string} noun */
const counted = (count, noun) =>
  count === 0 ? [] : [`${count} ${count === 1 ? noun : noun.replace(/^\S+/, "$&s")}`];

/** Locked parts in words; empty where nothing is locked. @param {Locks} of */
export function locksInWords(of) {
  const channels = CHANNELS.filter((channel) => of.channels.includes(channel)).map(
    (channel) => CHANNEL_WORDS[channel],
  );
  const kinds = /** @type {const} */ ([
    ["instructions", "instruction"],
    ["constants", "constant"],
    ["layers", "model"],
    ["parameters", "parameter"],
    ["effects", "effect"],
    ["effect_parameters", "parameter of an effect"],
  ]);
  const lists = kinds.flatMap(([kind, noun]) => counted(of[kind].length, noun));
  return [...lists, ...channels, ...(of.bump ? ["bumps"] : [])].join(", ");
}

/**
 * Adds an item to a list, or removes it if it is in the list.
 * @template T
 * @param {T[]} list
 * @param {T} item
 * @param {(a: T, b: T) => number} by
 */
export const toggled = (list, item, by) =>
  list.includes(item) ? list.filter((one) => one !== item) : [...list, item].sort(by);

/** @param {number} a @param {number} b */
const byNumber = (a, b) => a - b;

function announceLocks() {
  const words = locksInWords(lineageStore.locks.value);
  pageStore.announcement.value = words ? `Locked: ${words}.` : "Nothing is locked.";
}

export function toggleBumpLock() {
  const { bump } = lineageStore.locks.value;
  lineageStore.locks.value = { ...lineageStore.locks.value, bump: !bump };
  announceLocks();
}

/** @param {"instructions"|"constants"|"layers"} kind @param {number} at */
export function toggleLock(kind, at) {
  lineageStore.locks.value = {
    ...lineageStore.locks.value,
    [kind]: toggled(lineageStore.locks.value[kind], at, byNumber),
  };
  announceLocks();
}

/** @param {Locks} of @param {number} layer @param {string} name */
export const hasParameter = (of, layer, name) =>
  of.parameters.some((one) => one.layer === layer && one.name === name);

/** @param {number} layer @param {string} name */
export function toggleParameter(layer, name) {
  const { parameters } = lineageStore.locks.value;
  const others = parameters.filter((one) => one.layer !== layer || one.name !== name);
  lineageStore.locks.value = {
    ...lineageStore.locks.value,
    parameters: others.length < parameters.length ? others : [...others, { layer, name }],
  };
  announceLocks();
}

/** @param {string} kind */
export function toggleEffect(kind) {
  const { effects } = lineageStore.locks.value;
  lineageStore.locks.value = {
    ...lineageStore.locks.value,
    effects: toggled(effects, kind, (a, b) => a.localeCompare(b)),
  };
  announceLocks();
}

/** @param {Locks} of @param {string} effect @param {string} name */
export const hasEffectParameter = (of, effect, name) =>
  of.effect_parameters.some((one) => one.effect === effect && one.name === name);

/** @param {string} effect @param {string} name */
export function toggleEffectParameter(effect, name) {
  const { effect_parameters } = lineageStore.locks.value;
  const others = effect_parameters.filter((one) => one.effect !== effect || one.name !== name);
  const isLocked = others.length < effect_parameters.length;
  lineageStore.locks.value = {
    ...lineageStore.locks.value,
    effect_parameters: isLocked ? others : [...others, { effect, name }],
  };
  announceLocks();
}

/** @param {Channel} channel */
export function toggleChannel(channel) {
  const channels = toggled(
    lineageStore.locks.value.channels,
    channel,
    (a, b) => CHANNELS.indexOf(a) - CHANNELS.indexOf(b),
  );
  lineageStore.locks.value = { ...lineageStore.locks.value, channels };
  announceLocks();
}

export function unlockAll() {
  lineageStore.locks.value = noLocks();
  announceLocks();
}

/**
 * True if every part of a genome is locked.
 * @param {Genome} genome
 * @param {Locks} locks
 */
const isWhollyLocked = ({ instructions, constants, layers, effects }, locks) =>
  locks.instructions.length === instructions &&
  constants.every((constant) => locks.constants.includes(constant)) &&
  layers.every(
    ({ parameters }, at) =>
      locks.layers.includes(at) || parameters.every(({ name }) => hasParameter(locks, at, name)),
  ) &&
  effects.every(
    ({ effect, parameters, images }) =>
      locks.effects.includes(effect) ||
      [...parameters, ...images].every(({ name }) => hasEffectParameter(locks, effect, name)),
  );

/**
 * Reason why the next brood would be identical children, in words; empty where it would not be.
 * @param {{mutation: number, recombination: number, hasMate: boolean, locks: Locks, genome:
 *   Genome|null, recoloured: boolean}} of `genome`: of the centre, null where unknown;
 *   `recoloured`: true if children get colours of a painting
 */
export function onlyTwinsInWords({ mutation, recombination, hasMate, locks, genome, recoloured }) {
  if (locks.channels.length === CHANNELS.length)
    return "All channels are locked: children would be identical. Unlock one.";
  if (genome && isWhollyLocked(genome, locks))
    return "Everything is locked: children would be identical. Unlock a part.";
  if (recoloured && !hasEffectParameter(locks, "light", "palette") && !locks.effects.includes("light"))
    return "";
  if (mutation === 0 && !hasMate)
    return "Mutation 0 gives 20 identical children: raise it or mark a mate.";
  if (mutation === 0 && recombination === 0)
    return "Mutation and recombination 0 give 20 identical children: raise one.";
  return "";
}

/**
 * Number of twins that locks have caused in a brood, in words; empty if there are none.
 * @param {Generation} of
 */
export function twinsInWords(of) {
  const twins = of.individuals.filter((one) => one.twin).length;
  if (twins === 0 || !of.locks || !anyLocked(of.locks)) return "";
  return `${twins} identical ${twins === 1 ? "child" : "children"}: the lock covers almost everything`;
}
