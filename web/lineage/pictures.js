/**
 * Loading of the page's pictures: retries, the time from a click to the last picture, and
 * `body[data-ready]`, the id of the generation whose pictures are all loaded (browser tests wait
 * for it).
 *
 * @import { Generation } from "../model.js"
 */
import { refusalOf } from "../api/request.js";
import { effect } from "../vendor/signals-core.js";
import { pictureOfSource, pictureSource } from "../page/distance.js";
import { pageStore } from "../page/store.js";
import { sceneStore } from "../scene/store.js";
import { twinsInWords } from "./locks.js";
import { centreOf, lineageStore } from "./store.js";

/** Number of retries, and time since the first failure, after which a picture counts as failed. */
const RETRIES = 6;
const PATIENCE_MS = 20_000;
/** Longest delay between these retries: a person waits for the rest of it after an outage. */
const LONGEST_MS = 2000;
/** Delay between the retries of a failed picture. */
const SLOW_MS = 30_000;

/** Timers of the next retry, by address. @type {Map<string, ReturnType<typeof setTimeout>>} */
const timers = new Map();
/**
 * Times of the first failures of pictures that have not loaded since, by address.
 * @type {Map<string, number>}
 */
const firstFailures = new Map();
/** Time of the click whose pictures are awaited. @type {number|null} */
let clock = null;

/** Starts measuring the time to the last picture, at a click. */
export function startClock() {
  clock = performance.now();
  lineageStore.elapsed_ms.value = null;
}

/**
 * Requests the pictures of a generation that will be shown once more has been read, the centre's
 * first.
 * @param {Generation} of
 */
export function preloadPictures(of) {
  const centre = centreOf(of);
  for (const one of new Set([centre, ...of.individuals])) {
    if (!one) continue;
    const image = new Image();
    image.fetchPriority = one === centre ? "high" : "auto";
    image.src = pictureSource(one.thumbnail);
  }
}

/** Marks the shown pictures as about to be replaced. */
export function clearReady() {
  lineageStore.readyId.value = null;
  delete document.body.dataset.ready;
}

/** @param {string} url */
export function pictureLoaded(url) {
  // Another image of the same address has failed.
  if (timers.has(url)) return retryPicture(url);
  firstFailures.delete(url);
  if (!lineageStore.loadedPictures.value.has(url))
    lineageStore.loadedPictures.value = new Set(lineageStore.loadedPictures.value).add(url);
  if (lineageStore.failedPictures.value.has(url))
    lineageStore.failedPictures.value = remove(lineageStore.failedPictures.value, url);
  checkReady();
}

/**
 * Requests a picture again after a while, and less often once it counts as failed. At every other
 * failure it also asks the server for the reason.
 * @param {string} url
 * @returns {boolean} true if it counts as failed
 */
export function pictureFailed(url) {
  if (timers.has(url)) return false;
  const tried = lineageStore.pictureRetries.value.get(url) ?? 0;
  if (tried % 2 === 1) void endIfRefused(url);
  const first = firstFailures.get(url) ?? performance.now();
  firstFailures.set(url, first);
  const failed = tried >= RETRIES && performance.now() - first >= PATIENCE_MS;
  if (failed) lineageStore.failedPictures.value = new Set(lineageStore.failedPictures.value).add(url);
  const delay = failed ? SLOW_MS : Math.min(500 * 2 ** tried, LONGEST_MS);
  timers.set(
    url,
    setTimeout(() => retryPicture(url), delay),
  );
  return failed;
}

/**
 * Ends the retries of a picture that the server refuses, and keeps the reason.
 * @param {string} url
 */
async function endIfRefused(url) {
  const reason = await refusalOf(url);
  if (reason === null || !timers.has(url)) return;
  forgetTimer(url);
  lineageStore.refusedPictures.value = new Map(lineageStore.refusedPictures.value).set(url, reason);
  lineageStore.failedPictures.value = new Set(lineageStore.failedPictures.value).add(url);
}

/**
 * Requests a picture again.
 * @param {string} url
 */
