/**
 * Problems shown at the place on the page where they happened.
 *
 * @import { Place, ShownProblem } from "../model.js"
 */
import { isOutage, isUnreachable, problemOf, whenReachable } from "../api/request.js";
import { pageStore } from "./store.js";

/**
 * @param {Place} place
 * @param {ShownProblem} problem
 */
export function showProblem(place, problem) {
  pageStore.problems.value = { ...pageStore.problems.value, [place]: problem };
  if (isUnreachable(problem.problem)) void waitForServer();
}

/** True while the page asks whether the server answers again. */
let asking = false;

async function waitForServer() {
  if (asking) return;
  asking = true;
  await whenReachable();
  asking = false;
  clearOutages();
}

/** @param {Place[]} places */
export function clearProblems(...places) {
  if (!places.some((place) => pageStore.problems.value[place])) return;
  const next = { ...pageStore.problems.value };
  for (const place of places) delete next[place];
  pageStore.problems.value = next;
}

/** Removes problems of an outage, because the server answers again, and repeats what was read. */
export function clearOutages() {
  const shown = Object.entries(pageStore.problems.value);
  const over = shown.flatMap(([place, of]) => (of && isOutage(of.problem) ? [{ place, of }] : []));
  clearProblems(.../** @type {Place[]} */ (over.map(({ place }) => place)));
  for (const { of } of over) if (of.isRead) of.retry?.();
}

/**
 * Runs work, and shows its failure at a place with a way to try again.
 * @param {Place} place
 * @param {() => Promise<void>} work
 * @param {boolean} [isRead] true if it only reads, and is repeated after an outage
 */
export async function guarded(place, work, isRead = false) {
  try {
    clearProblems(place);
    await work();
  } catch (error) {
    const retry = () => void guarded(place, work, isRead);
    showProblem(place, { problem: problemOf(error), retry, isRead });
  }
}

/** Places whose exclusive work is running. @type {Set<Place>} */
const running = new Set();

/**
 * The same for work that must not run twice at a time, such as creating a lineage: calls during a
 * run are dropped.
 * @param {Place} place
 * @param {() => Promise<void>} work
 */
export async function runExclusive(place, work) {
  if (running.has(place)) return;
  running.add(place);
  await guarded(place, work);
  running.delete(place);
}
