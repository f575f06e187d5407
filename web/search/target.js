/**
 * Target of a new search: upload of its files, and what the server read in them.
 *
 * @import { Job, Target, TargetKind } from "../model.js"
 * @import { Draft } from "./draft.js"
 * @import { PictureDraft } from "./views.js"
 */
import { problemOf } from "../api/request.js";
import { wasStopped } from "../api/upload.js";
import { resetPair } from "../compare/pair.js";
import { lineageStore } from "../lineage/store.js";
import { setEntry } from "../page/entry.js";
import { clearProblems, guarded, showProblem } from "../page/problem.js";
import { photoStore } from "../photo/store.js";
import { sceneStore } from "../scene/store.js";
import { updateDraft } from "./draft.js";
import * as api from "./routes.js";
import { openSearches } from "./searches.js";
import { NEW, searchStore } from "./store.js";
import {
  MOST_PICTURES, buildUpload, isPicture, isScene, newPicture, picturesFromList, pointedView, stem,
} from "./views.js";
import { kindOf } from "./words.js";

/** Largest upload of a target that the server accepts. */
const FILE_BYTES = 64 * 1024 * 1024;

/** Stops the running upload. @type {AbortController|null} */
let stopping = null;

/** Reads the list of targets that the server has. */
export const readTargets = () =>
  guarded("target", async () => {
    searchStore.targets.value = await api.listTargets();
  });

/** Deletes a target of the server that only this form uses. @param {string|null} id */
async function deleteOwn(id) {
  if (!id) return;
  searchStore.targets.value = searchStore.targets.value.filter((one) => one.id !== id);
  try {
    await api.deleteTarget(id);
  } catch {
    // Another search uses it already, so it stays like any other target.
    await readTargets();
  }
}

/** Stops a running upload. */
export function stopSending() {
  const present = stopping;
  stopping = null;
  searchStore.upload.value = null;
  present?.abort();
}

/**
 * Replaces the target of the form; a target that was read before does not apply any more.
 * @param {Partial<Draft>} change
 */
function replaceTarget(change) {
  stopSending();
  clearProblems("target");
  searchStore.wrongPicture.value = null;
  searchStore.picturesChanged.value = false;
  searchStore.setAside.value = null;
  const { own } = searchStore.draft.value;
  updateDraft({ ...change, target: null, own: null });
  void deleteOwn(own);
}

/**
 * Shows why a target cannot be used.
 * @param {string} title
 * @param {number} status
 * @param {string} detail
 * @param {{view: number|null, field: string}|null} [at] picture and field that it is about
 */
function showRefusal(title, status, detail, at = null) {
  searchStore.wrongPicture.value = at;
  showProblem("target", { problem: { title, status, detail } });
}

/**
 * Uploads parts for the server to read; starts no search.
 * @param {Record<string, unknown>} spec
 * @param {Record<string, File>} parts
 */
async function send(spec, parts) {
  const whole = Object.values(parts).reduce((sum, part) => sum + part.size, 0);
  if (whole > FILE_BYTES)
    return showRefusal(
      "Too large",
      413,
      `A target may have 64 MiB with all its pictures; this one has ${Math.ceil(whole / 2 ** 20)} MiB.`,
    );
  // A retry starts the upload anew.
  await guarded("target", async () => {
    stopSending();
    const mine = new AbortController();
    const isMine = () => stopping === mine;
    stopping = mine;
    searchStore.upload.value = { sent: 0, whole };
    searchStore.wrongPicture.value = null;
    const progress = (/** @type {number} */ sent, /** @type {number} */ of) => {
      if (isMine()) searchStore.upload.value = { sent, whole: of };
    };
    try {
      const made = await api.createTarget(spec, parts, { progress, signal: mine.signal });
      // Stopped at the last moment: the target is deleted again.
      if (!isMine()) return void api.deleteTarget(made.id).catch(() => {});
      const before = searchStore.draft.value.own;
      searchStore.targets.value = [made, ...searchStore.targets.value];
      searchStore.picturesChanged.value = false;
      resetPair(searchStore.understoodPair);
      updateDraft({ target: made, own: made.id });
      void deleteOwn(before);
    } catch (error) {
      if (wasStopped(error) || !isMine()) return;
      if (spec.kind === "image")
        searchStore.wrongPicture.value = pointedView(problemOf(error).pointer);
      throw error;
    } finally {
      if (isMine()) stopSending();
    }
  });
}

