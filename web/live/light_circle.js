/**
 * The light on its circle: angle, speed, and whether it moves. The angle of a resting light is
 * stored in the scene, so that all pictures, exports and visitors have it.
 */
import { batch, effect } from "../vendor/signals-core.js";
import { loadSetting, saveSetting } from "../page/memory.js";
import { changeScene } from "../scene/edit.js";
import { commitLight } from "../scene/light_controls.js";
import { sceneStore } from "../scene/store.js";
import { liveStore } from "./store.js";

/** Longest time step; a longer pause of drawing must not make the light jump. */
const LONGEST_STEP_S = 0.1;

/** Angle of the moving light in degrees, as a scene's `light_deg`. */
let now = 0;
/** Time of the last drawing under the moving light. @type {number|null} */
let last = null;
/** True if the user has placed the light since the page was opened. */
let placed = false;

/** Angle from 0 to 360 of the light at rest. */
export const restAngle = () => (((sceneStore.editedScene.value?.light_deg ?? 0) % 360) + 360) % 360;

/** Angle of the light at a time. @param {number} milliseconds */
export function lightAt(milliseconds) {
  if (!liveStore.lightMoving.value) {
    last = null;
    return sceneStore.editedScene.value?.light_deg ?? 0;
  }
  const seconds = last === null ? 0 : Math.min(LONGEST_STEP_S, (milliseconds - last) / 1000);
  last = milliseconds;
  now = (now + liveStore.lightSpeed.value * seconds + 360) % 360;
  return now;
}

/** Angle of the moving light; null while it rests at the scene's. */
export const movingAngle = () => (liveStore.lightMoving.peek() ? rounded(now) : null);

/** @param {number} degrees */
const rounded = (degrees) => Math.round(degrees * 10) / 10;

/** Stops the light, and moves it while its slider is dragged. @param {number} degrees */
export function dragAngle(degrees) {
  placed = true;
  batch(() => {
    sceneStore.draggedScene.value = { light_deg: degrees };
    liveStore.lightMoving.value = false;
  });
}

/** Commits the dragged angle to the scene. */
export const commitAngle = commitLight;

/**
 * Starts the light, or stops it where it is.
 * @param {boolean} on
 * @param {boolean} [chosen] true if the user did it, which is remembered
 */
export function setLightMoving(on, chosen = true) {
  if (on === liveStore.lightMoving.value || (on && !liveStore.lightCircles.value)) return;
  if (on) now = restAngle();
  placed = true;
  batch(() => {
    if (!on) void changeScene("light", () => ({ light_deg: rounded(now) }));
    liveStore.lightMoving.value = on;
  });
  if (chosen) saveSetting("light-moves", on);
}

/** The user's last choice; null if there was none. @returns {boolean|null} */
const savedChoice = () => loadSetting("light-moves", /** @type {boolean|null} */ (null));

/**
 * Starts the light at the first drawing, unless the user has placed it meanwhile.
 * @param {boolean} byDefault if the user has not chosen in an earlier visit
 */
export function startLight(byDefault) {
  if (!placed && (savedChoice() ?? byDefault)) setLightMoving(true, false);
}

/** Saves the speed for the next visit, and stops the light if none is left that circles. */
export function watchLight() {
  effect(() => saveSetting("light-speed", liveStore.lightSpeed.value));
  effect(() => {
    if (!liveStore.lightCircles.value) liveStore.lightMoving.value = false;
  });
}
