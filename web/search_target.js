/**
 * The target of a search that is being asked for: its files on their way to the server, and what the server read in them. Owns the
 * upload and what the form has made on the server so far; knows nothing of drawing.
 *
 * @import { Job, Target, TargetKind } from "./types.js"
 * @import { Draft } from "./search_draft.js"
 * @import { PictureDraft } from "./search_views.js"
 */
import { signal } from "./vendor/signals-core.js";
import { problemOf } from "./api.js";
import { guarded } from "./lineage.js";
import { rest, understood } from "./pair.js";
import * as api from "./search_api.js";
import { draft, fill } from "./search_draft.js";
import { MOST_PICTURES, isPicture, isScene, listed, pictureOf, pointedView, stem, uploadOf } from "./search_views.js";
import { kindOf } from "./search_words.js";
import { NEW, openSearches } from "./searches.js";
import { forget, lineage, scene, tell } from "./state.js";
import { wasStopped } from "./upload.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** The server's limit, said before so much is sent in vain. */
export const FILE_BYTES = 64 * 1024 * 1024;

/** Those that the server has, newest first. @type {Signal<Target[]>} */
export const targets = signal([]);
/** What is on its way; all of it is there while the server reads. @type {Signal<{sent: number, whole: number}|null>} */
export const sending = signal(null);
/** What the last refusal was about: a picture by its number and a field of it. @type {Signal<{view: number|null, field: string}|null>} */
export const wrongView = signal(null);
/** Whether pictures were changed since the server read them. @type {Signal<boolean>} */
export const isStale = signal(false);

/** What was being filled in when a target that is here already was chosen. @type {Signal<Pick<Draft, "file"|"kind"|"views">|null>} */
export const aside = signal(null);

/** @type {AbortController|null} */
let stopping = null;

export const readTargets = () => guarded("target", async () => {
  targets.value = await api.listTargets();
});

/** Takes a target that this form alone knows off the server again. @param {string|null} id */
async function drop(id) {
  if (!id) return;
  targets.value = targets.value.filter((one) => one.id !== id);
  try {
    await api.deleteTarget(id);
  } catch {
    // Somebody searches for it already: then it is a target like any other.
    await readTargets();
  }
}

/** Stops what is on its way, if anything is. */
export function stopSending() {
  const present = stopping;
  stopping = null;
  sending.value = null;
  present?.abort();
}

/** Whatever was read before is not what is to be matched now. @param {Partial<Draft>} change */
function begin(change) {
  stopSending();
  forget("target");
  wrongView.value = null;
  isStale.value = false;
  aside.value = null;
  const { own } = draft.value;
  fill({ ...change, target: null, own: null });
  void drop(own);
}

/**
 * @param {string} title
 * @param {number} status
 * @param {string} detail
 * @param {{view: number|null, field: string}|null} [at] what it is about
 */
function refuse(title, status, detail, at = null) {
  wrongView.value = at;
  tell("target", { problem: { title, status, detail } });
}

/**
 * Sends parts to be read; nothing is searched yet.
 * @param {Record<string, unknown>} spec
 * @param {Record<string, File>} parts
 */
async function send(spec, parts) {
  const whole = Object.values(parts).reduce((sum, part) => sum + part.size, 0);
  if (whole > FILE_BYTES) return refuse("Too large", 413, `${Math.ceil(whole / 2 ** 20)} MiB are to be sent; a target may have 64, with all its pictures.`);
  // Whatever is tried again begins anew.
  await guarded("target", async () => {
    stopSending();
    const mine = new AbortController();
    const isMine = () => stopping === mine;
    stopping = mine;
    sending.value = { sent: 0, whole };
    wrongView.value = null;
    const progress = (/** @type {number} */ sent, /** @type {number} */ of) => {
      if (isMine()) sending.value = { sent, whole: of };
    };
    try {
      const made = await api.createTarget(spec, parts, { progress, signal: mine.signal });
      // Stopped at the last moment: nobody wants it.
      if (!isMine()) return void api.deleteTarget(made.id).catch(() => {});
      const before = draft.value.own;
      targets.value = [made, ...targets.value];
      isStale.value = false;
      rest(understood);
      fill({ target: made, own: made.id });
      void drop(before);
    } catch (error) {
      if (wasStopped(error) || !isMine()) return;
      if (spec.kind === "image") wrongView.value = pointedView(problemOf(error).pointer);
      throw error;
    } finally {
      if (isMine()) stopSending();
    }
  });
}

/** Sends a measured file at once: there is nothing to be said of it but its kind. */
export function readFile() {
  const { file, kind } = draft.value;
  if (file && kind && kind !== "image") void send({ kind, name: stem(file.name) }, { file });
}

/** Sends the pictures with what is said of them. */
export function readPictures() {
  forget("target");
  const asked = uploadOf(draft.value.views, lineage.value && scene.value && { id: lineage.value.scene, scene: scene.value });
  if ("wrong" in asked) return refuse("Not yet", 400, asked.wrong, { view: asked.view, field: asked.field });
  void send(asked.spec, asked.parts);
}

