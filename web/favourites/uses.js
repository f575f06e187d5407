/**
 * Uses of one favourite: show it, breed with it, start from it, compare it, change its mark.
 *
 * @import { Favourite } from "../model.js"
 */
import * as api from "../api/routes.js";
import { pin } from "../compare/ab.js";
import { storeBred } from "../lineage/generations.js";
import { updateIndividual } from "../lineage/individuals.js";
import { goTo, goesInto, replaceListed } from "../lineage/open.js";
import { startFromGenome } from "../lineage/presets.js";
import { FRAMES, lineageStore } from "../lineage/store.js";
import { guarded, runExclusive } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { closeFavourites, lineageName, lineageOf, nameOfFavourite } from "./list.js";
import { favouritesStore } from "./store.js";

/**
 * Runs work that leads from a favourite to the frames; one at a time, shown as running.
 * @param {Favourite} of
 * @param {() => Promise<void>} work
 */
const leading = (of, work) =>
  runExclusive("favourites", async () => {
    favouritesStore.busyId.value = of.id;
    try {
      await work();
    } finally {
      favouritesStore.busyId.value = null;
    }
  });

/** Opens the lineage of a favourite at its generation. @param {Favourite} of */
export const showFavourite = (of) =>
  leading(of, async () => {
    await goTo(of.lineage, of.generation);
    closeFavourites();
    const cell = of.slot < FRAMES ? of.slot : "centre";
    pageStore.focusedCell.value = cell;
    pageStore.announcement.value = `${nameOfFavourite(of)} is shown.`;
    // Once the dialog is gone and the frames are drawn.
    requestAnimationFrame(() => {
      const frame = document.querySelector(`[data-cell="${cell}"]`);
      if (frame instanceof HTMLElement) frame.focus();
    });
  });

/** An individual of the open lineage with this genome. @param {string} hash */
const ownWith = (hash) =>
  lineageStore.ordered.value
    .flatMap(({ individuals }) => individuals)
    .find((one) => one.hash === hash);

/**
 * True if the open lineage accepts a favourite: programs need one of the same machine.
 * @param {Favourite} of
 */
export function acceptsMate(of) {
  const open = lineageStore.lineage.value;
  const dialect = lineageOf(of.lineage)?.dialect;
  if (!open || of.lineage === open.id) return open !== null;
  // The server decides about a hidden lineage, whose dialect is not known here.
  return !dialect || of.live_instructions === 0 || goesInto(open.dialect, dialect);
}

/**
 * Marks a favourite as the mate. One of another lineage is imported into the open lineage first.
 * @param {Favourite} of
 */
export const useAsMate = (of) =>
  leading(of, async () => {
    const open = lineageStore.lineage.value;
    if (!open) return;
    /** @type {import("../model.js").Individual|undefined} */
    let mate = of.lineage === open.id ? of : ownWith(of.hash);
    if (!mate) {
      const made = await api.adopt(open.id, { genomes: [of.hash] });
      storeBred(made, open.scene);
      mate = made.individuals[0];
    }
    closeFavourites();
    lineageStore.mate.value = mate;
    pageStore.announcement.value = `${nameOfFavourite(of)} is the mate. Choose the other parent, or press Escape.`;
  });

/**
 * Opens a new lineage that starts from a favourite, in the light of its lineage.
 * @param {Favourite} of
 */
export const startFromFavourite = (of) =>
  leading(of, async () => {
    const name = `From ${lineageName(of)}`;
    await startFromGenome(of.hash, name, lineageOf(of.lineage)?.scene);
    closeFavourites();
    pageStore.announcement.value = `${name}: opened in a new lineage.`;
  });

/** Compares a favourite with the centre, as B. @param {Favourite} of */
export function pinFavourite(of) {
  closeFavourites();
  pin(of, nameOfFavourite(of));
}

/** Removes the mark of a favourite, or sets it again. @param {Favourite} of @param {boolean} on */
export const keepFavourite = (of, on) =>
  guarded("favourites", async () => {
    const { version } = await api.patchIndividual(of, { favourite: on });
    updateIndividual(of.id, { favourite: on, version });
    favouritesStore.items.value = (favouritesStore.items.value ?? []).map((one) =>
      one.id === of.id ? { ...one, version } : one,
    );
    const removed = new Set(favouritesStore.removed.value);
    if (on) removed.delete(of.id);
    else removed.add(of.id);
    favouritesStore.removed.value = removed;
    pageStore.announcement.value = `${nameOfFavourite(of)} is ${on ? "a" : "no longer a"} favourite.`;
  });

/** Makes a favourite the cover of its lineage, or removes the choice. @param {Favourite} of */
export const toggleCover = (of) =>
  guarded("favourites", async () => {
    const lineage = await api.getLineage(of.lineage);
    const isCover = lineage.cover_individual === of.id;
    replaceListed(await api.patchLineage(lineage, { cover_individual: isCover ? null : of.id }));
    pageStore.announcement.value = `${nameOfFavourite(of)} is ${isCover ? "no longer" : "now"} the cover of its lineage.`;
  });
