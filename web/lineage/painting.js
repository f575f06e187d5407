/**
 * Colours of a painting: read from a picture by the server, and used by the next broods of painted
 * materials.
 *
 * @import { Painting, PaintingRegion } from "../model.js"
 */
import * as api from "../api/routes.js";
import { clearProblems, guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { uploadFile } from "../scene/upload.js";
import { lineageStore } from "./store.js";

/** Files that the server reads colours from. */
export const PICTURES = "image/png,image/jpeg";

/** True if a file is such a picture, by its name. @param {File} file */
export const isPicture = ({ name }) => /\.(png|jpe?g)$/i.test(name);

/** @param {Painting|null} painting */
function setPainting(painting) {
  lineageStore.knobs.value = { ...lineageStore.knobs.value, painting };
}

/** Reads the colours of a picture, for the next broods. @param {File} file */
export function usePainting(file) {
  clearProblems("painting");
  // Where the colours and a refusal are shown.
  pageStore.knobsOpen.value = true;
  pageStore.announcement.value = `Reading ${file.name}.`;
  const of = lineageStore.lineage.value?.id;
  return guarded("painting", async () => {
    const painting = await uploadFile("painting", file, api.readPalette);
    if (!painting || lineageStore.lineage.value?.id !== of) return;
    setPainting(painting);
    pageStore.announcement.value = `${file.name}: ${regionsInWords(painting)} for the next brood.`;
  });
}

export function clearPainting() {
  clearProblems("painting");
  setPainting(null);
  pageStore.announcement.value = "The next brood has colours of its own.";
}

/** Number of regions in words. @param {Painting} painting */
export const regionsInWords = ({ regions }) =>
  regions.length === 1 ? "colours of 1 region" : `colours of ${regions.length} regions`;

/** Share of a region in words. @param {PaintingRegion} region */
export const shareInWords = ({ share }) =>
  `${share < 0.01 ? (100 * share).toFixed(1) : Math.round(100 * share)} % of the picture`;
