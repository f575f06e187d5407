/**
 * The access token: asked for once when the server wants one, then kept by the browser as a cookie that no script reads.
 * Owns the question; the token itself is never stored here.
 */
import { signal } from "./vendor/signals-core.js";
import { endSession, makeSession, problemOf, setTokenAsker } from "./api.js";
import { keep, recall } from "./memory.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** @type {Signal<boolean>} */
export const asking = signal(false);
/** Whether this browser was given a token; the token itself cannot be looked at. @type {Signal<boolean>} */
export const given = signal(recall("token-given", false));
/** @type {Signal<import("./types.js").Problem|null>} */
export const refusal = signal(null);

/** All requests that were refused wait for the one answer. @type {Promise<boolean>|null} */
let answer = null;
/** @type {(given: boolean) => void} */
let resolve = () => {};

export function askOnce() {
  setTokenAsker(() => {
    if (!answer) {
      asking.value = true;
      answer = new Promise((done) => {
        resolve = done;
      });
    }
    return answer;
  });
}

/** @param {boolean} isGiven */
function close(isGiven) {
  asking.value = false;
  refusal.value = null;
  answer = null;
  resolve(isGiven);
}

/** @param {string} token */
export async function give(token) {
  try {
    await makeSession(token);
    remember(true);
    close(true);
  } catch (error) {
    refusal.value = problemOf(error);
  }
}

/** @param {boolean} isGiven */
function remember(isGiven) {
  given.value = isGiven;
  keep("token-given", isGiven);
}

/** Takes the cookie away; the next request asks again. */
export async function forgetToken() {
  await endSession();
  remember(false);
}

export const decline = () => close(false);
