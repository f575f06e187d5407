/**
 * Downloads: requests that are retried like all others, with progress, a way to stop them, and an
 * error on the page instead of a broken file.
 *
 * @import { Place } from "../model.js"
 */
import { read, readParts } from "../api/request.js";
import { wasStopped } from "../api/upload.js";
import { setEntry } from "./entry.js";
import { guarded } from "./problem.js";
import { pageStore } from "./store.js";

/** Some browsers read the address of a saved file later. */
const KEPT_MS = 10_000;

/** Saves a file that the page has. @param {Blob} file @param {string} name */
export function saveFile(file, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(file);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), KEPT_MS);
}

/**
 * Reads a body and reports its bytes.
 * @param {Response} response
 * @param {(received: number, whole: number|null) => void} progress
 */
async function received(response, progress) {
  const length = Number(response.headers.get("Content-Length"));
  const whole = length > 0 && !response.headers.get("Content-Encoding") ? length : null;
  /** @type {Uint8Array<ArrayBuffer>[]} */
  const parts = [];
  let count = 0;
  await readParts(response, (part) => {
    parts.push(part);
    count += part.length;
    progress(count, whole);
  });
  return new Blob(parts, { type: response.headers.get("Content-Type") ?? "" });
}

/**
 * Downloads a file. A second call for the same name is ignored while the first runs.
 * @param {string} path
 * @param {string} name of the file
 * @param {Place} place where a failure is shown
 * @param {string} [accept] media type
 */
export async function download(path, name, place, accept) {
  if (pageStore.downloads.value.has(name)) return;
  const stopper = new AbortController();
  const stop = () => stopper.abort();
  await guarded(place, async () => {
    setEntry(pageStore.downloads, name, { received: 0, whole: null, stop });
    try {
      const response = await read(path, { accept, signal: stopper.signal });
      const file = await received(response, (count, whole) =>
        setEntry(pageStore.downloads, name, { received: count, whole, stop }),
      );
      saveFile(file, name);
      pageStore.announcement.value = `${name} is saved.`;
    } catch (error) {
      if (!wasStopped(error)) throw error;
    } finally {
      setEntry(pageStore.downloads, name, null);
    }
  });
}