/** Uploads a measured file at once, since only its kind has to be known. */
export function readFile() {
  const { file, kind } = searchStore.draft.value;
  if (file && kind && kind !== "image") void send({ kind, name: stem(file.name) }, { file });
}

/** Uploads the pictures with their settings. */
export function readPictures() {
  clearProblems("target");
  const asked = buildUpload(
    searchStore.draft.value.views,
    lineageStore.lineage.value &&
      sceneStore.scene.value && {
        id: lineageStore.lineage.value.scene,
        scene: sceneStore.scene.value,
      },
  );
  if ("wrong" in asked)
    return showRefusal("The form is incomplete", 400, asked.wrong, {
      view: asked.view,
      field: asked.field,
    });
  void send(asked.spec, asked.parts);
}

/**
 * Takes files from the picker or a drop. A measured file is read at once if its name shows its
 * kind; pictures are collected.
 * @param {File[]} files
 */
export async function addTargetFiles(files) {
  const measured = files.filter(({ name }) => !isPicture(name) && !isScene(name));
  if (measured.length > 1 || (measured.length === 1 && files.length > 1)) {
    return showRefusal(
      "One measurement at a time",
      0,
      `${files.length} files were chosen; only pictures of one material can be used together.`,
    );
  }
  const [file] = measured;
  for (const one of files.filter(({ name }) => isScene(name))) {
    const views = await picturesFromList(await one.text(), files);
    if (views)
      return "wrong" in views
        ? showRefusal("The list does not match the files", 0, views.wrong)
        : useViews(views);
  }
  if (file) return useFile(file, kindOf(file.name));
  const pictures = files.filter(({ name }) => isPicture(name));
  // An EXR beside other pictures is a picture; alone it may be a slice, and the user can choose.
  const gathers =
    searchStore.draft.value.kind === "image" ||
    pictures.length > 1 ||
    pictures.some(({ name }) => kindOf(name) === "image");
  if (gathers) addPictures(pictures);
  else if (pictures.length === 1) useFile(pictures[0], kindOf(pictures[0].name));
  for (const one of files) if (isScene(one.name)) await useSceneFile(one, null);
}

/** @param {File} file @param {TargetKind|""} kind */
function useFile(file, kind) {
  if (file.size > FILE_BYTES)
    return showRefusal(
      "The file is too large",
      413,
      `A target may have 64 MiB; ${file.name} has ${Math.ceil(file.size / 2 ** 20)} MiB.`,
    );
  replaceTarget({ file, kind });
  readFile();
}

/** Uses pictures together with their settings. @param {PictureDraft[]} views */
function useViews(views) {
  if (views.length === 0 || views.length > MOST_PICTURES)
    return showRefusal(
      "Too many pictures, or none",
      0,
      `A target has 1 to ${MOST_PICTURES} pictures, not ${views.length}.`,
    );
  replaceTarget({ file: views[0].file, kind: "image", views });
}

/** Kinds of light under which searches match pictures. */
const SEARCHED = ["point", "spot", "directional", "ies"];

/** True if a lineage is open whose scene can be that of a picture. */
const isOpenUsable = () =>
  lineageStore.lineage.value !== null &&
  (sceneStore.scene.value?.lights ?? []).every(({ kind }) => SEARCHED.includes(kind ?? "point"));

/** @param {File[]} files */
export function addPictures(files) {
  if (files.length === 0) return;
  const before =
    searchStore.draft.value.file && searchStore.draft.value.kind === "image"
      ? searchStore.draft.value.views
      : [];
  const views = [...before];
  for (const file of files) views.push(newPicture(file, views.at(-1), isOpenUsable()));
  if (views.length > MOST_PICTURES)
    return showRefusal(
      "Too many pictures",
      0,
      `A target has at most ${MOST_PICTURES} pictures, not ${views.length}.`,
    );
  if (before.length === 0) replaceTarget({ file: views[0].file, kind: "image", views });
  else changeViews(views);
}

/** Reads the same file as another kind; settings of pictures are kept. @param {TargetKind} kind */
export function readAs(kind) {
  const { file, views } = searchStore.draft.value;
  if (!file || kind === searchStore.draft.value.kind) return;
  const isThere = views[0]?.file === file;
  replaceTarget({
    kind,
    views: kind === "image" && !isThere ? [newPicture(file, undefined, isOpenUsable())] : views,
  });
  readFile();
}

