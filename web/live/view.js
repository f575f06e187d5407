/**
 * Where the camera and the lights of a scene are, in the frame of the unturned object: the centre of its bounding sphere is 0,
 * its radius 1. Pure functions; what the server's `sample_set/view.rs` and `lighting.rs` do, in the same words.
 *
 * @import { Camera, Scene, Vec3 } from "../types.js"
 */
import { strengthField } from "../light_color.js";
import { about, axes, fromDegrees } from "../turn.js";

/** Lights that are added up at most. */
export const LIGHTS = 8;
/** Distance of a framing camera over the one at which the bounding sphere touches the picture's edge. */
const FRAMING_MARGIN = 1.04;
/** Azimuth, elevation and distance in radii of a light that has no place of its own. */
const PLACED = { azimuth: 65, elevation: 45, radii: 4 };

const DEGREE = Math.PI / 180;

/**
 * @typedef {{centre: Vec3, radius: number}} Extent
 *
 * @typedef {{eye: Vec3, right: Vec3, up: Vec3, forward: Vec3, half: number, parallel: boolean, near: number, far: number}} View
 *   `half` is half the height of what is seen: at distance 1, or anywhere where rays are parallel.
 *
 * @typedef {{place: Vec3, intensity: Vec3}} PointLight
 */

/** @param {number[]} m @param {Vec3} v @returns {Vec3} the transpose of m times v */
const unturn = (m, [x, y, z]) => [m[0] * x + m[3] * y + m[6] * z, m[1] * x + m[4] * y + m[7] * z, m[2] * x + m[5] * y + m[8] * z];

/** @param {number[]} m @param {Vec3} v @returns {Vec3} */
const turn = (m, [x, y, z]) => [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z];

/** @param {Vec3} v @param {number} s @returns {Vec3} */
const scaled = (v, s) => [v[0] * s, v[1] * s, v[2] * s];

/** @param {Vec3} v @returns {Vec3} */
const negated = (v) => scaled(v, -1);

/** @param {number} azimuth @param {number} elevation @returns {Vec3} */
function orbit(azimuth, elevation) {
  const level = Math.cos(elevation * DEGREE);
  return [Math.sin(azimuth * DEGREE) * level, Math.sin(elevation * DEGREE), Math.cos(azimuth * DEGREE) * level];
}

/** A place of the world relative to the centre, in radii. @param {Vec3} world @param {Extent} extent @returns {Vec3} */
const relative = (world, { centre, radius }) => [
  (world[0] - centre[0]) / radius,
  (world[1] - centre[1]) / radius,
  (world[2] - centre[2]) / radius,
];

/** How the object is turned, as a scene says it. @param {Scene} scene */
export const rotationOf = (scene) => fromDegrees(scene.rotation_deg);

/**
 * @param {Camera} camera
 * @param {Extent} extent
 * @param {{rotation: number[], scale: number}} pose of the object
 * @returns {View}
 */
export function viewOf(camera, extent, { rotation, scale }) {
  const { right, up, back } = axes(camera);
  const turned = { right: unturn(rotation, right), up: unturn(rotation, up), forward: unturn(rotation, negated(back)) };
  if (camera.orthographic !== undefined) {
    const middle = relative([0, 0, 0], extent);
    const eye = scaled(unturn(rotation, [middle[0], middle[1], 2 * scale]), 1 / scale);
    return { ...turned, eye, half: camera.orthographic / extent.radius / scale, parallel: true, near: 0, far: 4 };
  }
  const fov = camera.fov_y_deg ?? 30;
  const half = Math.tan(0.5 * fov * DEGREE);
  /** @type {Vec3} */
  let from;
  if (camera.eye) from = relative(camera.eye, extent);
  else {
    const distance = camera.distance ? camera.distance / extent.radius : FRAMING_MARGIN / Math.sin(0.5 * fov * DEGREE);
    from = scaled(back, distance);
  }
  const eye = scaled(unturn(rotation, from), 1 / scale);
  const distance = Math.hypot(...eye);
  return { ...turned, eye, half, parallel: false, near: Math.max(distance - 1.01, distance * 1e-3), far: distance + 1.01 };
}

/**
 * Whether frames can be drawn here: by a few point lights with an intensity or none said, without shadows and tone curves, on
 * curved surfaces.
 * @param {Scene} scene
 */
export const isDrawable = (scene) =>
  !scene.shadows &&
  (scene.lights ?? []).length <= LIGHTS &&
  (scene.normals ?? "curved") === "curved" &&
  (scene.film.tone ?? "none") === "none" &&
  (scene.lights ?? []).every((light) => (light.kind ?? "point") === "point" && strengthField(light) !== null);

/** @param {import("../types.js").Channels|undefined} strength @returns {Vec3|null} */
const channels = (strength) => (typeof strength === "number" ? [strength, strength, strength] : (strength ?? null));

/**
 * @param {Pick<Scene, "lights">} scene
 * @param {Extent} extent
 * @param {{rotation: number[], scale: number}} pose
 * @param {number} lightDeg how far the lights have gone round
 * @returns {PointLight[]}
 */
export function lightsOf(scene, extent, { rotation, scale }, lightDeg) {
  const circle = about([0, 1, 0], lightDeg);
  const length = scale * extent.radius;
  return (scene.lights ?? []).map((light) => {
    const from = light.position ? relative(light.position, extent) : scaled(orbit(PLACED.azimuth, PLACED.elevation), PLACED.radii);
    const place = scaled(unturn(rotation, turn(circle, from)), 1 / scale);
    const squared = place[0] ** 2 + place[1] ** 2 + place[2] ** 2;
    const given = channels(light.intensity);
    /** @type {Vec3} */
    const intensity = given ? scaled(given, 1 / length ** 2) : [Math.PI * squared, Math.PI * squared, Math.PI * squared];
    return { place, intensity };
  });
}

/**
 * How strong the strongest of the lights is, over one that gives irradiance pi at the middle; 1 where all are dark.
 * @param {PointLight[]} lights
 */
export function strengthOf(lights) {
  const strengths = lights.map(({ place, intensity }) => Math.max(...intensity) / (Math.PI * (place[0] ** 2 + place[1] ** 2 + place[2] ** 2)));
  return Math.max(0, ...strengths) || 1;
}

/**
 * The lights over their common strength, which automatic exposure takes out again.
 * @param {PointLight[]} lights
 * @param {number} strength
 * @returns {PointLight[]}
 */
export const evenedOut = (lights, strength) => lights.map((light) => ({ ...light, intensity: scaled(light.intensity, 1 / strength) }));

/**
 * Where a light is seen from the middle of the picture: to the right, upwards and towards the eye, a unit vector.
 * @param {PointLight} light
 * @param {View} view
 * @returns {Vec3}
 */
export function seenAt({ place }, { right, up, forward }) {
  const length = Math.hypot(...place) || 1;
  /** @param {Vec3} axis */
  const along = (axis) => (place[0] * axis[0] + place[1] * axis[1] + place[2] * axis[2]) / length;
  return [along(right), along(up), -along(forward)];
}
