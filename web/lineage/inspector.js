/**
 * The genome inspector: opening and closing it.
 *
 * @import { Cell, Individual } from "../model.js"
 */
import { effect } from "../vendor/signals-core.js";
import { individualSeenIn } from "../compare/ab.js";
import { clearProblems, guarded } from "../page/problem.js";
import { inspect } from "./inspections.js";
import { lineageStore } from "./store.js";

/** Requests the inspection of the individual in the inspector. */
const read = () =>
  guarded("inspector", async () => {
    if (lineageStore.inspected.value) await inspect(lineageStore.inspected.value.of);
  }, true);

/** @param {Individual} of @param {string} name */
export function openInspector(of, name) {
  lineageStore.inspected.value = { of, name };
  void read();
}

/** Inspects the individual visible in a frame. @param {Cell} cell @param {string} name */
export function inspectCell(cell, name) {
  const of = individualSeenIn(cell);
  if (of) openInspector(of, name);
}

export function closeInspector() {
  lineageStore.inspected.value = null;
  clearProblems("inspector");
}

/**
 * True if locks apply to it: they are the open lineage's, and name positions in its genomes.
 * @param {Individual} of
 */
export const isLockable = (of) =>
  [...lineageStore.generations.value.values()].some(
    (one) => one.centre?.id === of.id || one.individuals.some((child) => child.id === of.id),
  );

/** Closes the inspector when another lineage is opened. */
export function watchInspector() {
  let before = lineageStore.lineage.peek()?.id;
  return effect(() => {
    const now = lineageStore.lineage.value?.id;
    if (now !== before) closeInspector();
    before = now;
  });
}
