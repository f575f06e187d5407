/**
 * Images placed in the effects of the centre, which must be painted: a file that is opened, another
 * share, removal. Each is stored as a child.
 *
 * @import { GenomeJson, ImagePlace, Individual } from "../model.js"
 */
import * as api from "../api/routes.js";
import { clearProblems, guarded, runExclusive } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { uploadFile } from "../scene/upload.js";
import { storeChild } from "./edit.js";
import { navigationCount } from "./generations.js";
import { imageIn, percent, placeInWords, placeKey, placesOf, withImage, withoutImage } from "./images.js";
import { whenNoneIsMade } from "./making.js";
import { lineageStore } from "./store.js";

/** Effects of the centre; none until its genome is read. Tracks signals. */
const effects = () => lineageStore.centreGenome.value?.effects ?? [];

/**
 * The chosen place of the centre's effects: the first if these lack the last one chosen. Null if
 * there is none. Tracks signals.
 */
export function presentPlace() {
  const places = placesOf(effects());
  return places.find((one) => placeKey(one) === lineageStore.imagePlace.value) ?? places[0] ?? null;
}

/** Image in the chosen place; null if it has none. Tracks signals. */
export function presentImage() {
  const place = presentPlace();
  return place && imageIn(effects(), place);
}

/** Share that the slider shows: as moved, else as stored. Tracks signals. */
export function presentShare() {
  const moved = lineageStore.imageShare.value;
  if (moved && moved.of === lineageStore.centre.value?.id) return moved.share;
  return presentImage()?.share ?? 1;
}

/** True if the slider differs from the share of the chosen place's image. Tracks signals. */
export function isShareMoved() {
  const image = presentImage();
  return image !== null && presentShare() !== image.share;
}

/** @param {string} key */
export function choosePlace(key) {
  clearProblems("image");
  lineageStore.imagePlace.value = key;
  lineageStore.imageShare.value = null;
}

/** @param {number} share */
export function moveShare(share) {
  const of = lineageStore.centre.value?.id;
  if (of) lineageStore.imageShare.value = { of, share };
}

/**
 * Stores a changed genome as a child.
 * @param {Individual} parent
 * @param {(genome: GenomeJson) => GenomeJson} change
 * @param {string} name of the material in the announcement
 * @param {number} startedAt navigations when the user asked for it
 */
async function storeChanged(parent, change, name, startedAt) {
  const genome = change(await api.getGenome(parent.hash));
  await whenNoneIsMade();
  const text = JSON.stringify(genome);
  const child = await storeChild("image", parent, { text, name, startedAt });
  // The slider shows the stored share again, also after undo.
  if (child) lineageStore.imageShare.value = null;
}

/** Uploads a file, and stores a child with it in the chosen place. @param {File} file */
export function openImage(file) {
  const of = lineageStore.lineage.value?.id;
  const [parent, place, share] = [lineageStore.centre.value, presentPlace(), presentShare()];
  if (!parent || !place) return Promise.resolve();
  const startedAt = navigationCount();
  pageStore.announcement.value = `Uploading ${file.name}.`;
  return guarded("image", async () => {
    const made = await uploadFile("image", file, api.createImage);
    if (!made || lineageStore.lineage.value?.id !== of) return;
    const name = `The material with ${file.name} as ${placeInWords(place)}`;
    const change = (/** @type {GenomeJson} */ genome) =>
      withImage(genome, place, { image: made.id, share });
    await storeChanged(parent, change, name, startedAt);
  });
}

/**
 * Stores a child with a change of the chosen place's image.
 * @param {(genome: GenomeJson, place: ImagePlace) => GenomeJson} change
 * @param {(place: string) => string} name of the material in the announcement
 */
function changeImage(change, name) {
  const [parent, place] = [lineageStore.centre.value, presentPlace()];
  if (!parent || !place) return Promise.resolve();
  const startedAt = navigationCount();
  return runExclusive("image", () =>
    storeChanged(parent, (genome) => change(genome, place), name(placeInWords(place)), startedAt),
  );
}

/** Stores a child with the share of the slider. */
export function applyShare() {
  const [image, share] = [presentImage()?.image, presentShare()];
  if (!image) return Promise.resolve();
  return changeImage(
    (genome, place) => withImage(genome, place, { image, share }),
    (place) => `The material with ${percent(share)} of the image as ${place}`,
  );
}

/** Stores a child without the image in the chosen place. */
export const removeImage = () =>
  changeImage(withoutImage, (place) => `The material without an image as ${place}`);
