/**
 * Individuals of the generations in the store: lookup by frame or id, and changes in place.
 *
 * @import { Cell, Individual, Outline } from "../model.js"
 */
import { compareStore } from "../compare/store.js";
import { descentOf } from "./history.js";
import { inOrder, lineageStore } from "./store.js";

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
 * The generation of the open lineage in which an individual was born; null if there is none.
 * @param {string} id
 */
export function birthOf(id) {
  const all = lineageStore.ordered.value;
  const born = all.find(({ individuals }) => individuals.some((one) => one.id === id));
  if (born) return born;
  const brood = all.find(({ centre }) => centre?.id === id);
  return lineageStore.generations.value.get(brood?.from ?? "") ?? null;
}

/**
 * True if an individual stays in the store when its generation is reduced, because lists of
 * favourites, the strip, B and imports are looked up in all generations.
 * @param {Outline} of
 * @param {Individual} one
 */
const isKept = (of, one) =>
  one.favourite ||
  one.operator === "adopt" ||
  one.id === compareStore.pinned.value?.id ||
  (!of.centre && one === of.individuals[0]);

/**
 * Stores generations that were read, except marks that were changed here since. Reduces those that
 * are not whole to outlines.
 * @param {Outline[]} news
 * @param {{has: (id: string) => boolean}} whole ids of generations that are not reduced
 */
export function storeGenerations(news, whole) {
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
            from: item.from ?? known.from,
            centre: item.centre && latest(item.centre),
            individuals: item.individuals.map(latest),
          }
        : item,
    );
  }
  const { parents } = descentOf(inOrder(next));
  for (const [id, of] of next) {
    const from = parents.get(id);
    const { index, centre } = of;
    const kept = whole.has(id) ? of.individuals : of.individuals.filter((one) => isKept(of, one));
    // `from` replaces the parents.
    if (kept.length < of.individuals.length)
      next.set(id, { id, index, parents: from ? [] : of.parents, from, centre, individuals: kept });
    else if (from !== of.from) next.set(id, { ...of, from });
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
