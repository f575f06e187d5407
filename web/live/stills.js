/**
 * Light in the server's pictures of scenes that cannot be drawn live. The pictures follow the light
 * in steps; each step waits for the pictures of the last one, so that neither server nor page falls
 * behind.
 */
import { sceneStore } from "../scene/store.js";
import { liveStore } from "./store.js";

/**
 * Places on the circle while the light moves, so that each picture is rendered once for all rounds.
 */
const PLACES = 24;

/**
 * @typedef {{degrees: number, sharp: boolean, scene?: string, generation?: string}} Still
 *   Angle of the light as a scene's `light_deg`; `sharp` where the light rests there;
 *   `scene`, `generation`: ids of what the pictures show.
 */

/**
 * The next step: small pictures first, then full ones where the light rests.
 * @param {Still|null} now
 * @param {number} degrees
 * @param {boolean} moves
 * @param {number} own angle of the confirmed scene
 * @returns {Still|null}
 */
export function nextStill(now, degrees, moves, own) {
  const place = moves ? (Math.round((degrees * PLACES) / 360) * 360) / PLACES : degrees;
  if ((place - own) % 360 === 0) return null;
  const sharp = !moves && now?.degrees === place;
  return now?.degrees === place && now.sharp === sharp ? now : { degrees: place, sharp };
}

/** True if a picture is loaded. @param {HTMLImageElement} image */
const isThere = (image) => image.complete;

/**
 * Follows the light, unless pictures of the last step are still loading.
 * @param {number} degrees
 * @param {boolean} moves
 * @param {string} generation
 */
export function followLight(degrees, moves, generation) {
  const awaited = /** @type {NodeListOf<HTMLImageElement>} */ (
    document.querySelectorAll("img.still")
  );
  if (![...awaited].every(isThere)) return;
  const { id: scene, light_deg: own = 0 } = sceneStore.scene.peek() ?? {};
  const before = liveStore.still.peek();
  const now = before?.scene === scene && before?.generation === generation ? before : null;
  const next = nextStill(now, degrees, moves, own);
  if (next !== before) liveStore.still.value = next && { ...next, scene, generation };
}
