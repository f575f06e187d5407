/**
 * Rotations of the object by hand: 3 x 3 matrices, row-major, acting on columns; world
 * right-handed, y up. A scene's `rotation_deg` rotates about x, then y, then z.
 *
 * @import { Camera, Vec3 } from "../model.js"
 */

const DEGREE = Math.PI / 180;

/**
 * @param {number[]} a
 * @param {number[]} b
 * @returns {number[]} a b
 */
function multiply(a, b) {
  const product = [];
  for (let row = 0; row < 3; row += 1) {
    for (let column = 0; column < 3; column += 1) {
      product.push(
        a[3 * row] * b[column] + a[3 * row + 1] * b[3 + column] + a[3 * row + 2] * b[6 + column],
      );
    }
  }
  return product;
}

/**
 * Rotation about a unit axis, counter-clockwise seen from its tip.
 * @param {Vec3} axis
 * @param {number} degrees
 */
export function about([x, y, z], degrees) {
  const c = Math.cos(degrees * DEGREE);
  const s = Math.sin(degrees * DEGREE);
  const t = 1 - c;
  return [
    t * x * x + c, t * x * y - s * z, t * x * z + s * y,
    t * x * y + s * z, t * y * y + c, t * y * z - s * x,
    t * x * z - s * y, t * y * z + s * x, t * z * z + c,
  ];
}

/** @param {Vec3} degrees */
export function fromDegrees([x, y, z]) {
  return multiply(about([0, 0, 1], z), multiply(about([0, 1, 0], y), about([1, 0, 0], x)));
}

/**
 * Angles of a rotation, to a tenth of a degree. At y = +-90 degrees x and z rotate about the same
 * axis; x is 0 there.
 * @param {number[]} m
 * @returns {Vec3}
 */
export function toDegrees(m) {
  const sinY = Math.max(-1, Math.min(1, -m[6]));
  const poles = Math.abs(sinY) > 0.999999;
  const x = poles ? 0 : Math.atan2(m[7], m[8]);
  const y = Math.asin(sinY);
  const z = poles ? Math.atan2(-m[1], m[4]) : Math.atan2(m[3], m[0]);
  /** @param {number} radians */
  const tenths = (radians) => Math.round((radians / DEGREE) * 10) / 10 + 0;
  return [tenths(x), tenths(y), tenths(z)];
}

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** @param {Vec3} a @param {Vec3} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @param {number[]} m @param {Vec3} v @returns {Vec3} */
const apply = (m, v) => [
  m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
  m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
  m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
];

/** @param {Vec3} a @returns {Vec3} */
function unit(a) {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
}

/**
 * Axes of the camera in the world: right, up, and back towards the eye.
 * @param {Camera} camera
 * @returns {{right: Vec3, up: Vec3, back: Vec3}}
 */
export function axes(camera) {
  if (camera.orthographic !== undefined)
    return { right: [1, 0, 0], up: [0, 1, 0], back: [0, 0, 1] };
  /** @type {Vec3} */
  let back;
  /** @type {Vec3} */
  let above = [0, 1, 0];
  if (camera.eye && camera.target) {
    const { eye, target } = camera;
    back = unit([eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]]);
    above = camera.up ?? above;
  } else {
    const [azimuth, elevation] = camera.orbit_deg ?? [30, 20];
    const level = Math.cos(elevation * DEGREE);
    back = [
      Math.sin(azimuth * DEGREE) * level,
      Math.sin(elevation * DEGREE),
      Math.cos(azimuth * DEGREE) * level,
    ];
    // Seen from straight above, the world's up has no direction on the screen; the azimuth still
    // has one.
    if (Math.abs(level) < 1e-6)
      above = [-Math.sin(azimuth * DEGREE), 0, -Math.cos(azimuth * DEGREE)];
  }
  const right = unit(cross(above, back));
  return { right, up: cross(back, right), back };
}

/**
 * Rotation after a drag that holds the front of the object.
 * @param {number[]} start
 * @param {Camera} camera
 * @param {number} rightDegrees drag to the right
 * @param {number} downDegrees drag downwards
 */
export function dragged(start, camera, rightDegrees, downDegrees) {
  const { right, up } = axes(camera);
  return multiply(about(up, rightDegrees), multiply(about(right, downDegrees), start));
}

/**
 * Three great circles of a rotated object as the camera sees them: pieces of the front and of the
 * back, in [-1, 1] with y down.
 * @param {number[]} rotation
 * @param {Camera} camera
 * @returns {{front: boolean, points: string}[]}
 */
export function globe(rotation, camera) {
  const { right, up, back } = axes(camera);
  const pieces = [];
  for (let axis = 0; axis < 3; axis += 1) {
    /** @type {{front: boolean, points: string}|null} */
    let piece = null;
    for (let at = 0; at <= 72; at += 1) {
      const angle = (at / 72) * 2 * Math.PI;
      /** @type {Vec3} */
      const local = [0, 0, 0];
      local[axis] = Math.cos(angle);
      local[(axis + 1) % 3] = Math.sin(angle);
      const point = apply(rotation, local);
      const text = `${dot(point, right).toFixed(3)},${(-dot(point, up)).toFixed(3)} `;
      const front = dot(point, back) >= 0;
      if (!piece || piece.front !== front) {
        if (piece) piece.points += text;
        piece = { front, points: "" };
        pieces.push(piece);
      }
      piece.points += text;
    }
  }
  return pieces;
}
