/**
 * Breeding and marks on individuals: pick, mate, re-roll, random brood, favourite, note.
 *
 * @import { Cell, Individual, Lineage, Locks, Place, Problem } from "../model.js"
 */
import { problemOf } from "../api/request.js";
import * as api from "../api/routes.js";
import { flip } from "../compare/ab.js";
import { compareStore } from "../compare/store.js";
import { clearProblems, guarded, showProblem } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { sceneSettled } from "../scene/edit.js";
import { makeChild, presentEdit } from "./edit.js";
import { isBred, navigationCount, show, storeBred } from "./generations.js";
import { genomeOf } from "./genomes.js";
import { individualIn, shownIndividual, updateIndividual } from "./individuals.js";
import { isPainted, locksFor } from "./layers.js";
import { anyLocked } from "./locks.js";
import { makeGeneration, whenNoneIsMade } from "./making.js";
import { startClock } from "./pictures.js";
import { FRAMES, centreOf, lineageStore } from "./store.js";

/** Knobs and locks that a refusal may name. @type {Place[]} */
const KNOBS = [
  "mutation",
  "recombination",
  "saturation",
  "energy_limit",
  "steer",
  "painting",
  "locks",
];

/**
 * Place to show a refused brood: at the knob that the server names, else at the frames.
 * @param {Problem} problem
 * @returns {Place}
 */
function problemPlace(problem) {
  const named = problem.pointer?.split("/")[1];
  return KNOBS.find((knob) => knob === named) ?? "stage";
}

/** True if locks name positions that the parent's genome may not have. @param {Locks} of */
const namesPositions = (of) =>
  of.layers.length + of.parameters.length > 0 ||
  of.effects.length + of.effect_parameters.length > 0 ||
  (!lineageStore.programsOnly.value && of.instructions.length + of.constants.length > 0);

/**
 * Returns the locks that name something in the first parent. Removes the others and reports that.
 * @param {string} parent
 * @returns {Promise<Locks|undefined>} undefined where nothing is locked
 */
async function applicableLocks(parent) {
  if (namesPositions(lineageStore.locks.value)) {
    const { kept, gone } = locksFor(
      lineageStore.locks.value,
      await genomeOf(shownIndividual(parent) ?? (await api.getIndividual(parent))),
    );
    if (gone.length > 0) {
      lineageStore.locks.value = kept;
      showProblem("locks", {
        problem: {
          title: "Unlocked",
          status: 422,
          detail: `The parent does not have: ${gone.join(", ")}.`,
        },
      });
    }
  }
  return anyLocked(lineageStore.locks.value) ? lineageStore.locks.value : undefined;
}

/**
 * True if children of these parents are painted.
 * @param {Lineage} of
 * @param {string[]} parents
 */
async function isPaintedBrood(of, [first]) {
  if (!first) return of.start === "painted";
  if (lineageStore.programsOnly.value) return false;
  return isPainted(await genomeOf(shownIndividual(first) ?? (await api.getIndividual(first))));
}

/** Knobs without those of BRDFs, or without those of painted materials. @param {boolean} painted */
const knobsFor = (painted) => ({
  ...lineageStore.knobs.value,
  ...(painted ? { saturation: 1, energy_limit: false, steer: [] } : { painting: null }),
});

/**
 * Breeds a brood and shows it. One at a time: a second click during breeding is ignored.
 * @param {string[]} parents ids; none for a random brood
 */
export async function breed(parents) {
  const of = lineageStore.lineage.value;
  if (!of || lineageStore.breeding.value) return;
  const startedAt = navigationCount();
  startClock();
  clearProblems("stage", ...KNOBS);
  const work = async () => {
    await sceneSettled();
    const kept = parents.length > 0 ? await applicableLocks(parents[0]) : undefined;
    // Pictures of the brood are of the lineage's scene at its birth, or of a newer scene.
    const sceneId = lineageStore.lineage.value?.scene ?? of.scene;
    const made = await api.breed(of.id, {
      parents,
      knobs: knobsFor(await isPaintedBrood(of, parents)),
      locks: kept,
      count: FRAMES,
    });
    if (lineageStore.lineage.value?.id !== of.id) return;
    storeBred(made, sceneId);
    // Not shown if the user has navigated elsewhere meanwhile.
    if (startedAt === navigationCount()) await show(made.id, "visit");
  };
  try {
    await makeGeneration(work);
  } catch (error) {
    const problem = problemOf(error);
    const place = problemPlace(problem);
    if (place !== "stage") pageStore.knobsOpen.value = true;
    const again = () =>
      void (lineageStore.lineage.value?.id === of.id ? breed(parents) : clearProblems(place));
    showProblem(place, { problem, retry: again });
  }
}

/**
 * Breeds in a lineage that was just opened or imported into, after a running brood.
 * @param {string} id of the lineage; does nothing if another was opened meanwhile
 * @param {string[]} parents
 */
export async function breedNext(id, parents) {
  await whenNoneIsMade();
  if (lineageStore.lineage.value?.id === id) await breed(parents);
}

