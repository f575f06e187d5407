/**
 * Which pictures are there: loads, quiet retries, the time from a click to the last picture, and `body[data-ready]`. Owns
 * the clock and the retries; knows nothing of how a picture is made.
 */
import { effect, signal } from "./vendor/signals-core.js";
import { twinsInWords } from "./locks.js";
import { announcement, breeding, elapsed, generation, sceneBusy } from "./state.js";

const RETRIES = 6;

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** Addresses whose picture was seen. @type {Signal<Set<string>>} */
export const loaded = signal(new Set());
/** Addresses that failed too often to be tried again unasked. @type {Signal<Set<string>>} */
export const failed = signal(new Set());
/** How often an address was tried again; part of the image's key, so that a new try is a new request. @type {Signal<Map<string, number>>} */
export const attempts = signal(new Map());
/** The generation whose pictures are all there. @type {Signal<string|null>} */
export const ready = signal(null);

/** @type {Map<string, ReturnType<typeof setTimeout>>} */
const timers = new Map();
/** @type {number|null} */
let clock = null;

/** Starts the clock of the status line, at a click. */
export function startClock() {
  clock = performance.now();
  elapsed.value = null;
}

/** Says that what is on screen is about to be replaced. */
export function unready() {
  ready.value = null;
  delete document.body.dataset.ready;
}

/** @param {string} url */
export function pictureLoaded(url) {
  forgetTimer(url);
  if (!loaded.value.has(url)) loaded.value = new Set(loaded.value).add(url);
  if (failed.value.has(url)) failed.value = remove(failed.value, url);
  checkReady();
}

/** @param {string} url */
export function pictureFailed(url) {
  if (timers.has(url)) return;
  const tried = attempts.value.get(url) ?? 0;
  if (tried >= RETRIES) {
    failed.value = new Set(failed.value).add(url);
    return;
  }
  timers.set(url, setTimeout(() => tryAgain(url), 500 * 2 ** Math.min(tried, 4)));
}

/**
 * Asks for a picture once more; by a person, by a timer, or because the server said that it is there.
 * @param {string} url
 */
export function tryAgain(url) {
  forgetTimer(url);
  if (failed.value.has(url)) failed.value = remove(failed.value, url);
  attempts.value = new Map(attempts.value).set(url, (attempts.value.get(url) ?? 0) + 1);
}

/**
 * The server says that a picture is there: one that failed or waits for its next try is asked for at once.
 * @param {string} url
 */
export function pictureArrived(url) {
  if (timers.has(url) || failed.value.has(url)) tryAgain(url);
}

/** The server is there again: whatever had failed may be there now. */
export function askForFailed() {
  for (const url of [...failed.value, ...timers.keys()]) tryAgain(url);
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

/** Looks at the images themselves: an address seen before may have to be read again. */
export function checkReady() {
  const shown = generation.value;
  if (!shown || breeding.value || sceneBusy.value || ready.value === shown.id) return;
  /** @type {NodeListOf<HTMLImageElement>} */
  const images = document.querySelectorAll("img[data-frame]");
  if (images.length === 0) return;
  for (const image of images) {
    if (image.dataset.generation !== shown.id || !image.complete || image.naturalWidth === 0) return;
  }
  if (clock !== null) elapsed.value = performance.now() - clock;
  clock = null;
  ready.value = shown.id;
  document.body.dataset.ready = shown.id;
  const twins = twinsInWords(shown);
  announcement.value = `Generation ${shown.index}: ${shown.individuals.length} children, all pictures are there.${twins && ` ${twins}.`}`;
}

/** Another generation, or the same in another scene, has to become ready anew. */
export function watchReady() {
  return effect(() => {
    const id = generation.value?.id ?? null;
    if (id === null || breeding.value || sceneBusy.value) return;
    // After the view has been drawn from the same change.
    queueMicrotask(() => {
      if (ready.peek() !== null && ready.peek() !== id) unready();
      checkReady();
    });
  });
}
