/**
 * Breeding and what a person does to single individuals: pick, mate, re-roll, start afresh, favourite, note. Owns who the
 * parents are; knows nothing of hands, keys and drawing.
 *
 * @import { Cell, Individual, Locks, Place, Problem } from "./types.js"
 */
import * as api from "./api.js";
import { flip, flipped, targetSeen } from "./compare.js";
import { holdBack } from "./events.js";
import { genomeOf, programsOnly } from "./genomes.js";
import { locksFor } from "./layers.js";
import { guarded, isBred, putBred, setFirstBreeder, show, wishes } from "./lineage.js";
import { anyLocked } from "./locks.js";
import { startClock } from "./pictures.js";
import { sceneSettled } from "./scene.js";
import {
  FRAMES, announcement, breeding, changeIndividual, forget, generation, individualIn, individualOf, knobs, knobsOpen, largeOf, lineage,
  locks, mate, tell,
} from "./state.js";

/** What a refusal may be about. @type {Place[]} */
const KNOBS = ["mutation", "recombination", "saturation", "energy_limit", "locks"];

/**
 * Where a refused brood is told: at the knob that the server names, else at the frames.
 * @param {Problem} problem
 * @returns {Place}
 */
function placeOf(problem) {
  const named = problem.pointer?.split("/")[1];
  return KNOBS.find((knob) => knob === named) ?? "stage";
}

/** Locks that name positions, which not every genome has. @param {Locks} of */
const namesPositions = (of) => of.layers.length + of.parameters.length > 0 || (!programsOnly.value && of.instructions.length + of.constants.length > 0);

/**
 * What of the locks goes with a brood: those that name something in its first parent. Others are undone, and that is told.
 * @param {string} parent
 * @returns {Promise<Locks|undefined>} none where nothing is locked
 */
async function locksOf(parent) {
  if (namesPositions(locks.value)) {
    const { kept, gone } = locksFor(locks.value, await genomeOf(individualOf(parent) ?? (await api.getIndividual(parent))));
    if (gone.length > 0) {
      locks.value = kept;
      tell("locks", { problem: { title: "Unlocked", status: 422, detail: `The parent does not have: ${gone.join(", ")}.` } });
    }
  }
  return anyLocked(locks.value) ? locks.value : undefined;
}

/** The brood that was asked for last. @type {Promise<void>} */
let making = Promise.resolve();

/**
 * Makes a brood of these parents and shows it. One at a time: a second click while one is made is not a second brood.
 * @param {string[]} parents ids; none for a random start
 */
export async function breed(parents) {
  const of = lineage.value;
  if (!of || breeding.value) return;
  breeding.value = true;
  const wished = wishes();
  startClock();
  forget("stage", ...KNOBS);
  const work = (async () => {
    await sceneSettled();
    const kept = parents.length > 0 ? await locksOf(parents[0]) : undefined;
    // The pictures of the brood are of the scene that the lineage has when it is made, or of a newer one.
    const sceneId = lineage.value?.scene ?? of.scene;
    const made = await api.breed(of.id, { parents, knobs: knobs.value, locks: kept, count: FRAMES });
    if (lineage.value?.id !== of.id) return;
    putBred(made, sceneId);
    // Who has gone somewhere else meanwhile stays there.
    if (wished === wishes()) await show(made.id, "visit");
  })();
  making = work;
  holdBack(work);
  try {
    await work;
  } catch (error) {
    const problem = api.problemOf(error);
    const place = placeOf(problem);
    if (place !== "stage") knobsOpen.value = true;
    const again = () => void (lineage.value?.id === of.id ? breed(parents) : forget(place));
    tell(place, { problem, retry: again });
  } finally {
    breeding.value = false;
  }
}

/**
 * Breeds in a lineage that was just opened or given something, also where a brood of another is being made.
 * @param {string} id of the lineage; nothing is done where it was left meanwhile
 * @param {string[]} parents
 */
export async function breedNext(id, parents) {
  while (breeding.value) await making.catch(() => {});
  if (lineage.value?.id === id) await breed(parents);
}

