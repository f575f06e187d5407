/**
 * The list of favourites: opening, its part of the address, and reading it page by page.
 *
 * @import { Favourite, Lineage } from "../model.js"
 */
import { effect, untracked } from "../vendor/signals-core.js";
import * as api from "../api/routes.js";
import { lineageStore } from "../lineage/store.js";
import { clearProblems, guarded } from "../page/problem.js";
import * as route from "../page/route.js";
import { ALL, favouritesStore } from "./store.js";

/** @param {string} [of] a lineage, or ALL */
export function openFavourites(of = ALL) {
  favouritesStore.openOf.value = of;
}

export function closeFavourites() {
  favouritesStore.openOf.value = null;
  clearProblems("favourites");
}

/** Opens what the address names. */
export function followFavouritesAddress() {
  const { favourites } = route.parse(location.hash);
  if (favourites !== favouritesStore.openOf.value) favouritesStore.openOf.value = favourites;
}

/**
 * Number of lists that were begun: an answer is dropped if another list was begun since its
 * request.
 */
let lists = 0;

/** @param {string} of */
const filterOf = (of) => (of === ALL ? null : of);

/** Reads the first page, and the lineages for their names. @param {string} of */
function readFirst(of) {
  lists += 1;
  const mine = lists;
  favouritesStore.items.value = null;
  favouritesStore.nextCursor.value = null;
  favouritesStore.removed.value = new Set();
  favouritesStore.chosenIds.value = new Set();
  return guarded("favourites", async () => {
    const [{ items, next }, lineages] = await Promise.all([
      api.listFavourites(filterOf(of), null),
      api.listLineages(),
    ]);
    if (mine !== lists) return;
    lineageStore.lineages.value = lineages;
    favouritesStore.items.value = items;
    favouritesStore.nextCursor.value = next;
  }, true);
}

/** Reads the next page. */
export const loadMoreFavourites = () =>
  guarded("favourites", async () => {
    const [mine, of, cursor] = [
      lists, favouritesStore.openOf.value, favouritesStore.nextCursor.value,
    ];
    if (of === null || cursor === null) return;
    const { items, next } = await api.listFavourites(filterOf(of), cursor);
    if (mine !== lists || favouritesStore.nextCursor.value !== cursor) return;
    favouritesStore.items.value = [...(favouritesStore.items.value ?? []), ...items];
    favouritesStore.nextCursor.value = next;
  }, true);

/**
 * A lineage by its id; undefined if it is hidden.
 * @param {string} id
 * @returns {Lineage|undefined}
 */
export const lineageOf = (id) =>
  lineageStore.lineages.value.find((one) => one.id === id) ??
  (lineageStore.lineage.value?.id === id ? lineageStore.lineage.value : undefined);

/** Name of a favourite's lineage. @param {Favourite} of */
export const lineageName = (of) => lineageOf(of.lineage)?.name ?? "hidden lineage";

/** Place of a favourite in its lineage. @param {Favourite} of */
export const placeOf = (of) => `generation ${of.generation_index}, frame ${of.slot + 1}`;

/** Name of a favourite in messages and for screen readers. @param {Favourite} of */
export const nameOfFavourite = (of) => `${lineageName(of)}, ${placeOf(of)}`;

/** Keeps the address current, and reads the list when it is opened or filtered. */
export function watchFavourites() {
  effect(() => route.writeFavourites(favouritesStore.openOf.value));
  effect(() => {
    const of = favouritesStore.openOf.value;
    if (of !== null) untracked(() => void readFirst(of));
  });
}
