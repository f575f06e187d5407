/**
 * The light on its circle: where it is, how fast it goes, whether it rests. Owns the clock of the light; knows nothing of drawing.
 */
import { effect, signal } from "../vendor/signals-core.js";
import { keep, recall } from "../memory.js";

/** Degrees a second at which the light starts. */
const SPEED = 40;
/** A pause of drawing longer than this does not make the light jump. */
const LONGEST_STEP_S = 0.1;

/** @template T @typedef {import("../vendor/signals-core.js").Signal<T>} Signal */

/** Whether the light goes round. @type {Signal<boolean>} */
export const moving = signal(false);
/** Degrees a second. @type {Signal<number>} */
export const speed = signal(recall("light-speed", SPEED));
/** Where the light rests, in degrees from where the scene's pictures have it; while it moves, where it was last set. @type {Signal<number>} */
export const rest = signal(0);

/** Where it is now, in degrees from there. */
let now = 0;
/** @type {number|null} */
let last = null;

/** Where the light is at that time. @param {number} milliseconds */
export function lightAt(milliseconds) {
  if (!moving.value) {
    last = null;
    return rest.value;
  }
  const seconds = last === null ? 0 : Math.min(LONGEST_STEP_S, (milliseconds - last) / 1000);
  last = milliseconds;
  now = (now + speed.value * seconds + 360) % 360;
  return now;
}

/** Puts the light somewhere, where it rests. @param {number} degrees */
export function placeLight(degrees) {
  now = degrees;
  rest.value = degrees;
  moving.value = false;
}

/** Lets it go, or stops it where it is. @param {boolean} on @param {boolean} [chosen] by a person, who is asked no more */
export function letMove(on, chosen = true) {
  if (!on) rest.value = Math.round(now * 10) / 10;
  moving.value = on;
  if (chosen) keep("light-moves", on);
}

/** What the person chose before; null where nobody chose. @returns {boolean|null} */
export const chosenBefore = () => recall("light-moves", /** @type {boolean|null} */ (null));

/** Keeps the speed for the next visit. */
export const watchLight = () => effect(() => keep("light-speed", speed.value));
