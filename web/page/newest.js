/** Work for the newest of many values, such as the positions of a slider while it is dragged. */

/**
 * Wraps work so that it runs once at a time. A value that comes during a run waits for its end; of
 * several, only the last is worked on.
 * @template T
 * @param {(value: T) => Promise<void>} work must not fail
 * @returns {(value: T) => Promise<void>}
 */
export function forNewest(work) {
  let running = false;
  /** @type {{value: T}|null} */
  let next = null;
  return async (value) => {
    next = { value };
    if (running) return;
    running = true;
    try {
      while (next) {
        const now = /** @type {{value: T}} */ (next);
        next = null;
        await work(now.value);
      }
    } finally {
      running = false;
    }
  };
}