/**
 * Breeds from a frame: with the mate if one is marked, else by mutation alone.
 * @param {Cell} cell
 */
export async function pick(cell) {
  const chosen = individualIn(cell);
  if (!chosen) return;
  // A click on a picture shown in place of the centre brings the centre back.
  if (cell === "centre" && compareStore.targetInCentre.value)
    return void (compareStore.targetInCentre.value = false);
  if (cell === "centre" && compareStore.flipped.value) return flip(false);
  const other = lineageStore.mate.value;
  const isEdited = lineageStore.draft.value || (presentEdit()?.wrong.size ?? 0) > 0;
  if (cell === "centre" && isEdited) return breedEdited(other);
  await breed(other && other.id !== chosen.id ? [chosen.id, other.id] : [chosen.id]);
}

/** Breeds from the centre as it was edited. @param {Individual|null} other the mate */
async function breedEdited(other) {
  if (lineageStore.breeding.value) return;
  const of = lineageStore.lineage.value;
  const child = await makeChild();
  // The reason is in the details.
  if (!child) pageStore.detailsOpen.value = true;
  if (of && child) await breedNext(of.id, other ? [child.id, other.id] : [child.id]);
}

/** Marks the individual in a frame as the mate, or removes the mark. @param {Cell} cell */
export function toggleMate(cell) {
  const chosen = individualIn(cell);
  if (!chosen) return;
  lineageStore.mate.value = lineageStore.mate.value?.id === chosen.id ? null : chosen;
  pageStore.announcement.value = lineageStore.mate.value
    ? `${nameOf(cell)} is the mate. Choose the other parent, or press Escape.`
    : "No mate is marked.";
}

export function cancelMate() {
  if (!lineageStore.mate.value) return;
  lineageStore.mate.value = null;
  pageStore.announcement.value = "No mate is marked.";
}

/** Breeds the same parents again with a new seed. */
export function reroll() {
  const of = lineageStore.generation.value;
  // Imported individuals and results of searches have no parents: breeds from the centre instead.
  const first = of && !isBred(of) ? centreOf(of) : null;
  return breed(first ? [first.id] : (of?.parents ?? []));
}

/** Breeds a random brood. */
export const breedRandom = () => breed([]);

/** Name of a frame in messages. @param {Cell} cell */
export const nameOf = (cell) => (cell === "centre" ? "The centre" : `Frame ${cell + 1}`);

/** @param {Cell} cell */
export async function toggleFavourite(cell) {
  const chosen = individualIn(cell);
  if (chosen) await setFavourite(chosen, !chosen.favourite, nameOf(cell));
}

/**
 * Saves marks and notes one after the other, so that the last change wins.
 * @type {Promise<void>}
 */
let markQueue = Promise.resolve();

/**
 * Shows the mark at once, and undoes it if the server refuses.
 * @param {Individual} of
 * @param {boolean} favourite
 * @param {string} name
 */
export function setFavourite(of, favourite, name) {
  updateIndividual(of.id, { favourite });
  const work = async () => {
    try {
      const { version } = await api.patchIndividual(of, { favourite });
      updateIndividual(of.id, { version });
      pageStore.announcement.value = `${name} is ${favourite ? "a" : "no longer a"} favourite.`;
    } catch (error) {
      updateIndividual(of.id, { favourite: !favourite });
      showProblem("stage", {
        problem: problemOf(error),
        retry: () => void setFavourite(of, favourite, name),
      });
    }
  };
  clearProblems("stage");
  markQueue = markQueue.then(work);
  return markQueue;
}

/** @param {Individual} of @param {string} note */
export function setNote(of, note) {
  const work = async () => {
    const known = shownIndividual(of.id) ?? of;
    if (known.note === note) return;
    const changed = await api.patchIndividual(known, { note });
    updateIndividual(of.id, { note: changed.note, version: changed.version });
  };
  markQueue = markQueue.then(() => guarded("centre", work));
  return markQueue;
}

/** Saves defaults one after the other, so that the last change wins. @type {Promise<void>} */
let defaultsQueue = Promise.resolve();

/**
 * Saves a knob as the lineage's default, for random broods and the next visit.
 * @param {"saturation"|"energy_limit"} knob
 * @param {number|boolean} value
 */
function saveDefault(knob, value) {
  const id = lineageStore.lineage.value?.id;
  const work = async () => {
    await sceneSettled();
    const of = lineageStore.lineage.value;
    if (!of || of.id !== id || of[knob] === value) return;
    const changed = await api.patchLineage(of, { [knob]: value });
    if (lineageStore.lineage.value?.id === changed.id) lineageStore.lineage.value = changed;
  };
  defaultsQueue = defaultsQueue.then(() => guarded(knob, work));
  return defaultsQueue;
}

/** @param {number} saturation */
export const saveSaturation = (saturation) => saveDefault("saturation", saturation);

/** @param {boolean} on */
export function setEnergyLimit(on) {
  lineageStore.knobs.value = { ...lineageStore.knobs.value, energy_limit: on };
  void saveDefault("energy_limit", on);
}
