/**
 * The light of a photograph from the spot that it makes on a ball. Pure functions. On a glossy
 * surface the spot is a highlight: the light is the mirror image of the eye about the normal there.
 * A matt surface is brightest where its normal points to the light.
 *
 * @import { Vec3 } from "../model.js"
 * @import { Extent } from "../live/camera.js"
 * @import { Area, PhotoCamera, Point } from "./placement.js"
 */
import { dot, project, unit } from "./placement.js";

/** @typedef {"glossy"|"matt"} Surface */

/** Rounds of the solution: the eye's direction hardly changes over the ball. */
const ROUNDS = 20;

/**
 * Direction towards the light of a spot, a unit vector.
 * @param {{normal: Vec3, eye: Vec3}|null} at the surface at the spot; null if it is on none
 * @param {Surface} surface
 * @returns {Vec3|null}
 */
export function lightFrom(at, surface) {
  if (!at) return null;
  const { normal, eye } = at;
  if (surface === "matt") return normal;
  const cosine = dot(normal, eye);
  return unit([
    2 * cosine * normal[0] - eye[0],
    2 * cosine * normal[1] - eye[1],
    2 * cosine * normal[2] - eye[2],
  ]);
}

/**
 * Spot that a light makes on the ball, the inverse of lightFrom; null if the eye does not see it.
 * @param {Vec3} light direction towards the light
 * @param {Surface} surface
 * @param {PhotoCamera} camera
 * @param {Area} crop
 * @param {Extent} extent
 * @returns {Point|null}
 */
export function spotOf(light, surface, camera, crop, extent) {
  const { centre, radius } = extent;
  const towards = unit(light);
  /** @param {Vec3} normal @returns {Vec3} */
  const on = (normal) => [
    centre[0] + radius * normal[0],
    centre[1] + radius * normal[1],
    centre[2] + radius * normal[2],
  ];
  /** @param {Vec3} point @returns {Vec3} */
  const eyeFrom = (point) =>
    unit([
      camera.eye[0] - point[0],
      camera.eye[1] - point[1],
      camera.eye[2] - point[2],
    ]);
  let normal = towards;
  if (surface === "glossy") {
    let eye = eyeFrom(centre);
    for (let round = 0; round < ROUNDS; round += 1) {
      normal = unit([towards[0] + eye[0], towards[1] + eye[1], towards[2] + eye[2]]);
      eye = eyeFrom(on(normal));
    }
  }
  const point = on(normal);
  return dot(normal, eyeFrom(point)) > 0 ? project(point, camera, crop) : null;
}

/**
 * Angle between two directions, degrees.
 * @param {Vec3} a
 * @param {Vec3} b
 */
export function angleBetween(a, b) {
  const [x, y] = [unit(a), unit(b)];
  const half = Math.hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]) / 2;
  return (2 * Math.asin(Math.min(1, half)) * 180) / Math.PI;
}