export function retryPicture(url) {
  forgetTimer(url);
  const wasRefused = lineageStore.refusedPictures.value.has(url);
  if (wasRefused) {
    const refused = new Map(lineageStore.refusedPictures.value);
    refused.delete(url);
    lineageStore.refusedPictures.value = refused;
  }
  if (lineageStore.failedPictures.value.has(url))
    lineageStore.failedPictures.value = remove(lineageStore.failedPictures.value, url);
  lineageStore.pictureRetries.value = new Map(lineageStore.pictureRetries.value).set(
    url,
    // An odd number again after an odd one: its next failure asks for the reason at once.
    (lineageStore.pictureRetries.value.get(url) ?? 0) + (wasRefused ? 2 : 1),
  );
}

/**
 * Requests a picture that the server reports as drawn, if it failed or waits for its next try.
 * @param {string} url
 */
export function pictureAvailable(url) {
  if (timers.has(url) || lineageStore.failedPictures.value.has(url)) retryPicture(url);
}

/** Requests all failed pictures again, after the connection was restored. */
export function retryFailed() {
  for (const url of new Set([...lineageStore.failedPictures.value, ...timers.keys()]))
    retryPicture(url);
}

/**
 * Forgets the state of pictures that are neither on the page nor in a generation about to be shown.
 * @param {string[]} next addresses of that generation's pictures
 */
export function forgetPictures(next) {
  const kept = new Set(next);
  for (const image of document.querySelectorAll("img")) {
    const source = image.getAttribute("src");
    if (source) kept.add(pictureOfSource(source));
  }
  const { loadedPictures, failedPictures, refusedPictures, pictureRetries } = lineageStore;
  loadedPictures.value = new Set([...loadedPictures.value].filter((url) => kept.has(url)));
  failedPictures.value = new Set([...failedPictures.value].filter((url) => kept.has(url)));
  refusedPictures.value = new Map([...refusedPictures.value].filter(([url]) => kept.has(url)));
  pictureRetries.value = new Map([...pictureRetries.value].filter(([url]) => kept.has(url)));
  for (const url of timers.keys()) if (!kept.has(url)) forgetTimer(url);
  for (const url of firstFailures.keys()) if (!kept.has(url)) firstFailures.delete(url);
}

/** @param {string} url */
function forgetTimer(url) {
  const timer = timers.get(url);
  if (timer === undefined) return;
  clearTimeout(timer);
  timers.delete(url);
}

/**
 * @param {Set<string>} from
 * @param {string} url
 */
function remove(from, url) {
  const next = new Set(from);
  next.delete(url);
  return next;
}

/**
 * Marks the generation as ready once all its pictures are loaded. Checks the images themselves,
 * because an address seen before may load again.
 */
function checkReady() {
  const shown = lineageStore.generation.value;
  if (
    !shown ||
    lineageStore.breeding.value ||
    sceneStore.busy.value ||
    lineageStore.readyId.value === shown.id
  )
    return;
  /** @type {NodeListOf<HTMLImageElement>} */
  const images = document.querySelectorAll("img[data-frame]");
  if (images.length === 0) return;
  for (const image of images) {
    if (image.dataset.generation !== shown.id || !image.complete || image.naturalWidth === 0)
      return;
  }
  if (clock !== null) lineageStore.elapsed_ms.value = performance.now() - clock;
  clock = null;
  lineageStore.readyId.value = shown.id;
  document.body.dataset.ready = shown.id;
  const twins = twinsInWords(shown);
  pageStore.announcement.value = `Generation ${shown.index}: ${shown.individuals.length} children, all pictures are loaded.${twins && ` ${twins}.`}`;
}

/** Checks again after each change of the generation or its scene. */
export function watchReady() {
  return effect(() => {
    const id = lineageStore.generation.value?.id ?? null;
    if (id === null || lineageStore.breeding.value || sceneStore.busy.value) return;
    // Components are redrawn in a microtask that this change queues: the second one comes after it.
    queueMicrotask(() =>
      queueMicrotask(() => {
        const { readyId } = lineageStore;
        if (readyId.peek() !== null && readyId.peek() !== id) clearReady();
        checkReady();
      }),
    );
  });
}
