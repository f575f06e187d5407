/**
 * Places of all parts of a scene: the object that is bred (the subject), the other objects, the
 * ground. Pure functions; the same computation as the server's `stage.rs`.
 *
 * @import { Scene, Vec3 } from "../model.js"
 * @import { Extent, View } from "./camera.js"
 */
import { fromDegrees } from "../scene/rotation.js";
import { rotate, rotateBack } from "./camera.js";

/** Half the side of the ground, in radii of the subject. */
const GROUND_RADII = 1000;
/** Gap between an object and the ground below it, in radii of the subject. */
const GROUND_GAP = 1e-3;

/**
 * @typedef {{turn: number[], offset: Vec3, size: number}} Place Moves the unit frame of a mesh to
 *   that of the subject: a point is turned, multiplied by `size`, and moved by `offset`.
 *
 * @typedef {{extent: Extent, positions: Float32Array}} Shape `positions`: relative to the centre,
 *   in radii
 *
 * @typedef {{places: Place[], framed: number, reach: number, all: number}} Stage
 *   `framed`: distance from the subject's centre that cameras frame by default; `reach`: one that
 *   encloses subject and objects; `all`: one that also encloses the ground; in radii of the
 *   subject's mesh at scale 1.
 */

/** Place of the subject. @type {Place} */
export const SUBJECT = { turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], offset: [0, 0, 0], size: 1 };

/** Heights of lowest vertices by mesh, with the rotation of the last. */
const heights = /** @type {WeakMap<Float32Array, {up: string, lowest: number}>} */ (new WeakMap());

/**
 * Height of the lowest vertex of a rotated mesh above its centre, in radii.
 * @param {Shape} of
 * @param {number[]} turn
 */
function lowestOf({ positions }, turn) {
  const up = rotateBack(turn, [0, 1, 0]);
  const key = up.join();
  const known = heights.get(positions);
  if (known?.up === key) return known.lowest;
  let lowest = Number.POSITIVE_INFINITY;
  for (let at = 0; at < positions.length; at += 3)
    lowest = Math.min(
      lowest,
      positions[at] * up[0] + positions[at + 1] * up[1] + positions[at + 2] * up[2],
    );
  heights.set(positions, { up: key, lowest });
  return lowest;
}

/**
 * @param {Pick<Scene, "objects"|"ground">} scene
 * @param {{rotation: number[], scale: number}} pose of the subject
 * @param {Shape[]} shapes of the subject, the objects, and the ground if there is one
 * @returns {Stage}
 */
export function stageOf({ objects = [], ground }, { rotation, scale }, shapes) {
  const { centre, radius } = shapes[0].extent;
  /**
   * Height of the lowest vertex of a mesh that is scaled and rotated about its centre.
   * @param {Shape} shape @param {number[]} turn @param {number} by
   */
  const lowest = (shape, turn, by) =>
    shape.extent.centre[1] + lowestOf(shape, turn) * shape.extent.radius * by;
  /** @param {Shape} shape @param {Vec3} position @param {number[]} turn @param {number} by */
  const placed = ({ extent }, position, turn, by) => {
    const from = /** @type {Vec3} */ (
      position.map((at, axis) => (extent.centre[axis] + at - centre[axis]) / radius)
    );
    const columns = [0, 1, 2].map((k) =>
      rotateBack(rotation, [turn[k], turn[3 + k], turn[6 + k]]),
    );
    const [x, y, z] = rotateBack(rotation, from);
    const own = (by * extent.radius) / radius;
    /** @type {Place} */
    const place = {
      turn: [0, 1, 2].flatMap((row) => columns.map((column) => column[row])),
      offset: [x / scale, y / scale, z / scale],
      size: own / scale,
    };
    return { place, extends: Math.hypot(...from) + own };
  };
  const gap = GROUND_GAP * radius * scale;
  const height = ground ? (ground.height ?? lowest(shapes[0], rotation, scale) - gap) : null;
  const others = objects.map((object, index) => {
    const shape = shapes[1 + index];
    const turn = fromDegrees(object.rotation_deg ?? [0, 0, 0]);
    const by = object.scale ?? 1;
    const [x, y, z] = object.position ?? [0, 0, 0];
    const stands = object.stands && height !== null;
    return placed(shape, [x, stands ? height + gap - lowest(shape, turn, by) : y, z], turn, by);
  });
  const reach = Math.max(0, ...others.map((one) => one.extends));
  if (height !== null) {
    const half = GROUND_RADII * radius * scale;
    const at = /** @type {Vec3} */ ([centre[0], height, centre[2]]);
    others.push(placed(shapes[shapes.length - 1], at, SUBJECT.turn, half));
  }
  return {
    places: [SUBJECT, ...others.map((one) => one.place)],
    framed: Math.max(1, reach),
    reach: Math.max(scale, reach),
    all: Math.max(scale, ...others.map((one) => one.extends)),
  };
}

/**
 * The view as an object at a place sees it.
 * @param {View} view in the unit frame of the subject
 * @param {Place} place
 * @returns {View}
 */
export function viewFrom(view, place) {
  if (place === SUBJECT) return view;
  const { turn, offset, size } = place;
  const [x, y, z] = view.eye;
  const eye = rotateBack(turn, [x - offset[0], y - offset[1], z - offset[2]]);
  return {
    ...view,
    eye: [eye[0] / size, eye[1] / size, eye[2] / size],
    right: rotateBack(turn, view.right),
    up: rotateBack(turn, view.up),
    forward: rotateBack(turn, view.forward),
    world: view.world.map((axis) => rotateBack(turn, axis)),
    half: view.parallel ? view.half / size : view.half,
    near: view.near / size,
    far: view.far / size,
  };
}

/**
 * Moves a point to the unit frame of the subject.
 * @param {Place} place
 * @param {Vec3} point
 * @returns {Vec3}
 */
export function moved({ turn, offset, size }, point) {
  const [x, y, z] = rotate(turn, point);
  return [x * size + offset[0], y * size + offset[1], z * size + offset[2]];
}
