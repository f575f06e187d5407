/**
 * The light in the server's pictures of scenes that are not drawn here: they are asked for where the light is, in steps,
 * each when the pictures of the last are there, so that neither server nor page falls behind. Owns the steps; knows nothing of frames.
 */
import { signal } from "../vendor/signals-core.js";

/** Places on the circle while the light moves: the pictures of one round are drawn once. */
const PLACES = 24;

/**
 * @typedef {{degrees: number, sharp: boolean}} Still
 *   Where the light is, from where the scene has it, and whether it stays there.
 */

/** Null while the light is where the scene has it. @type {import("../vendor/signals-core.js").Signal<Still|null>} */
export const still = signal(null);

/**
 * The step after this one: first small pictures, then, where the light rests, whole ones.
 * @param {Still|null} now
 * @param {number} degrees
 * @param {boolean} moves
 * @returns {Still|null}
 */
export function nextStill(now, degrees, moves) {
  const place = moves ? (Math.round((degrees * PLACES) / 360) * 360) / PLACES : degrees;
  if (place % 360 === 0) return null;
  const sharp = !moves && now?.degrees === place;
  return now?.degrees === place && now.sharp === sharp ? now : { degrees: place, sharp };
}

/** @param {HTMLImageElement} image */
const isThere = (image) => image.complete;

/** Follows the light, unless pictures of the last step are still awaited. @param {number} degrees @param {boolean} moves */
export function followLight(degrees, moves) {
  const awaited = /** @type {NodeListOf<HTMLImageElement>} */ (document.querySelectorAll("img.still"));
  if ([...awaited].every(isThere)) still.value = nextStill(still.peek(), degrees, moves);
}
