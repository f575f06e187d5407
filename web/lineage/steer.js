/**
 * Steering: properties that children keep or change, compared with their parent.
 *
 * @import { Genome, Steer } from "../model.js"
 */

import { isPainted } from "./layers.js";

/**
 * Choices in the order of the page, with their names and tool tips.
 * @type {{word: Steer, name: string, title: string}[]}
 */
export const STEERS = [
  { word: "keep-colour", name: "keep colour", title: "Children keep the colour of their parent" },
  { word: "only-gloss", name: "only gloss", title: "Only highlights change: colour and pattern stay" },
  { word: "warmer", name: "warmer", title: "Children are more red, orange or yellow" },
  { word: "cooler", name: "cooler", title: "Children are more green or blue" },
  { word: "rougher", name: "rougher", title: "Highlights become wider and weaker" },
  { word: "glossier", name: "glossier", title: "Highlights become narrower and stronger" },
  { word: "more-pattern", name: "more pattern", title: "Children differ more from place to place" },
  { word: "less-pattern", name: "less pattern", title: "Children differ less from place to place" },
];

/**
 * Words that exclude each other, as on the server.
 * @type {[Steer, Steer][]}
 */
const CONTRADICTIONS = [
  ["warmer", "cooler"],
  ["rougher", "glossier"],
  ["more-pattern", "less-pattern"],
  ["keep-colour", "warmer"],
  ["keep-colour", "cooler"],
  ["only-gloss", "warmer"],
  ["only-gloss", "cooler"],
  ["only-gloss", "more-pattern"],
  ["only-gloss", "less-pattern"],
];

/** @param {Steer} one @param {Steer} other */
const contradict = (one, other) =>
  CONTRADICTIONS.some((pair) => one !== other && pair.includes(one) && pair.includes(other));

/**
 * Returns the words with one turned on or off. A word that is turned on removes those that it
 * contradicts.
 * @param {readonly Steer[]} words
 * @param {Steer} word
 * @param {boolean} on
 * @returns {Steer[]}
 */
export function withSteer(words, word, on) {
  const others = words.filter((one) => one !== word && !(on && contradict(one, word)));
  return on ? [...others, word] : others;
}

/** @param {Steer} word */
const isOfPattern = (word) => word === "more-pattern" || word === "less-pattern";

/**
 * Reason why a word has no effect on the next brood, in words; empty if it has one.
 * @param {Steer} word
 * @param {{homogeneous: boolean, genome: Genome|null}} of `homogeneous`: switch of the brood;
 *   `genome`: of the centre, null where unknown
 */
export function noSteerInWords(word, { homogeneous, genome }) {
  if (isPainted(genome)) return "Painted materials are not steered";
  if (!isOfPattern(word)) return "";
  if (homogeneous) return "Homogeneous children have no pattern";
  if (genome?.instructions === 0) return "Models have no pattern";
  return "";
}

/** Words that steered a brood, for people. @param {readonly Steer[]|undefined} words */
export const steerInWords = (words) =>
  (words ?? []).map((word) => STEERS.find((one) => one.word === word)?.name ?? word).join(", ");
