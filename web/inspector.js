/**
 * The look into a genome: whose genome it is, and how it is looked at. Owns these choices, which stay while the page is open;
 * knows nothing of drawing.
 *
 * @import { Cell, Individual } from "./types.js"
 */
import { effect, signal } from "./vendor/signals-core.js";
import { seenIn } from "./compare.js";
import { inspect } from "./inspections.js";
import { guarded } from "./lineage.js";
import { forget, generations, lineage } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** @type {Signal<{of: Individual, name: string}|null>} */
export const inspected = signal(null);
/** Whether dead instructions are left out. */
export const liveOnly = signal(false);
/** @type {Signal<"assembly"|"scalar">} */
export const listed = signal("assembly");
/** What the polar plot shows. @type {Signal<{plane: number, color: "luminance"|"r"|"g"|"b", cosine: boolean, log: boolean}>} */
export const plotted = signal({ plane: 0, color: "luminance", cosine: false, log: false });

const read = () => guarded("inspector", async () => {
  if (inspected.value) await inspect(inspected.value.of);
});

/** @param {Individual} of @param {string} name */
export function openInspector(of, name) {
  inspected.value = { of, name };
  void read();
}

/** What is seen in a frame. @param {Cell} cell @param {string} name */
export function inspectCell(cell, name) {
  const of = seenIn(cell);
  if (of) openInspector(of, name);
}

export function closeInspector() {
  inspected.value = null;
  forget("inspector");
}

/** Whether locks mean anything for it: they are the open lineage's, and name positions in its genomes. @param {Individual} of */
export const isLockable = (of) => [...generations.value.values()].some((one) => one.centre?.id === of.id || one.individuals.some((child) => child.id === of.id));

/** Another lineage, by the browser's own back, has other genomes. */
export function watchInspector() {
  let before = lineage.peek()?.id;
  return effect(() => {
    const now = lineage.value?.id;
    if (now !== before) closeInspector();
    before = now;
  });
}
