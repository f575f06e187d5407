/**
 * Camera and lights of a scene in the frame of the unrotated object, with its bounding sphere as
 * the unit sphere. Pure functions; the same computation as the server's `sample_set/view.rs` and
 * `lighting.rs`.
 *
 * @import { Camera, Scene, Vec3 } from "../model.js"
 * @import { Cone } from "./cone.js"
 * @import { Stage } from "./stage.js"
 */
import { EVERY_WAY, coneOf } from "./cone.js";
import { strengthField } from "../scene/light_color.js";
import { hasNormalMaps } from "../scene/normal_map.js";
import { about, axes, fromDegrees } from "../scene/rotation.js";

/** Largest number of lights. */
export const LIGHTS = 8;
/**
 * Distance of a framing camera, relative to where the bounding sphere touches the picture's edge.
 */
const FRAMING_MARGIN = 1.04;
/**
 * Nearest visible distance before a ground, relative to that of the subject: the ground may be just
 * below the eye.
 */
const NEAR_GROUND = 0.02;
/** Default position of a light: azimuth, elevation, and distance in radii. */
const PLACED = { azimuth: 65, elevation: 45, radii: 4 };
/**
 * Distance at which a directional light is drawn as a point light, radii: a power of 2, so that
 * strengths stay exact. Its direction then changes by 1e-4 over a ground.
 */
const FAR = 2 ** 24;

const DEGREE = Math.PI / 180;
/** @type {Vec3} */
const DOWN = [0, -1, 0];
/** The world's axes. @type {Vec3[]} */
const WORLD = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];

/**
 * @typedef {{centre: Vec3, radius: number}} Extent bounding sphere
 *
 * @typedef {{eye: Vec3, right: Vec3, up: Vec3, forward: Vec3, world: Vec3[], half: number,
 *   parallel: boolean, near: number, far: number}} View `world`: the world's axes; `half` is half
 *   the visible height: at distance 1, or anywhere if rays are parallel. `near` and `far` enclose
 *   the object.
 *
 * @typedef {{place: Vec3, intensity: Vec3, cone: Cone, index: number, degrees: number}} PointLight
 *   With lengths in radii: irradiance at normal incidence is intensity over squared distance,
 *   within the cone of a spot light; a directional light is far away. `index`: among the lights of
 *   the scene other than environments; `degrees`: how far it has gone round.
 */

/** @param {number[]} m @param {Vec3} v @returns {Vec3} the transpose of m times v */
export const rotateBack = (m, [x, y, z]) => [
  m[0] * x + m[3] * y + m[6] * z,
  m[1] * x + m[4] * y + m[7] * z,
  m[2] * x + m[5] * y + m[8] * z,
];

/** @param {number[]} m @param {Vec3} v @returns {Vec3} */
export const rotate = (m, [x, y, z]) => [
  m[0] * x + m[1] * y + m[2] * z,
  m[3] * x + m[4] * y + m[5] * z,
  m[6] * x + m[7] * y + m[8] * z,
];

/** @param {Vec3} v @param {number} s @returns {Vec3} */
const scaled = (v, s) => [v[0] * s, v[1] * s, v[2] * s];

/** @param {Vec3} v @returns {Vec3} */
const negated = (v) => scaled(v, -1);

/** @param {number} azimuth @param {number} elevation @returns {Vec3} */
function orbit(azimuth, elevation) {
  const level = Math.cos(elevation * DEGREE);
  return [
    Math.sin(azimuth * DEGREE) * level,
    Math.sin(elevation * DEGREE),
    Math.cos(azimuth * DEGREE) * level,
  ];
}

/**
 * Converts a world position to radii from the centre.
 * @param {Vec3} world
 * @param {Extent} extent
 * @returns {Vec3}
 */
const relative = (world, { centre, radius }) => [
  (world[0] - centre[0]) / radius,
  (world[1] - centre[1]) / radius,
  (world[2] - centre[2]) / radius,
];

/** Rotation of the object in a scene. @param {Scene} scene */
export const rotationOf = (scene) => fromDegrees(scene.rotation_deg);

/**
 * Camera as the object sees it.
 * @param {Camera} camera
 * @param {Extent} extent
 * @param {{rotation: number[], scale: number}} pose of the object
 * @param {Pick<Stage, "framed"|"reach"|"all">} [stage] the objects around it; default: none
 * @returns {View}
 */
export function viewOf(camera, extent, { rotation, scale }, stage) {
  const { framed, reach, all } = stage ?? { framed: 1, reach: scale, all: scale };
  const { right, up, back } = axes(camera);
  const turned = {
    right: rotateBack(rotation, right),
    up: rotateBack(rotation, up),
    forward: rotateBack(rotation, negated(back)),
    world: WORLD.map((axis) => rotateBack(rotation, axis)),
  };
  if (camera.orthographic !== undefined) {
    const middle = relative([0, 0, 0], extent);
    const eye = scaled(rotateBack(rotation, [middle[0], middle[1], 2 * reach]), 1 / scale);
    return {
      ...turned,
      eye,
      half: camera.orthographic / extent.radius / scale,
      parallel: true,
      near: 0,
      far: (2 * reach + 2 * all) / scale,
    };
  }
  const fov = camera.fov_y_deg ?? 30;
  const half = Math.tan(0.5 * fov * DEGREE);
  /** @type {Vec3} */
  let from;
  if (camera.eye) from = relative(camera.eye, extent);
  else {
    const distance = camera.distance
      ? camera.distance / extent.radius
      : (framed * FRAMING_MARGIN) / Math.sin(0.5 * fov * DEGREE);
    from = scaled(back, distance);
  }
  const eye = scaled(rotateBack(rotation, from), 1 / scale);
  const distance = Math.hypot(...eye);
  const near = Math.max(distance - (1.01 * reach) / scale, distance * 1e-3);
  return {
    ...turned,
    eye,
    half,
    parallel: false,
    near: all > reach ? Math.min(near, distance * NEAR_GROUND) : near,
    far: distance + (1.01 * all) / scale,
  };
}

