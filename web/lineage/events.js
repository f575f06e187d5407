/**
 * The server's events of the open lineage. Reports them to a listener.
 */
import { eventStream } from "../api/event_stream.js";
import { eventsUrl } from "../api/routes.js";
import { clearOutages } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { pictureAvailable, retryFailed } from "./pictures.js";

/**
 * @typedef {{id: string, favourite: boolean, note: string, version: number}} IndividualNews
 *
 * @typedef {{known: (id: string) => boolean, onNewGeneration: (id: string) => Promise<void>,
 *   onLineageChanged: (version: number) => Promise<void>, onIndividualChanged: (news:
 *   IndividualNews) => void, onJob: (news: any) => void, resync: (all: boolean) =>
 *   Promise<void>}} Listener `known`: true if the page has that generation. `resync`: reads what
 *   may have changed; `all` if events were missed.
 */

const stream = eventStream();
/** Id of the lineage whose events are read. */
let listenedLineage = "";
/**
 * Resolves when this page is breeding nothing. Its own broods arrive in the answers to its
 * requests, so their events are ignored.
 * @type {Promise<unknown>}
 */
let localBreeds = Promise.resolve();

/**
 * Delays `generation` events until this work is done.
 * @param {Promise<unknown>} work
 */
export function deferGenerationEvents(work) {
  localBreeds = Promise.allSettled([localBreeds, work]);
}

/**
 * Reads the events of a lineage, in place of those of the last one.
 * @param {string} lineage
 * @param {Listener} listener
 */
export function listenToLineage(lineage, listener) {
  listenedLineage = lineage;
  stream.listen({
    url: eventsUrl(lineage),
    lost: () => {
      pageStore.connectionLost.value = true;
    },
    // After the first connection too: something may have changed since the lineage was read.
    opened: (missed) => {
      pageStore.connectionLost.value = false;
      clearOutages();
      retryFailed();
      void listener.resync(missed);
    },
    on: {
      thumbnail: ({ url }) => pictureAvailable(url),
      generation: async ({ id }) => {
        await localBreeds;
        if (listenedLineage === lineage && !listener.known(id)) await listener.onNewGeneration(id);
      },
      lineage: ({ version }) => void listener.onLineageChanged(version),
      individual: listener.onIndividualChanged,
      job: listener.onJob,
      resync: () => void listener.resync(true),
    },
  });
}

/** Closes the connection while the page is hidden. */
export const pauseWhileHidden = stream.pauseWhileHidden;
