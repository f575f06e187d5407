/** Making of generations by this page: one at a time. */
import { deferGenerationEvents } from "./events.js";
import { lineageStore } from "./store.js";

/** The last work that made a generation. @type {Promise<void>} */
let running = Promise.resolve();

/**
 * Runs work that makes a generation. Does nothing while other such work runs.
 * @param {() => Promise<void>} work
 */
export async function makeGeneration(work) {
  if (lineageStore.breeding.value) return;
  lineageStore.breeding.value = true;
  running = work();
  deferGenerationEvents(running);
  try {
    await running;
  } finally {
    lineageStore.breeding.value = false;
  }
}

/** Waits until no generation is being made. */
export async function whenNoneIsMade() {
  while (lineageStore.breeding.value) {
    await running.catch(() => {});
    // `makeGeneration` ends in a later microtask.
    await Promise.resolve();
  }
}
