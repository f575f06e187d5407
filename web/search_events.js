/**
 * The server's events for the search that is looked at. Owns the one EventSource, its reconnection and its rest while the page is
 * hidden; knows nothing of the page's state.
 *
 * @import { Found, JobState } from "./types.js"
 */
import { jobEventsUrl } from "./search_api.js";

/**
 * @typedef {{state: (news: {state: JobState, reason: string|null}) => void,
 *   progress: (news: {progress: number, generation: number, evaluations: number, seconds: number, fitted: number|null, held: number|null}) => void,
 *   best: (news: Found) => void, reread: () => void}} Listener
 *   `reread`: events may have been missed.
 */

const AGAIN_MS = 3000;

/** @type {EventSource|null} */
let source = null;
/** @type {{id: string, listener: Listener}|null} */
let wanted = null;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let reopening;

/** @param {string} id @param {Listener} listener */
export function listenToJob(id, listener) {
  wanted = { id, listener };
  connect();
}

/** Nothing is listened to any more: the search has ended, or nobody looks at it. */
export function leaveJob() {
  wanted = null;
  connect();
}

function connect() {
  clearTimeout(reopening);
  source?.close();
  source = null;
  if (!wanted || document.hidden) return;
  const { id, listener } = wanted;
  const opened = new EventSource(jobEventsUrl(id));
  source = opened;
  /** @param {string} name @param {(news: any) => void} take */
  const on = (name, take) =>
    opened.addEventListener(name, (event) => {
      if (source === opened) take(JSON.parse(event.data));
    });
  // What happened before the connection was there, or while it was gone, is not told again.
  opened.addEventListener("open", () => listener.reread());
  on("state", listener.state);
  on("progress", listener.progress);
  on("best", listener.best);
  on("resync", listener.reread);
  opened.addEventListener("error", () => {
    // A dropped connection reopens by itself; a refused one stays closed and is asked for again.
    if (opened.readyState !== EventSource.CLOSED || source !== opened) return;
    reopening = setTimeout(connect, AGAIN_MS);
  });
}

/** Lets the connection rest while nobody looks. */
export function restJobWhileHidden() {
  document.addEventListener("visibilitychange", connect);
}
