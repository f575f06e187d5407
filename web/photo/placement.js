/**
 * Where the object of a photograph is: from the circle that its bounding sphere covers in the
 * picture to the camera of a scene, and back. Pure functions; the same projection as the server's
 * `sample_set/view.rs`. The camera looks along -z with y up, so that directions of the world are
 * right, up and towards the eye in the picture.
 *
 * Positions in the picture are pixels of the whole picture from its top left corner; the centre of
 * the first pixel is at 0.5, 0.5.
 *
 * @import { Camera, Vec3 } from "../model.js"
 * @import { Extent } from "../live/camera.js"
 */

const DEGREE = Math.PI / 180;
/** Diagonal of the film that focal lengths of lenses refer to, in millimetres. */
const FILM_DIAGONAL_MM = 43.27;
/** Rounds of the solution; the error shrinks tenfold in each for objects that fill the picture. */
const ROUNDS = 60;

/**
 * @typedef {{x: number, y: number}} Point
 *
 * @typedef {{x: number, y: number, width: number, height: number}} Area Part of a picture.
 *
 * @typedef {{x: number, y: number, radius: number}} Circle
 *
 * @typedef {{eye: Vec3, target: Vec3, up: Vec3, fov_y_deg: number}} PhotoCamera
 */

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** @param {Vec3} a @param {Vec3} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @param {Vec3} a @returns {Vec3} */
export function unit(a) {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
}

/**
 * Vertical field of view of a picture taken by a lens, in degrees.
 * @param {{width: number, height: number}} size of the picture
 * @param {number} focal_mm focal length, converted to film of 36 x 24 mm as on cameras
 */
export function fovOfLens({ width, height }, focal_mm) {
  const focal_px = (focal_mm / FILM_DIAGONAL_MM) * Math.hypot(width, height);
  return (2 * Math.atan(height / 2 / focal_px)) / DEGREE;
}

/**
 * Vertical field of view of a crop, in degrees. The camera of the crop looks through its middle.
 * @param {number} fov_y_deg of the whole picture
 * @param {number} height of the whole picture
 * @param {Area} crop
 */
export const fovOfCrop = (fov_y_deg, height, crop) =>
  (2 * Math.atan((Math.tan((fov_y_deg / 2) * DEGREE) * crop.height) / height)) / DEGREE;

/**
 * A position on the plane at distance 1 from the eye, x to the right and y upwards.
 * @param {Point} at
 * @param {Area} crop
 * @param {number} fov_y_deg of the crop
 * @returns {Point}
 */
function toPlane(at, crop, fov_y_deg) {
  const scale = Math.tan((fov_y_deg / 2) * DEGREE) / (crop.height / 2);
  return {
    x: (at.x - crop.x - crop.width / 2) * scale,
    y: (crop.y + crop.height / 2 - at.y) * scale,
  };
}

/**
 * Inverse of toPlane.
 * @param {Point} at
 * @param {Area} crop
 * @param {number} fov_y_deg
 * @returns {Point}
 */
function fromPlane(at, crop, fov_y_deg) {
  const scale = crop.height / 2 / Math.tan((fov_y_deg / 2) * DEGREE);
  return {
    x: crop.x + crop.width / 2 + at.x * scale,
    y: crop.y + crop.height / 2 - at.y * scale,
  };
}

/**
 * Camera that sees a sphere in a circle of the picture. Away from the middle a sphere is seen as
 * an ellipse: this one has the circle's centre and area.
 *
 * A cone of half-angle a, whose axis is at the angle t from that of the camera, cuts the plane in
 * an ellipse. With k = cos^2 t - sin^2 a its centre is at sin t cos t / k, and its half axes are
 * sin a cos a / k and sin a / sqrt(k).
 * @param {Circle} circle
 * @param {Area} crop
 * @param {number} fov_y_deg of the crop
 * @param {Extent} extent of the object
 * @returns {PhotoCamera}
 */
