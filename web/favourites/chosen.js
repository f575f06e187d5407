/**
 * Choice of several favourites, for a comparison or one download.
 *
 * @import { Favourite } from "../model.js"
 */
import { MOST, openComparison } from "../compare/comparison.js";
import { compareStore } from "../compare/store.js";
import { pageStore } from "../page/store.js";
import { closeFavourites, nameOfFavourite } from "./list.js";
import { favouritesStore } from "./store.js";

/** @param {Favourite} of @param {boolean} on */
export function choose(of, on) {
  const next = new Set(favouritesStore.chosenIds.value);
  if (on) next.add(of.id);
  else next.delete(of.id);
  favouritesStore.chosenIds.value = next;
}

/** Chooses all that are listed, or none. @param {boolean} on */
export function chooseAll(on) {
  const ids = (favouritesStore.items.value ?? []).map(({ id }) => id);
  favouritesStore.chosenIds.value = new Set(on ? ids : []);
  pageStore.announcement.value = on ? `${ids.length} favourites are chosen.` : "None is chosen.";
}

/** Opens the comparison of the chosen favourites. */
export function compareFavourites() {
  compareStore.chosen.value = favouritesStore.chosen.value
    .slice(0, MOST)
    .map((of) => ({ key: of.id, name: nameOfFavourite(of), picture: of.thumbnail }));
  closeFavourites();
  openComparison();
}
