/**
 * A photograph as the user set it up: where the object is and where the light makes its spot, and
 * the scene that follows. Pure functions.
 *
 * @import { Scene, Vec3 } from "../model.js"
 * @import { Arrays } from "../live/geometry.js"
 * @import { Extent } from "../live/camera.js"
 * @import { Surface } from "./highlight.js"
 * @import { Area, Circle, PhotoCamera, Point } from "./placement.js"
 */
import { fromDegrees } from "../scene/rotation.js";
import { lightFrom } from "./highlight.js";
import { meshSurfaceAt } from "./mesh.js";
import { cameraOf, fovOfCrop, fovOfLens, rounded, surfaceAt } from "./placement.js";

/**
 * @typedef {{width: number, height: number}} Size
 *
 * @typedef {{size: Size, mesh: string, extent: Extent, circle: Circle, rotation_deg: Vec3,
 *   fov_y_deg: number, surface: Surface, spot: Point, light: Vec3|null, spotByHand: boolean,
 *   cropByHand: boolean, found: boolean}} Placed `fov_y_deg`: of the whole picture; `light`:
 *   direction towards the light, null if the spot is not on the object; `...ByHand`: not guessed
 *   again; `found`: true if a circle was found in the picture.
 */

/** The built-in sphere, which balls are. */
export const BALL = "sphere";
/** Bounding sphere of the ball. @type {Extent} */
export const BALL_EXTENT = { centre: [0, 0, 0], radius: 1 };

/** Lenses, by their focal lengths on film of 36 x 24 mm. */
export const LENSES = [
  { value: "phone", name: "phone", focal_mm: 26, title: "Main camera of a phone, without zoom" },
  { value: "zoom", name: "zoom", focal_mm: 85, title: "Long lens: zoomed in three times" },
  { value: "far", name: "far away", focal_mm: 1200, title: "From far away: almost parallel rays" },
];

/** Bounds of the field of view that scenes allow, with room for crops. */
const FOV_Y_DEG = [0.2, 160];
/** Least side of a crop. */
const LEAST_PX = 8;
/** Margin of a guessed crop around the ball, in radii. */
const MARGIN = 0.25;

/** @param {number} value @param {number} least @param {number} most */
const clamped = (value, least, most) => Math.max(least, Math.min(most, value));

/** @param {Size} size @returns {Area} */
export const wholeOf = ({ width, height }) => ({ x: 0, y: 0, width, height });

/** True if a crop leaves nothing out. @param {Area} crop @param {Size} size */
export const isWhole = (crop, size) => crop.width === size.width && crop.height === size.height;

/**
 * The crop in whole pixels within the picture.
 * @param {Area} crop
 * @param {Size} size
 * @returns {Area}
 */
export function fittingCrop({ x, y, width, height }, size) {
  const left = clamped(Math.round(x), 0, size.width - LEAST_PX);
  const top = clamped(Math.round(y), 0, size.height - LEAST_PX);
  return {
    x: left,
    y: top,
    width: clamped(Math.round(x + width) - left, LEAST_PX, size.width - left),
    height: clamped(Math.round(y + height) - top, LEAST_PX, size.height - top),
  };
}

/** A crop around the object. @param {Circle} circle @param {Size} size @returns {Area} */
export function cropAround({ x, y, radius }, size) {
  const reach = (1 + MARGIN) * radius;
  const [left, top] = [Math.max(0, x - reach), Math.max(0, y - reach)];
  return fittingCrop(
    {
      x: left,
      y: top,
      width: Math.min(size.width, x + reach) - left,
      height: Math.min(size.height, y + reach) - top,
    },
    size,
  );
}

/** Circle for a picture in which none was found. @param {Size} size @returns {Circle} */
export const middleCircle = ({ width, height }) => ({
  x: width / 2,
  y: height / 2,
  radius: 0.35 * Math.min(width, height),
});

/** The lens whose field of view a picture has; empty for another. @param {Placed} of */
export const lensOf = ({ size, fov_y_deg }) =>
  LENSES.find(({ focal_mm }) => Math.abs(fovOfLens(size, focal_mm) - fov_y_deg) < 0.05)?.value ??
  "";

/** Camera of the crop. @param {Placed} of @param {Area} crop @returns {PhotoCamera} */
export function cameraOfPlaced({ circle, extent, fov_y_deg, size }, crop) {
  const fov = clamped(fovOfCrop(fov_y_deg, size.height, crop), FOV_Y_DEG[0], FOV_Y_DEG[1]);
  return cameraOf(circle, crop, fov, extent);
}

/**
 * Direction towards the light, from the spot; null if the spot is not on the object, or the mesh is
 * not loaded.
 * @param {Placed} of
 * @param {Area} crop
 * @param {Arrays|null} arrays of the mesh
 * @returns {Vec3|null}
 */
export function lightOfPlaced(of, crop, arrays) {
  const camera = cameraOfPlaced(of, crop);
  const { spot, extent, rotation_deg, surface, mesh } = of;
  if (mesh === BALL) return lightFrom(surfaceAt(spot, camera, crop, extent), surface);
  const rotation = fromDegrees(rotation_deg);
  return lightFrom(arrays && meshSurfaceAt(spot, camera, crop, arrays, rotation), surface);
}

/**
 * The scene of a photograph. The brightness of its light is unknown: searches solve for a gain.
 * @param {Placed} of
 * @param {Vec3} light
 * @param {Area} crop
 * @returns {Partial<Scene> & {lights: {kind: "directional", direction: Vec3}[]}}
 */
export function sceneOfPlaced(of, light, crop) {
  /** @param {number} part */
  const against = (part) => Number((-part).toFixed(6)) + 0;
  return {
    mesh: of.mesh,
    rotation_deg: of.rotation_deg,
    camera: rounded(cameraOfPlaced(of, crop)),
    lights: [
      { kind: "directional", direction: [against(light[0]), against(light[1]), against(light[2])] },
    ],
    // A ball casts no shadow on itself.
    ...(of.mesh === BALL ? {} : { shadows: true }),
    film: { exposure: "auto", tone: "none" },
  };
}

/** Sides of a picture, counter-clockwise in steps of 45 degrees. */
const SIDES = [
  "right", "upper right", "above", "upper left", "left", "lower left", "below", "lower right",
];

/** Direction of a light in words. @param {Vec3} light */
export function lightInWords([x, y, z]) {
  const degrees = (/** @type {number} */ radians) => Math.round((radians * 180) / Math.PI);
  const off = degrees(Math.acos(clamped(z, -1, 1)));
  if (off < 3) return "from the eye";
  const turn = degrees(Math.atan2(y, x));
  const name = SIDES[(Math.round(turn / 45) + 8) % 8];
  return `from the ${name}, ${off}° from the eye`.replace(/the (above|below)/, "$1");
}
