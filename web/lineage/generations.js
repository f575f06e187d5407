/**
 * Showing generations of the open lineage: visit, undo, redo, and reading them from the server.
 *
 * @import { Generation, GenerationOutline } from "../model.js"
 */
import { batch } from "../vendor/signals-core.js";
import { ProblemError } from "../api/request.js";
import * as api from "../api/routes.js";
import { saveSetting } from "../page/memory.js";
import { guarded } from "../page/problem.js";
import * as route from "../page/route.js";
import { redoTarget, step, undoTarget } from "./history.js";
import { storeGenerations } from "./individuals.js";
import { clearReady, forgetPictures } from "./pictures.js";
import { lineageStore } from "./store.js";

/** Number of generations that are held whole: those used last. Others are read when visited. */
const WHOLE = 64;

/**
 * Scene for which the picture addresses of each whole generation were read; the last used is last.
 * @type {Map<string, string>}
 */
const sceneReadFor = new Map();

/**
 * Number of navigations so far: changes of the generation that is shown. An answer is dropped if
 * another navigation has begun since its request.
 */
let navigations = 0;

/** Number of navigations so far; a caller that waits compares it to see if the user moved on. */
export const navigationCount = () => navigations;

/** Begins a navigation. @returns {() => boolean} true as long as no other has begun */
export function beginNavigation() {
  const mine = ++navigations;
  return () => mine === navigations;
}

/** Notes a use of a whole generation. @param {string} id @param {string} sceneId */
function noteUse(id, sceneId) {
  sceneReadFor.delete(id);
  sceneReadFor.set(id, sceneId);
}

/**
 * Stores generations, and reduces those that were not used for long.
 * @param {Generation[]} read the last is the last to be reduced
 * @param {string} sceneId scene for which they were read
 */
export function storeRead(read, sceneId) {
  for (const { id } of read) noteUse(id, sceneId);
  for (const id of [...sceneReadFor.keys()].slice(0, -WHOLE))
    if (id !== lineageStore.shownId.value) sceneReadFor.delete(id);
  storeGenerations(read, sceneReadFor);
}

/**
 * Stores outlines of generations that are not in the store.
 * @param {GenerationOutline[]} read
 * @param {boolean} [again] true to replace those that are
 */
export function storeOutlines(read, again = false) {
  if (again) sceneReadFor.clear();
  const known = lineageStore.generations.value;
  const news = again ? read : read.filter(({ id }) => !known.has(id));
  const outlines = news.map((one) => ({
    ...one, parents: [], from: one.from ?? undefined, centre: one.centre ?? null,
  }));
  storeGenerations(outlines, sceneReadFor);
}

/** Removes the generations of another lineage from the store. */
export function clearGenerations() {
  sceneReadFor.clear();
  lineageStore.generations.value = new Map();
}

/**
 * True if breeding made it, with knobs to breed on with. False for results of a search and for
 * imported genomes.
 * @param {Generation} of
 */
export const isBred = (of) => !["fit", "adopt"].includes(of.individuals[0]?.operator ?? "");

/**
 * Shows a generation of the open lineage.
 * @param {string} id
 * @param {"visit"|"undo"|"redo"} how
 */
export async function show(id, how) {
  const isNewest = beginNavigation();
  const of = lineageStore.lineage.value;
  if (!of || lineageStore.shownId.value === id) return;
  if (sceneReadFor.get(id) === of.scene) noteUse(id, of.scene);
  else await readGeneration(id, of.scene);
  if (!isNewest()) return;
  clearReady();
  batch(() => {
    forgetPictures(picturesOf(id));
    lineageStore.trail.value = step(lineageStore.trail.value, lineageStore.shownId.value, id, how);
    lineageStore.shownId.value = id;
    lineageStore.mate.value = null;
  });
  saveSetting(`trail.${of.id}`, lineageStore.trail.value, "sessionStorage");
  route.write(of.id, id);
}

/** Addresses of a generation's pictures. @param {string} id */
function picturesOf(id) {
  const of = lineageStore.generations.value.get(id);
  return [...(of?.individuals ?? []), ...(of?.centre ? [of.centre] : [])].map(
    ({ thumbnail }) => thumbnail,
  );
}

/** Id of the generation that undo would show. */
export const undoId = () =>
  undoTarget(lineageStore.trail.value, lineageStore.descent.value, lineageStore.shownId.value);

/** Id of the generation that redo would show. */
export const redoId = () =>
  redoTarget(lineageStore.trail.value, lineageStore.descent.value, lineageStore.shownId.value);

export const undo = () => move("undo", undoId());
export const redo = () => move("redo", redoId());

/** @param {string} id */
export const visit = (id) => move("visit", id);

/** @param {"undo"|"redo"|"visit"} how @param {string|null} target */
async function move(how, target) {
  if (target) await guarded("stage", () => show(target, how));
}

/**
 * Reads a generation of the open lineage from the server into the store.
 * @param {string} id
 * @param {string} sceneId present scene of the lineage
 */
export async function readGeneration(id, sceneId) {
  const read = await api.getGeneration(id);
  if (read.lineage !== lineageStore.lineage.value?.id) {
    throw new ProblemError({
      title: "Not in this lineage",
      status: 404,
      detail: "That generation belongs to another lineage.",
    });
  }
  storeRead([read], sceneId);
}

/** Reads the shown generation again if its picture addresses are of another scene. */
export async function refreshShown() {
  const of = lineageStore.lineage.value;
  const id = lineageStore.shownId.value;
  if (of && id && sceneReadFor.get(id) !== of.scene) await readGeneration(id, of.scene);
}

/**
 * Stores a generation that was just bred by this page.
 * @param {Generation} made
 * @param {string} sceneId scene of the lineage at the time of the request
 */
export function storeBred(made, sceneId) {
  if (made.lineage !== lineageStore.lineage.value?.id) return;
  storeRead([made], sceneId);
}
