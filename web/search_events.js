/**
 * The server's events for the search that is looked at; knows nothing of the page's state.
 *
 * @import { Found, JobState } from "./types.js"
 */
import { eventStream } from "./event_stream.js";
import { jobEventsUrl } from "./search_api.js";

/**
 * @typedef {{state: (news: {state: JobState, reason: string|null}) => void,
 *   progress: (news: {progress: number, generation: number, evaluations: number, seconds: number, fitted: number|null, held: number|null}) => void,
 *   best: (news: Found) => void, reread: () => void}} Listener
 *   `reread`: events may have been missed.
 */

const stream = eventStream();

/** @param {string} id @param {Listener} listener */
export function listenToJob(id, listener) {
  const { state, progress, best, reread } = listener;
  // What happened before the connection was there, or while it was gone, is not told again.
  stream.listen({ url: jobEventsUrl(id), opened: reread, on: { state, progress, best, resync: reread } });
}

/** Nothing is listened to any more: the search has ended, or nobody looks at it. */
export function leaveJob() {
  stream.listen(null);
}

/** Lets the connection rest while nobody looks. */
export const restJobWhileHidden = stream.restWhileHidden;
