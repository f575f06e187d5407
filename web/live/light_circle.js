/** The light on its circle: angle, speed, and whether it moves. */
import { effect } from "../vendor/signals-core.js";
import { loadSetting, saveSetting } from "../page/memory.js";
import { liveStore } from "./store.js";

/** Longest time step; a longer pause of drawing must not make the light jump. */
const LONGEST_STEP_S = 0.1;

/** Present angle, in degrees from the light's place in the scene. */
let now = 0;
/** Time of the last drawing under the moving light. @type {number|null} */
let last = null;

/** Angle of the light at a time. @param {number} milliseconds */
export function lightAt(milliseconds) {
  if (!liveStore.lightMoving.value) {
    last = null;
    return liveStore.restAngle.value;
  }
  const seconds = last === null ? 0 : Math.min(LONGEST_STEP_S, (milliseconds - last) / 1000);
  last = milliseconds;
  now = (now + liveStore.lightSpeed.value * seconds + 360) % 360;
  return now;
}

/** Stops the light at an angle. @param {number} degrees */
export function restLightAt(degrees) {
  now = degrees;
  liveStore.restAngle.value = degrees;
  liveStore.lightMoving.value = false;
}

/**
 * Starts the light, or stops it where it is.
 * @param {boolean} on
 * @param {boolean} [chosen] true if the user did it, which is remembered
 */
export function setLightMoving(on, chosen = true) {
  if (!on) liveStore.restAngle.value = Math.round(now * 10) / 10;
  liveStore.lightMoving.value = on;
  if (chosen) saveSetting("light-moves", on);
}

/** The user's last choice; null if there was none. @returns {boolean|null} */
export const savedChoice = () => loadSetting("light-moves", /** @type {boolean|null} */ (null));

/** Saves the speed for the next visit. */
export const watchLight = () =>
  effect(() => saveSetting("light-speed", liveStore.lightSpeed.value));
