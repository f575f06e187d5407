/**
 * Choice of several favourites, for a comparison or one download.
 *
 * @import { Favourite } from "../model.js"
 */
import { MOST, openComparison } from "../compare/comparison.js";
import { compareStore } from "../compare/store.js";
import { pageStore } from "../page/store.js";
import { SIDE_PX } from "../page/size.js";
import { closeFavourites, nameOfFavourite } from "./list.js";
import { favouritesStore } from "./store.js";

/** Most favourites and most pixels of a download; the server's limits. */
export const MOST_FILES = 128;
const MOST_PIXELS = 2 ** 25;

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

/** @param {string} format @param {boolean} on */
export function setFormat(format, on) {
  const others = favouritesStore.formats.value.filter((one) => one !== format);
  favouritesStore.formats.value = on ? [...others, format] : others;
}

/** Opens the comparison of the chosen favourites. */
export function compareFavourites() {
  compareStore.chosen.value = favouritesStore.chosen.value
    .slice(0, MOST)
    .map((of) => ({ key: of.id, name: nameOfFavourite(of), picture: of.thumbnail }));
  closeFavourites();
  openComparison();
}

/** Formats that are pictures. */
const PICTURES = ["png", "exr"];

/**
 * Reason why a download cannot be made; empty if it can.
 * @param {number} count
 * @param {string[]} formats
 * @param {string} side as typed
 */
export function archiveProblem(count, formats, side) {
  if (count > MOST_FILES) return `At most ${MOST_FILES} fit into one file.`;
  if (formats.length === 0) return "Choose a format.";
  const pictures = formats.filter((one) => PICTURES.includes(one)).length;
  if (pictures === 0) return "";
  const px = Number(side);
  if (!Number.isInteger(px) || px < SIDE_PX.min || px > SIDE_PX.max)
    return `The side must be ${SIDE_PX.min} to ${SIDE_PX.max} pixels.`;
  if (count * pictures * px * px > MOST_PIXELS)
    return `The pictures are too large together: at most ${Math.floor(Math.sqrt(MOST_PIXELS / (count * pictures)))} pixels each.`;
  return "";
}

/**
 * Address of a download of several individuals.
 * @param {string[]} ids
 * @param {string[]} formats
 * @param {string} side as typed
 * @param {boolean} limited true for source code under the energy limit
 */
export const archivePath = (ids, formats, side, limited) =>
  `/v1/exports.zip?individuals=${ids.join()}&formats=${formats.join()}` +
  (formats.some((one) => PICTURES.includes(one)) ? `&size=${Number(side)}` : "") +
  `&energy_limit=${limited}`;
