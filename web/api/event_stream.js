/**
 * Streams of server-sent events: one EventSource each, reopened after a refusal and closed while
 * the page is hidden, because browsers allow six connections to a host over all tabs. Independent
 * of the content of events.
 */

/** Delay before a refused connection is opened again. */
const AGAIN_MS = 3000;

/**
 * @typedef {{url: string, opened: (missed: boolean) => void, lost?: () => void, on:
 *   Record<string, (news: any) => void>}} Subscription `lost`: called when a connection breaks.
 *   `opened`: called at every connection; `missed` if events may be lost that the server does not
 *   repeat. `on`: functions by the name of the event that they take.
 */

/** Creates a stream without a subscription, that is without a connection. */
export function eventStream() {
  /** @type {EventSource|null} */
  let source = null;
  /** @type {Subscription|null} */
  let wanted = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let reopening;
  /** True if events may have been missed since the last connection. */
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
      // A dropped connection reopens by itself and replays what followed the last event that it
      // received, if any. A refused connection stays closed and is reopened here.
      missed = true;
      lost?.();
      if (own.readyState !== EventSource.CLOSED) return;
      reopening = setTimeout(connect, AGAIN_MS);
    });
  }

  return {
    /** Replaces the subscription. @param {Subscription|null} heard */
    listen(heard) {
      wanted = heard;
      missed = false;
      connect();
    },

    /** Closes the connection while the page is hidden. */
    pauseWhileHidden() {
      document.addEventListener("visibilitychange", connect);
    },
  };
}