/** Lights other than environments. @param {Pick<Scene, "lights">} scene */
const lampsOf = ({ lights }) => (lights ?? []).filter(({ kind }) => kind !== "environment");

/** True if there are objects beside the subject, or a ground. @param {Scene} scene */
export const hasOthers = ({ objects, ground }) => Boolean(ground) || (objects ?? []).length > 0;

/**
 * Names of the materials of the objects beside the subject, and of the ground; empty for neutral
 * grey.
 * @param {Scene} scene
 */
export const materialsOf = ({ objects, ground }) =>
  [...(objects ?? []), ...(ground ? [ground] : [])].map(({ material }) => material ?? "");

/**
 * True if a scene can be drawn live: environments and a few point, directional or spot lights of
 * the strength that the page adjusts or the default one, curved normals, no normal map, and no
 * environment where there are shadows, other objects or a ground.
 * @param {Scene} scene
 */
export const isDrawable = (scene) =>
  (!(scene.shadows || hasOthers(scene)) || lampsOf(scene).length === (scene.lights ?? []).length) &&
  !(hasOthers(scene) && scene.backdrop?.kind === "environment") &&
  !hasNormalMaps(scene) &&
  lampsOf(scene).length <= LIGHTS &&
  (scene.normals ?? "curved") === "curved" &&
  lampsOf(scene).every(
    (light) =>
      ["point", "directional", "spot"].includes(light.kind ?? "point") && strengthField(light) !== null,
  );

/** @param {import("../model.js").Channels|undefined} strength @returns {Vec3|null} */
export const channels = (strength) =>
  typeof strength === "number" ? [strength, strength, strength] : (strength ?? null);

/**
 * Lights other than environments as the object sees them.
 * @param {Pick<Scene, "lights">} scene
 * @param {Extent} extent
 * @param {{rotation: number[], scale: number}} pose
 * @param {number} lightDeg how far the lights have gone round
 * @returns {PointLight[]}
 */
export function lightsOf(scene, extent, { rotation, scale }, lightDeg) {
  const circle = about([0, 1, 0], lightDeg);
  const length = scale * extent.radius;
  return lampsOf(scene).map((light, index) => {
    if (light.kind === "directional") {
      const { direction } = light;
      const from = direction ? negated(direction) : orbit(PLACED.azimuth, PLACED.elevation);
      const turned = rotateBack(rotation, rotate(circle, from));
      const place = scaled(turned, FAR / Math.hypot(...turned));
      const irradiance = channels(light.irradiance_w_m2) ?? [Math.PI, Math.PI, Math.PI];
      const intensity = scaled(irradiance, FAR ** 2);
      return { place, intensity, cone: EVERY_WAY, index, degrees: lightDeg };
    }
    const from = light.position
      ? relative(light.position, extent)
      : scaled(orbit(PLACED.azimuth, PLACED.elevation), PLACED.radii);
    const place = scaled(rotateBack(rotation, rotate(circle, from)), 1 / scale);
    const squared = place[0] ** 2 + place[1] ** 2 + place[2] ** 2;
    const given = channels(light.intensity);
    /** @type {Vec3} */
    const intensity = given
      ? scaled(given, 1 / length ** 2)
      : [Math.PI * squared, Math.PI * squared, Math.PI * squared];
    if (light.kind !== "spot")
      return { place, intensity, cone: EVERY_WAY, index, degrees: lightDeg };
    // By default towards the centre; down if the light is at the centre.
    const aimed = light.axis ? rotateBack(rotation, rotate(circle, light.axis)) : negated(place);
    const norm = Math.hypot(...aimed);
    const axis = norm > 0 ? scaled(aimed, 1 / norm) : rotateBack(rotation, DOWN);
    return { place, intensity, cone: coneOf(light, axis), index, degrees: lightDeg };
  });
}

/**
 * Irradiance at the centre by a light, in the brightest channel; 0 if the light is at the centre.
 * @param {Pick<PointLight, "place"|"intensity">} light
 */
export function irradianceAtCentre({ place, intensity }) {
  const squared = place[0] ** 2 + place[1] ** 2 + place[2] ** 2;
  return squared > 0 ? Math.max(...intensity) / squared : 0;
}

/**
 * Strength of the strongest light, relative to one that gives irradiance pi at the centre; 1 if all
 * are dark.
 * @param {PointLight[]} lights
 */
export function strengthOf(lights) {
  return Math.max(0, ...lights.map((light) => irradianceAtCentre(light) / Math.PI)) || 1;
}

/**
 * Divides lights by their common strength, which automatic exposure would cancel.
 * @param {PointLight[]} lights
 * @param {number} strength
 * @returns {PointLight[]}
 */
export const normalizedLights = (lights, strength) =>
  lights.map((light) => ({ ...light, intensity: scaled(light.intensity, 1 / strength) }));

/**
 * Direction of a light from the middle of the picture, a unit vector: right, up, towards the eye.
 * @param {PointLight} light
 * @param {View} view
 * @returns {Vec3}
 */
export function directionSeen({ place }, { right, up, forward }) {
  const length = Math.hypot(...place) || 1;
  /** @param {Vec3} axis */
  const along = (axis) => (place[0] * axis[0] + place[1] * axis[1] + place[2] * axis[2]) / length;
  return [along(right), along(up), -along(forward)];
}
