/**
 * The server's events for the open lineage; knows nothing of the page's state.
 */
import { signal } from "./vendor/signals-core.js";
import { eventsUrl } from "./api.js";
import { eventStream } from "./event_stream.js";
import { askForFailed, pictureArrived } from "./pictures.js";

/**
 * @typedef {{known: (id: string) => boolean, news: (id: string) => Promise<void>, resync: (all: boolean) => Promise<void>,
 *   changed: (version: number) => Promise<void>, marked: (news: {id: string, favourite: boolean, note: string, version: number}) => void,
 *   job: (news: any) => void}} Listener
 */

const stream = eventStream();
/** Whether the stream is broken: the server is away, or has no place for one more listener. @type {import("./vendor/signals-core.js").Signal<boolean>} */
export const away = signal(false);
/** The lineage that is listened to. */
let heard = "";
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
  heard = lineage;
  stream.listen({
    url: eventsUrl(lineage),
    lost: () => {
      away.value = true;
    },
    // Also at first: something may have happened between the reading of the list and now.
    opened: (missed) => {
      away.value = false;
      askForFailed();
      void listener.resync(missed);
    },
    on: {
      thumbnail: ({ url }) => pictureArrived(url),
      generation: async ({ id }) => {
        await own;
        if (heard === lineage && !listener.known(id)) await listener.news(id);
      },
      lineage: ({ version }) => void listener.changed(version),
      individual: listener.marked,
      job: listener.job,
      resync: () => void listener.resync(true),
    },
  });
}

/** Lets the connection rest while nobody looks. */
export const restWhileHidden = stream.restWhileHidden;