/** Files from the picker or dropped: a measured one is read at once where its name tells what it is, pictures are gathered. @param {File[]} files */
export async function takeTargets(files) {
  const measured = files.filter(({ name }) => !isPicture(name) && !isScene(name));
  if (measured.length > 1 || (measured.length === 1 && files.length > 1)) {
    return refuse("One measurement at a time", 0, `${files.length} files were chosen; several are taken together only where they are pictures of one material.`);
  }
  const [file] = measured;
  for (const one of files.filter(({ name }) => isScene(name))) {
    const views = await listed(await one.text(), files);
    if (views) return "wrong" in views ? refuse("The list does not fit", 0, views.wrong) : takeViews(views);
  }
  if (file) return takeFile(file, kindOf(file.name));
  const pictures = files.filter(({ name }) => isPicture(name));
  // An EXR beside pictures is one; alone it may be a slice, which the person can say.
  const gathers = draft.value.kind === "image" || pictures.length > 1 || pictures.some(({ name }) => kindOf(name) === "image");
  if (gathers) addPictures(pictures);
  else if (pictures.length === 1) takeFile(pictures[0], kindOf(pictures[0].name));
  for (const one of files) if (isScene(one.name)) await takeScene(one, null);
}

/** @param {File} file @param {TargetKind|""} kind */
function takeFile(file, kind) {
  if (file.size > FILE_BYTES) return refuse("The file is too large", 413, `${file.name} has ${Math.ceil(file.size / 2 ** 20)} MiB; a target may have 64.`);
  begin({ file, kind });
  readFile();
}

/** Pictures with all that is said of them. @param {PictureDraft[]} views */
function takeViews(views) {
  if (views.length === 0 || views.length > MOST_PICTURES) return refuse("Too many pictures, or none", 0, `A target has 1 to ${MOST_PICTURES} pictures; these would be ${views.length}.`);
  begin({ file: views[0].file, kind: "image", views });
}

/** @param {File[]} files */
export function addPictures(files) {
  if (files.length === 0) return;
  const before = draft.value.file && draft.value.kind === "image" ? draft.value.views : [];
  const views = [...before];
  for (const file of files) views.push(pictureOf(file, views.at(-1), lineage.value !== null));
  if (views.length > MOST_PICTURES) return refuse("Too many pictures", 0, `A target has at most ${MOST_PICTURES} pictures; these would be ${views.length}.`);
  if (before.length === 0) begin({ file: views[0].file, kind: "image", views });
  else changeViews(views);
}

/** The same file, read as another kind; what was said of pictures stays. @param {TargetKind} kind */
export function readAs(kind) {
  const { file, views } = draft.value;
  if (!file || kind === draft.value.kind) return;
  const isThere = views[0]?.file === file;
  begin({ kind, views: kind === "image" && !isThere ? [pictureOf(file, undefined, lineage.value !== null)] : views });
  readFile();
}

/** @param {PictureDraft[]} views */
function changeViews(views) {
  stopSending();
  if (draft.value.target) isStale.value = true;
  fill({ views, target: null, file: views[0]?.file ?? null, ...(views.length === 0 ? { kind: /** @type {const} */ ("") } : {}) });
}

/** Says something else of a picture. @param {number} key @param {Partial<PictureDraft>} change */
export function changeView(key, change) {
  changeViews(draft.value.views.map((one) => (one.key === key ? { ...one, ...change } : one)));
}

/** Another scene; one of its own begins as the open lineage's, to be changed. @param {PictureDraft} of @param {PictureDraft["from"]} from */
export function chooseScene({ key, text }, from) {
  const open = lineage.value && scene.value;
  const { id: _, ...json } = open || {};
  changeView(key, { from, ...(from === "given" && text.trim() === "" && open ? { text: JSON.stringify(json, null, 1) } : {}) });
}

/** @param {number} key */
export function removeView(key) {
  wrongView.value = null;
  forget("target");
  const views = draft.value.views.filter((one) => one.key !== key);
  if (views.length === 0) begin({ views, file: null, kind: "" });
  else changeViews(views);
}

/** A scene's file, for one picture; for all without a scene of their own where none is named. @param {File} file @param {number|null} key */
export async function takeScene(file, key) {
  const text = await file.text();
  const { views, kind } = draft.value;
  if (kind !== "image" || views.length === 0) return refuse("A scene alone is no target", 0, `${file.name} says what a picture shows; choose the picture first.`);
  const bare = views.filter((one) => one.from !== "given");
  const keys = key === null ? (bare.length > 0 ? bare : views).map((one) => one.key) : [key];
  changeViews(views.map((one) => (keys.includes(one.key) ? { ...one, from: "given", text } : one)));
}

/** One that the server has already. @param {Target} target */
export function chooseTarget(target) {
  stopSending();
  forget("target");
  wrongView.value = null;
  isStale.value = false;
  const { file, kind, views } = draft.value;
  if (file) aside.value = { file, kind, views };
  rest(understood);
  // What this form has made stays in the list: it was read well, and may be chosen again.
  fill({ file: null, kind: target.kind, views: [], target, own: null });
}

/** Goes on with the files that were being filled in. */
export function takeUpAgain() {
  const before = aside.value;
  if (!before) return;
  begin(before);
  readFile();
}

/** A search for the same as another, in the form. @param {Job} of @param {Target} target */
export function searchAgain({ strategy, budget, seed, threads, mirrored, name }, target) {
  chooseTarget(target);
  const measure = budget.generations ? "generations" : budget.evaluations ? "evaluations" : "seconds";
  fill({
    strategy, measure, [measure]: String(budget[measure] ?? ""), seed: String(seed), threads: threads === null ? "" : String(threads), mirrored,
    name: name === target.name ? "" : name,
  });
  openSearches(NEW);
}

/** @param {Target} target */
export const removeTarget = (target) => guarded("target", async () => {
  await api.deleteTarget(target.id);
  if (draft.value.own === target.id) fill({ own: null });
  targets.value = targets.value.filter(({ id }) => id !== target.id);
  if (draft.value.target?.id === target.id) fill({ target: null, file: null, kind: "", views: [] });
});