/** @param {PictureDraft[]} views */
function changeViews(views) {
  stopSending();
  if (searchStore.draft.value.target) searchStore.picturesChanged.value = true;
  updateDraft({
    views,
    target: null,
    file: views[0]?.file ?? null,
    ...(views.length === 0 ? { kind: /** @type {const} */ ("") } : {}),
  });
}

/** Changes the settings of a picture. @param {number} key @param {Partial<PictureDraft>} change */
export function changeView(key, change) {
  changeViews(
    searchStore.draft.value.views.map((one) => (one.key === key ? { ...one, ...change } : one)),
  );
}

/**
 * Chooses the scene of a picture; a scene of its own begins as a copy of the open lineage's.
 * @param {PictureDraft} of
 * @param {PictureDraft["from"]} from
 */
export function chooseScene({ key, text }, from) {
  const open = lineageStore.lineage.value && sceneStore.scene.value;
  const { id: _, ...json } = open || {};
  changeView(key, {
    from,
    fromByHand: true,
    ...(from === "given" && text.trim() === "" && open
      ? { text: JSON.stringify(json, null, 1) }
      : {}),
  });
}

/** @param {number} key */
export function removeView(key) {
  searchStore.wrongPicture.value = null;
  clearProblems("target");
  const shown = photoStore.shown.value.get(key);
  if (shown && typeof shown !== "string") URL.revokeObjectURL(shown.url);
  setEntry(photoStore.shown, key, null);
  const views = searchStore.draft.value.views.filter((one) => one.key !== key);
  if (views.length === 0) replaceTarget({ views, file: null, kind: "" });
  else changeViews(views);
}

/**
 * Uses a scene's file for one picture, or where none is named for all without a scene of their own.
 * @param {File} file
 * @param {number|null} key of the picture
 */
export async function useSceneFile(file, key) {
  const text = await file.text();
  const { views, kind } = searchStore.draft.value;
  if (kind !== "image" || views.length === 0)
    return showRefusal(
      "A scene is not a target",
      0,
      `${file.name} describes what a picture shows; choose the picture first.`,
    );
  const bare = views.filter((one) => one.from !== "given");
  const keys = key === null ? (bare.length > 0 ? bare : views).map((one) => one.key) : [key];
  changeViews(views.map((one) => (keys.includes(one.key) ? { ...one, from: "given", fromByHand: true, text } : one)));
}

/** Chooses a target that the server has. @param {Target} target */
export function chooseTarget(target) {
  stopSending();
  clearProblems("target");
  searchStore.wrongPicture.value = null;
  searchStore.picturesChanged.value = false;
  const { file, kind, views } = searchStore.draft.value;
  if (file) searchStore.setAside.value = { file, kind, views };
  resetPair(searchStore.understoodPair);
  // The target that this form uploaded stays in the list, where it may be chosen again.
  updateDraft({ file: null, kind: target.kind, views: [], target, own: null });
}

/** Restores the files that were set aside. */
export function restoreSetAside() {
  const before = searchStore.setAside.value;
  if (!before) return;
  replaceTarget(before);
  readFile();
}

/** Fills the form for another search of the same target. @param {Job} of @param {Target} target */
export function searchAgain({ strategy, budget, seed, threads, islands, mirrored, name }, target) {
  chooseTarget(target);
  const measure = budget.generations
    ? "generations"
    : budget.evaluations
      ? "evaluations"
      : "seconds";
  updateDraft({
    strategy,
    measure,
    [measure]: String(budget[measure] ?? ""),
    seed: String(seed),
    threads: threads === null ? "" : String(threads),
    islands: islands > 1 ? String(islands) : "",
    mirrored,
    name: name === target.name ? "" : name,
  });
  openSearches(NEW);
}

/** @param {Target} target */
export const removeTarget = (target) =>
  guarded("target", async () => {
    await api.deleteTarget(target.id);
    if (searchStore.draft.value.own === target.id) updateDraft({ own: null });
    searchStore.targets.value = searchStore.targets.value.filter(({ id }) => id !== target.id);
    if (searchStore.draft.value.target?.id === target.id)
      updateDraft({ target: null, file: null, kind: "", views: [] });
  });
