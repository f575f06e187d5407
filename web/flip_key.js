/**
 * What flips between two pictures: tapped it stays flipped, held it shows the other for as long as it is held. Owns the clock of
 * that; knows nothing of what is flipped.
 */

/** Let go later than this it was held. */
const HELD_MS = 350;

/** @param {() => void} flip @returns {{down: (now: number) => void, up: (now: number) => void}} times in milliseconds */
export function flipKey(flip) {
  /** When it went down; 0 while it is up. */
  let since = 0;
  return {
    down(now) {
      since = now;
      flip();
    },
    up(now) {
      if (since > 0 && now - since > HELD_MS) flip();
      since = 0;
    },
  };
}

/**
 * The handlers of a button that does the same by hand and by key.
 * @param {ReturnType<typeof flipKey>} key
 */
export function holdable(key) {
  /** @param {KeyboardEvent} event */
  const presses = (event) => event.key === " " || event.key === "Enter";
  return {
    /** @param {PointerEvent} event */
    onPointerDown: (event) => event.button === 0 && key.down(event.timeStamp),
    /** @param {PointerEvent} event */
    onPointerUp: (event) => key.up(event.timeStamp),
    /** @param {PointerEvent} event */
    onPointerLeave: (event) => key.up(event.timeStamp),
    /** @param {PointerEvent} event */
    onPointerCancel: (event) => key.up(event.timeStamp),
    /** @param {KeyboardEvent} event */
    onKeyDown: (event) => {
      if (!presses(event)) return;
      event.preventDefault();
      if (!event.repeat) key.down(event.timeStamp);
    },
    /** @param {KeyboardEvent} event */
    onKeyUp: (event) => {
      if (!presses(event)) return;
      event.preventDefault();
      key.up(event.timeStamp);
    },
    /** A screen reader clicks without pressing anything. @param {MouseEvent} event */
    onClick: (event) => {
      if (event.detail > 0) return;
      key.down(event.timeStamp);
      key.up(event.timeStamp);
    },
    /** A long touch is no wish for a menu. @param {Event} event */
    onContextMenu: (event) => event.preventDefault(),
  };
}
