/**
 * The server's events for the open lineage. Owns the one EventSource, its reconnection and its rest while the page is
 * hidden (browsers allow six connections to a host, over all tabs); knows nothing of the page's state.
 */
import { eventsUrl } from "./api.js";
import { pictureArrived } from "./pictures.js";

/**
 * @typedef {{known: (id: string) => boolean, news: (id: string) => Promise<void>, resync: () => Promise<void>,
 *   job: (news: any) => void}} Listener
 */

/** @type {EventSource|null} */
let source = null;
/** @type {{lineage: string, listener: Listener}|null} */
let wanted = null;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let reopening;
/** Whether events may have been missed since the last connection. */
let missed = false;
/** A brood that is being made here tells of itself by its own answer. @type {Promise<unknown>} */
let own = Promise.resolve();

/**
 * Holds back `generation` events until this work is done.
 * @param {Promise<unknown>} work
 */
export function holdBack(work) {
  own = Promise.allSettled([own, work]);
}

/**
 * @param {string} lineage
 * @param {Listener} listener
 */
export function listen(lineage, listener) {
  wanted = { lineage, listener };
  missed = false;
  connect();
}

function connect() {
  clearTimeout(reopening);
  source?.close();
  source = null;
  if (!wanted || document.hidden) return;
  const { lineage, listener } = wanted;
  const opened = new EventSource(eventsUrl(lineage));
  source = opened;
  opened.addEventListener("open", () => {
    if (missed) void listener.resync();
    missed = false;
  });
  opened.addEventListener("thumbnail", (event) => {
    const { url } = JSON.parse(event.data);
    pictureArrived(url);
  });
  opened.addEventListener("generation", async (event) => {
    const { id } = JSON.parse(event.data);
    await own;
    if (wanted?.lineage === lineage && !listener.known(id)) await listener.news(id);
  });
  opened.addEventListener("job", (event) => listener.job(JSON.parse(event.data)));
  opened.addEventListener("resync", () => void listener.resync());
  opened.addEventListener("error", () => {
    // A dropped connection reopens by itself and replays; a refused one stays closed and is asked for again.
    if (opened.readyState !== EventSource.CLOSED || source !== opened) return;
    missed = true;
    reopening = setTimeout(connect, 3000);
  });
}

/** Lets the connection rest while nobody looks. */
export function restWhileHidden() {
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) missed = true;
    connect();
  });
}
