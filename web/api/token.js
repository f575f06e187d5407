/**
 * Question for an access token. Requests that the server refuses wait here for the answer; the
 * dialog that asks is the view's, and the token itself is never stored in a script.
 */
import { pageStore } from "../page/store.js";

/** Answer that all refused requests wait for. @type {Promise<boolean>|null} */
let answer = null;
/** @type {(accepted: boolean) => void} */
let resolve = () => {};

/**
 * Opens the question unless it is open.
 * @returns {Promise<boolean>} true if the server has accepted a new token
 */
export function askForToken() {
  if (!answer) {
    pageStore.tokenAsked.value = true;
    answer = new Promise((done) => {
      resolve = done;
    });
  }
  return answer;
}

/** Closes the question. @param {boolean} accepted */
export function answerTokenQuestion(accepted) {
  pageStore.tokenAsked.value = false;
  pageStore.tokenRefusal.value = null;
  answer = null;
  resolve(accepted);
}
