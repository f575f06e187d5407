/**
 * Signing in with an access token, which the browser keeps as a cookie that no script can read.
 */
import { loadSetting, saveSetting } from "../page/memory.js";
import { pageStore } from "../page/store.js";
import { problemOf } from "./request.js";
import { createSession, deleteSession } from "./routes.js";
import { answerTokenQuestion } from "./token.js";

/** @param {boolean} given */
function rememberToken(given) {
  pageStore.tokenGiven.value = given;
  saveSetting("token-given", given);
}

export function loadTokenState() {
  pageStore.tokenGiven.value = loadSetting("token-given", false);
}

/**
 * Sends a token to the server, and shows its refusal in the open question.
 * @param {string} token
 */
export async function signIn(token) {
  try {
    await createSession(token);
    rememberToken(true);
    answerTokenQuestion(true);
  } catch (error) {
    pageStore.tokenRefusal.value = problemOf(error);
  }
}

/** Removes the cookie; the next refused request asks for a token again. */
export async function forgetToken() {
  await deleteSession();
  rememberToken(false);
}
