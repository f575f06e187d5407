/**
 * Streams of the server's events. Owns the EventSource of each, its reconnection and its rest while the page is hidden (browsers allow
 * six connections to a host, over all tabs); knows nothing of what the events say.
 */

const AGAIN_MS = 3000;

/**
 * @typedef {{url: string, opened: (missed: boolean) => void, lost?: () => void, on: Record<string, (news: any) => void>}} Heard
 *   `lost`: told when a connection breaks. `opened`: told of every connection, and whether events may have been missed that the server does not tell again.
 */

/** A stream that nothing is heard of yet. */
export function eventStream() {
  /** @type {EventSource|null} */
  let source = null;
  /** @type {Heard|null} */
  let wanted = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let reopening;
  /** Since the last connection. */
  let missed = false;

  function connect() {
    clearTimeout(reopening);
    source?.close();
    source = null;
    if (!wanted) return;
    if (document.hidden) {
      missed = true;
      return;
    }
    const { url, opened, lost, on } = wanted;
    const own = new EventSource(url);
    source = own;
    own.addEventListener("open", () => {
      opened(missed);
      missed = false;
    });
    for (const [name, take] of Object.entries(on)) {
      own.addEventListener(name, (event) => {
        if (source === own) take(JSON.parse(event.data));
      });
    }
    own.addEventListener("error", () => {
      if (source !== own) return;
      // A dropped connection reopens by itself and replays what came after the last event it heard, if it heard one; a refused one stays
      // closed and is asked for again.
      missed = true;
      lost?.();
      if (own.readyState !== EventSource.CLOSED) return;
      reopening = setTimeout(connect, AGAIN_MS);
    });
  }

  return {
    /** Listens to this, and to nothing else any more. @param {Heard|null} heard */
    listen(heard) {
      wanted = heard;
      missed = false;
      connect();
    },

    /** Lets the connection rest while nobody looks. */
    restWhileHidden() {
      document.addEventListener("visibilitychange", connect);
    },
  };
}
