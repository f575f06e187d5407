/**
 * Uploads of a scene's files: object, IES profile, environment. One at a time for each place on the
 * page; a newer choice there stops a running one.
 *
 * @import { Place } from "../model.js"
 */
import { sendingBy, wasStopped } from "../api/upload.js";
import { setEntry } from "../page/entry.js";
import { sceneStore } from "./store.js";

/** Stop running uploads. @type {Map<Place, AbortController>} */
const stoppers = new Map();

/** Stops the upload of a place, if one runs. @param {Place} place */
export function stopUpload(place) {
  const present = stoppers.get(place);
  if (!present) return;
  stoppers.delete(place);
  setEntry(sceneStore.uploads, place, null);
  present.abort();
}

/**
 * Uploads a file, and stops an earlier upload of the same place.
 * @template T
 * @param {Place} place
 * @param {File} file
 * @param {(file: File, send: ReturnType<typeof sendingBy>) => Promise<T>} route
 * @returns {Promise<T|null>} the server's answer; null if it was stopped
 */
export async function uploadFile(place, file, route) {
  stopUpload(place);
  const stopper = new AbortController();
  stoppers.set(place, stopper);
  const isMine = () => stoppers.get(place) === stopper;
  setEntry(sceneStore.uploads, place, { name: file.name, sent: 0, whole: file.size });
  /** @param {number} sent @param {number} whole */
  const progress = (sent, whole) => {
    if (isMine()) setEntry(sceneStore.uploads, place, { name: file.name, sent, whole });
  };
  try {
    const answer = await route(file, sendingBy({ progress, signal: stopper.signal }));
    return isMine() ? answer : null;
  } catch (error) {
    if (wasStopped(error)) return null;
    throw error;
  } finally {
    if (isMine()) stopUpload(place);
  }
}