export function cameraOf(circle, crop, fov_y_deg, { centre, radius }) {
  const middle = toPlane(circle, crop, fov_y_deg);
  const across = Math.hypot(middle.x, middle.y);
  const size = (circle.radius * Math.tan((fov_y_deg / 2) * DEGREE)) / (crop.height / 2);
  let tilt = Math.atan(across);
  let sine = size * Math.cos(tilt) ** 2;
  sine /= Math.sqrt(1 + sine * sine);
  for (let round = 0; round < ROUNDS; round += 1) {
    const cosine2 = Math.cos(tilt) ** 2;
    const k = Math.max(1e-6, cosine2 - sine * sine);
    tilt = Math.atan(across * (1 - (sine * sine) / cosine2));
    // Half of the step keeps large spheres from overshooting.
    const next = Math.sqrt((size * size * k ** 1.5) / Math.sqrt(1 - sine * sine));
    sine = Math.min(0.999, 0.5 * (sine + next));
  }
  const distance = radius / sine;
  const side = across > 0 ? (Math.sin(tilt) * distance) / across : 0;
  /** @type {Vec3} */
  const eye = [
    centre[0] - middle.x * side,
    centre[1] - middle.y * side,
    centre[2] + Math.cos(tilt) * distance,
  ];
  return { eye, target: [eye[0], eye[1], centre[2]], up: [0, 1, 0], fov_y_deg };
}

/**
 * Position in the picture of a point of the world; null behind the eye.
 * @param {Vec3} world
 * @param {PhotoCamera} camera
 * @param {Area} crop
 * @returns {Point|null}
 */
export function project(world, camera, crop) {
  const [x, y, z] = minus(world, camera.eye);
  if (z >= -1e-9) return null;
  return fromPlane({ x: x / -z, y: y / -z }, crop, camera.fov_y_deg);
}

/**
 * Circle of a sphere with the centre and area of the ellipse that the camera sees: the inverse of
 * cameraOf.
 * @param {PhotoCamera} camera
 * @param {Area} crop
 * @param {Extent} extent
 * @returns {Circle}
 */
export function circleOf(camera, crop, { centre, radius }) {
  const [x, y, z] = minus(centre, camera.eye);
  const distance = Math.hypot(x, y, z);
  const sine = radius / distance;
  const k = (z / distance) ** 2 - sine * sine;
  // sin t cos t / k along the direction in which the sphere is off the axis.
  const factor = -z / (distance * distance * k);
  const area = (sine * sine * Math.sqrt(1 - sine * sine)) / k ** 1.5;
  const at = fromPlane({ x: x * factor, y: y * factor }, crop, camera.fov_y_deg);
  const scale = crop.height / 2 / Math.tan((camera.fov_y_deg / 2) * DEGREE);
  return { ...at, radius: Math.sqrt(area) * scale };
}

/**
 * Direction from the eye through a position of the picture, a unit vector.
 * @param {Point} at
 * @param {PhotoCamera} camera
 * @param {Area} crop
 */
export function rayThrough(at, camera, crop) {
  const plane = toPlane(at, crop, camera.fov_y_deg);
  return unit([plane.x, plane.y, -1]);
}

/**
 * Normal of a sphere and direction to the eye at a position of the picture, unit vectors; null
 * outside of the sphere.
 * @param {Point} at
 * @param {PhotoCamera} camera
 * @param {Area} crop
 * @param {Extent} extent
 * @returns {{normal: Vec3, eye: Vec3}|null}
 */
export function surfaceAt(at, camera, crop, { centre, radius }) {
  const ray = rayThrough(at, camera, crop);
  const to = minus(centre, camera.eye);
  const along = dot(to, ray);
  // Of far spheres the product of distances would lose digits.
  const beside = minus(to, [along * ray[0], along * ray[1], along * ray[2]]);
  const inside = radius * radius - dot(beside, beside);
  if (inside < 0) return null;
  const depth = Math.sqrt(inside);
  return {
    normal: unit([
      -beside[0] - depth * ray[0],
      -beside[1] - depth * ray[1],
      -beside[2] - depth * ray[2],
    ]),
    eye: [-ray[0], -ray[1], -ray[2]],
  };
}

/**
 * The camera of a scene with numbers that can be read.
 * @param {PhotoCamera} camera
 * @returns {Camera}
 */
export function rounded({ eye, target, up, fov_y_deg }) {
  /** @param {number} value */
  const digits = (value) => Number(value.toPrecision(10));
  /** @param {Vec3} v @returns {Vec3} */
  const each = ([x, y, z]) => [digits(x), digits(y), digits(z)];
  return { eye: each(eye), target: each(target), up, fov_y_deg: digits(fov_y_deg) };
}