setFirstBreeder((/** @type {string} */ id) => breedNext(id, []));

/**
 * Breeds from a frame: with the mate where one is marked, else by mutation alone.
 * @param {Cell} cell
 */
export async function pick(cell) {
  const chosen = individualIn(cell);
  if (!chosen) return;
  // What is clicked must be what is seen.
  if (cell === "centre" && targetSeen.value) return void (targetSeen.value = false);
  if (cell === "centre" && flipped.value) return flip(false);
  const other = mate.value;
  await breed(other && other.id !== chosen.id ? [chosen.id, other.id] : [chosen.id]);
}

/** Marks the individual in a frame as the mate, or takes the mark away. @param {Cell} cell */
export function toggleMate(cell) {
  const chosen = individualIn(cell);
  if (!chosen) return;
  mate.value = mate.value?.id === chosen.id ? null : chosen;
  announcement.value = mate.value
    ? `${nameOf(cell)} is the mate. Choose the other parent, or press Escape.`
    : "No mate is marked.";
}

export function cancelMate() {
  if (!mate.value) return;
  mate.value = null;
  announcement.value = "No mate is marked.";
}

/** The same parents once more, with a new seed. */
export function reroll() {
  const of = generation.value;
  // What was brought in or found has no parents: there is nothing to breed from but itself.
  const first = of && !isBred(of) ? largeOf(of) : null;
  return breed(first ? [first.id] : (of?.parents ?? []));
}

/** A random brood. */
export const afresh = () => breed([]);

/** @param {Cell} cell */
export const nameOf = (cell) => (cell === "centre" ? "The centre" : `Frame ${cell + 1}`);

/** @param {Cell} cell */
export async function toggleFavourite(cell) {
  const chosen = individualIn(cell);
  if (chosen) await setFavourite(chosen, !chosen.favourite, nameOf(cell));
}

/** Marks and notes one at a time, so that the last wish is the one that stays. @type {Promise<void>} */
let marking = Promise.resolve();

/** Seen at once, and taken back where the server refuses. @param {Individual} of @param {boolean} favourite @param {string} name */
export function setFavourite(of, favourite, name) {
  changeIndividual(of.id, { favourite });
  const work = async () => {
    try {
      const { version } = await api.patchIndividual(of, { favourite });
      changeIndividual(of.id, { version });
      announcement.value = `${name} is ${favourite ? "a" : "no longer a"} favourite.`;
    } catch (error) {
      changeIndividual(of.id, { favourite: !favourite });
      tell("stage", { problem: api.problemOf(error), retry: () => void setFavourite(of, favourite, name) });
    }
  };
  forget("stage");
  marking = marking.then(work);
  return marking;
}

/** @param {Individual} of @param {string} note */
export function setNote(of, note) {
  const work = async () => {
    const known = individualOf(of.id) ?? of;
    if (known.note === note) return;
    const changed = await api.patchIndividual(known, { note });
    changeIndividual(of.id, { note: changed.note, version: changed.version });
  };
  marking = marking.then(() => guarded("centre", work));
  return marking;
}

/** One at a time, so that the last wish is the one that stays. @type {Promise<void>} */
let keeping = Promise.resolve();

/**
 * Keeps a knob as the lineage's own, for random starts and for the next visit.
 * @param {"saturation"|"energy_limit"} knob
 * @param {number|boolean} value
 */
function keepAsDefault(knob, value) {
  const wished = lineage.value?.id;
  const work = async () => {
    await sceneSettled();
    const of = lineage.value;
    if (!of || of.id !== wished || of[knob] === value) return;
    const changed = await api.patchLineage(of, { [knob]: value });
    if (lineage.value?.id === changed.id) lineage.value = changed;
  };
  keeping = keeping.then(() => guarded(knob, work));
  return keeping;
}

/** @param {number} saturation */
export const keepSaturation = (saturation) => keepAsDefault("saturation", saturation);

/** @param {boolean} on */
export function setEnergyLimit(on) {
  knobs.value = { ...knobs.value, energy_limit: on };
  void keepAsDefault("energy_limit", on);
}
