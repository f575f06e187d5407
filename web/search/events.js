/**
 * The server's events of the open search.
 *
 * @import { Found, JobState } from "../model.js"
 */
import { eventStream } from "../api/event_stream.js";
import { jobEventsUrl } from "./routes.js";

/**
 * @typedef {{state: (news: {state: JobState, reason: string|null}) => void, progress: (news:
 *   {progress: number, generation: number, evaluations: number, seconds: number, fitted:
 *   number|null, held: number|null}) => void, best: (news: Found) => void, reread: () =>
 *   void}} Listener `reread`: called if events may have been missed.
 */

const stream = eventStream();

/** @param {string} id @param {Listener} listener */
export function listenToJob(id, listener) {
  const { state, progress, best, reread } = listener;
  // Events before the connection, or while it was broken, are not repeated.
  stream.listen({
    url: jobEventsUrl(id),
    opened: reread,
    on: { state, progress, best, resync: reread },
  });
}

/** Ends the subscription, because the search has ended or its view was left. */
export function leaveJob() {
  stream.listen(null);
}

/** Closes the connection while the page is hidden. */
export const pauseJobWhileHidden = stream.pauseWhileHidden;
