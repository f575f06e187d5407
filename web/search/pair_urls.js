/**
 * Addresses of the pictures of a search's result and of its target.
 *
 * @import { Found, Job, Target } from "../model.js"
 */
import { pictureUrl } from "../api/routes.js";
import { besideTargetUrl, inViewUrl, ownPictureUrl, targetUrl, targetViewUrl } from "./routes.js";
import { hasEnded } from "./words.js";

/** Side of the pictures. */
const SIDE_PX = 384;
/** Side while the search runs, because the next result comes soon. */
const QUICK_PX = 256;

/** True for a target of pictures, false for a measured one. @param {Target} of */
export const isPictures = (of) => (of.views ?? []).length > 0;

/**
 * @typedef {{find: string|null, target: string|null}} PairUrls `find`: of the result; null where
 *   there is no picture, or not yet
 */

/**
 * Addresses of a result's picture and of the target's picture to compare it with.
 * @param {{of: Found|null, within: Job, to: Target|null, scene: string|null, view: number,
 *   viewScene: string|null, light: number|null}} what `scene`: of the result's lineage;
 *   `viewScene`: of the target's picture
 * @returns {PairUrls}
 */
export function pairUrls({ of, within, to, scene, view, viewScene, light }) {
  const size = hasEnded(within) ? SIDE_PX : QUICK_PX;
  if (to && isPictures(to)) {
    if (light === null)
      return {
        find: of && inViewUrl(of.individual, to.id, view),
        target: targetViewUrl(to.id, view),
      };
    return {
      find: of && viewScene && pictureUrl(of.individual, viewScene, SIDE_PX, light),
      target: null,
    };
  }
  if (to && scene)
    return {
      find: of && besideTargetUrl(of.individual, to.id, scene, size, light),
      target: targetUrl(to.id, scene, size, light),
    };
  if (!of) return { find: null, target: null };
  const drawn = light === null && !hasEnded(within) && of.thumbnail;
  return { find: drawn || ownPictureUrl(of.individual, SIDE_PX, light), target: null };
}
