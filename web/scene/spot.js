/**
 * Places of objects beside the one that is bred, the subject, relative to it. Pure functions.
 *
 * @import { Extent } from "../live/camera.js"
 * @import { Scene, SceneObject, Vec3 } from "../model.js"
 */

/**
 * @typedef {{around: number, distance: number, height: number, radius: number}} Spot
 *   Place of an object: degrees around the subject; distance, height above its centre, and own
 *   radius in radii of the subject.
 */

/** @param {Pick<Scene, "mesh"|"scale">} scene @param {Extent} subject */
const radiusOf = (scene, subject) => subject.radius * scene.scale;

/**
 * Puts an object somewhere. The height has no effect on one that stands on the ground.
 * @param {SceneObject} object
 * @param {Spot} spot
 * @param {Scene} scene
 * @param {{subject: Extent, own: Extent}} extents
 * @returns {SceneObject}
 */
export function placed(object, { around, distance, height, radius }, scene, { subject, own }) {
  const unit = radiusOf(scene, subject);
  const angle = (around * Math.PI) / 180;
  const offset = [distance * Math.sin(angle), height, distance * Math.cos(angle)];
  const position = /** @type {Vec3} */ (
    offset.map((along, axis) => subject.centre[axis] + along * unit - own.centre[axis])
  );
  return {
    ...object,
    position,
    scale: Math.min((radius * unit) / own.radius, 1000),
  };
}

/**
 * Where an object is.
 * @param {SceneObject} object
 * @param {Pick<Scene, "mesh"|"scale">} scene
 * @param {{subject: Extent, own: Extent}} extents
 * @returns {Spot}
 */
export function spotOf(object, scene, { subject, own }) {
  const unit = radiusOf(scene, subject);
  const position = object.position ?? [0, 0, 0];
  const [x, y, z] = position.map((at, axis) => at + own.centre[axis] - subject.centre[axis]);
  const degrees = (Math.atan2(x, z) * 180) / Math.PI;
  return {
    around: (degrees + 360) % 360,
    distance: Math.hypot(x, z) / unit,
    height: y / unit,
    radius: ((object.scale ?? 1) * own.radius) / unit,
  };
}

/**
 * Moves and scales objects so that they are beside another subject as they were beside the first.
 * @param {SceneObject[]} objects
 * @param {{from: Scene, to: Scene}} scenes
 * @param {{from: Extent, to: Extent, own: Extent[]}} extents `own`: of the objects
 * @returns {SceneObject[]}
 */
export const besides = (objects, { from, to }, { from: before, to: after, own }) =>
  objects.map((object, index) => {
    const spot = spotOf(object, from, { subject: before, own: own[index] });
    return placed(object, spot, to, { subject: after, own: own[index] });
  });
