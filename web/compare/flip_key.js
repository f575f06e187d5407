/**
 * A key that flips between two pictures: a tap flips for good, holding shows the other picture
 * until release. Independent of the pictures.
 */

/** A press that lasts longer counts as holding. */
const HELD_MS = 350;

/**
 * @param {() => void} flip
 * @returns {{down: (now: number) => void, up: (now: number) => void}} with times in milliseconds
 */
export function makeFlipKey(flip) {
  /** Time of the press; 0 while the key is up. */
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
 * Event handlers of a button that works like the key.
 * @param {ReturnType<typeof makeFlipKey>} key
 */
export function flipHandlers(key) {
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
    /** Screen readers send a click without a press. @param {MouseEvent} event */
    onClick: (event) => {
      if (event.detail > 0) return;
      key.down(event.timeStamp);
      key.up(event.timeStamp);
    },
    /** A long touch must not open a menu. @param {Event} event */
    onContextMenu: (event) => event.preventDefault(),
  };
}
