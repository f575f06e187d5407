/**
 * Individuals of the generations in the store: lookup by frame or id, and changes in place.
 *
 * @import { Cell, Generation, Individual } from "../model.js"
 */
import { lineageStore } from "./store.js";

/**
 * The individual in a frame of the shown generation.
 * @param {Cell} cell
 * @returns {Individual|null}
 */
export function individualIn(cell) {
  if (cell === "centre") return lineageStore.centre.value;
  return (
    lineageStore.generation.value?.individuals.find((individual) => individual.slot === cell) ??
    null
  );
}

/** An individual of the shown generation, by its id. @param {string} id */
export const shownIndividual = (id) =>
  [
    lineageStore.generation.value?.centre,
    ...(lineageStore.generation.value?.individuals ?? []),
  ].find((one) => one?.id === id) ?? null;

/**
 * Stores generations that were read, except marks that were changed here since.
 * @param {Generation[]} news
 */
export function storeGenerations(news) {
  const next = new Map(lineageStore.generations.value);
  for (const item of news) {
    const known = next.get(item.id);
    /** @param {Individual} one */
    const latest = (one) => {
      const { favourite, note, version } =
        [known?.centre, ...(known?.individuals ?? [])].find((it) => it?.id === one.id) ?? one;
      return version > one.version ? { ...one, favourite, note, version } : one;
    };
    next.set(
      item.id,
      known
        ? {
            ...item,
            centre: item.centre && latest(item.centre),
            individuals: item.individuals.map(latest),
          }
        : item,
    );
  }
  lineageStore.generations.value = next;
}

/**
 * Changes an individual in all generations that show it.
 * @param {string} id
 * @param {Partial<Individual>} change
 */
export function updateIndividual(id, change) {
  const next = new Map(lineageStore.generations.value);
  /** @param {Individual} one */
  const changed = (one) => (one.id === id ? { ...one, ...change } : one);
  for (const [key, item] of next) {
    if (item.centre?.id !== id && !item.individuals.some((one) => one.id === id)) continue;
    next.set(key, {
      ...item,
      centre: item.centre && changed(item.centre),
      individuals: item.individuals.map(changed),
    });
  }
  lineageStore.generations.value = next;
}
