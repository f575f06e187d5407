/**
 * Meshes in photographs: what a ray from the eye hits, and the outline over the picture. Pure
 * functions. Rotations are 3 x 3 matrices, row by row. Positions of vertices are relative to the
 * centre of the bounding sphere, in its radii.
 *
 * @import { Vec3 } from "../model.js"
 * @import { Arrays } from "../live/geometry.js"
 * @import { Area, PhotoCamera, Point } from "./placement.js"
 */
import { project, rayThrough, unit } from "./placement.js";

/** Meshes with more triangles have no outline: it takes too long while they are dragged. */
const MOST_TRIANGLES = 150_000;

/** @param {number[]} m @param {ArrayLike<number>} v @returns {Vec3} */
const turned = (m, v) => [
  m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
  m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
  m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
];

/** @param {number[]} m @param {Vec3} v @returns {Vec3} */
const turnedBack = (m, v) => turned([m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]], v);

/**
 * Normal of a mesh and direction to the eye at a position of the picture, unit vectors; null beside
 * the mesh.
 * @param {Point} at
 * @param {PhotoCamera} camera
 * @param {Area} crop
 * @param {Arrays} arrays
 * @param {number[]} rotation about the centre
 * @returns {{normal: Vec3, eye: Vec3}|null}
 */
export function meshSurfaceAt(at, camera, crop, arrays, rotation) {
  const { positions, normals, corners, extent } = arrays;
  const ray = rayThrough(at, camera, crop);
  const { centre, radius } = extent;
  const from = turnedBack(rotation, [
    (camera.eye[0] - centre[0]) / radius,
    (camera.eye[1] - centre[1]) / radius,
    (camera.eye[2] - centre[2]) / radius,
  ]);
  const [dx, dy, dz] = turnedBack(rotation, ray);
  let nearest = Number.POSITIVE_INFINITY;
  /** @type {Vec3|null} */
  let normal = null;
  for (let k = 0; k < corners.length; k += 3) {
    const a = 3 * corners[k];
    const b = 3 * corners[k + 1];
    const c = 3 * corners[k + 2];
    // Without arrays: this runs for each triangle at each step of a drag.
    const ux = positions[b] - positions[a];
    const uy = positions[b + 1] - positions[a + 1];
    const uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a];
    const vy = positions[c + 1] - positions[a + 1];
    const vz = positions[c + 2] - positions[a + 2];
    const px = dy * vz - dz * vy;
    const py = dz * vx - dx * vz;
    const pz = dx * vy - dy * vx;
    const determinant = ux * px + uy * py + uz * pz;
    if (determinant === 0) continue;
    const sx = from[0] - positions[a];
    const sy = from[1] - positions[a + 1];
    const sz = from[2] - positions[a + 2];
    const u = (sx * px + sy * py + sz * pz) / determinant;
    if (u < 0 || u > 1) continue;
    const qx = sy * uz - sz * uy;
    const qy = sz * ux - sx * uz;
    const qz = sx * uy - sy * ux;
    const v = (dx * qx + dy * qy + dz * qz) / determinant;
    const t = (vx * qx + vy * qy + vz * qz) / determinant;
    if (v < 0 || u + v > 1 || t <= 0 || t >= nearest) continue;
    nearest = t;
    /** @param {number} j */
    const mixed = (j) =>
      (1 - u - v) * normals[a + j] + u * normals[b + j] + v * normals[c + j];
    normal = unit(turned(rotation, [mixed(0), mixed(1), mixed(2)]));
  }
  return normal && { normal, eye: [-ray[0], -ray[1], -ray[2]] };
}

/**
 * Lines around a mesh as the eye sees it: edges between a triangle that faces the eye and one that
 * does not, each as four numbers, in pixels of the picture. Empty for meshes that are too large.
 * @param {PhotoCamera} camera
 * @param {Area} crop
 * @param {Arrays} arrays
 * @param {number[]} rotation
 * @returns {{outline: number[], front: number[]}} `front`: triangles that face the eye, six numbers
 *   each
 */
export function seenMesh(camera, crop, arrays, rotation) {
  const { positions, corners, extent } = arrays;
  /** @type {{outline: number[], front: number[]}} */
  const seen = { outline: [], front: [] };
  if (corners.length > 3 * MOST_TRIANGLES) return seen;
  const { centre, radius } = extent;
  const points = new Float64Array((2 * positions.length) / 3);
  for (let k = 0; k < positions.length / 3; k += 1) {
    const [x, y, z] = turned(rotation, positions.subarray(3 * k, 3 * k + 3));
    const point = project(
      [centre[0] + radius * x, centre[1] + radius * y, centre[2] + radius * z],
      camera,
      crop,
    );
    points[2 * k] = point ? point.x : Number.NaN;
    points[2 * k + 1] = point ? point.y : Number.NaN;
  }
  const edges = edgesOf(arrays);
  const facing = new Int8Array(edges.count);
  for (let k = 0; k < corners.length; k += 3) {
    const [a, b, c] = [2 * corners[k], 2 * corners[k + 1], 2 * corners[k + 2]];
    // y points down in the picture: triangles that face the eye turn clockwise.
    const area =
      (points[b] - points[a]) * (points[c + 1] - points[a + 1]) -
      (points[b + 1] - points[a + 1]) * (points[c] - points[a]);
    const isFront = area < 0;
    if (isFront)
      seen.front.push(points[a], points[a + 1], points[b], points[b + 1], points[c], points[c + 1]);
    for (let side = 0; side < 3; side += 1) facing[edges.of[k + side]] += isFront ? 1 : 0;
  }
  for (let edge = 0; edge < edges.count; edge += 1) {
    if (facing[edge] !== 1) continue;
    const [a, b] = [2 * edges.ends[2 * edge], 2 * edges.ends[2 * edge + 1]];
    seen.outline.push(points[a], points[a + 1], points[b], points[b + 1]);
  }
  return seen;
}

/** @typedef {{count: number, of: Uint32Array, ends: number[]}} Edges edge of each corner */

/** @type {WeakMap<Arrays, Edges>} */
const known = new WeakMap();

/**
 * Edges of a mesh; vertices at the same place count as one.
 * @param {Arrays} arrays
 * @returns {Edges}
 */
function edgesOf(arrays) {
  const before = known.get(arrays);
  if (before) return before;
  const { positions, corners } = arrays;
  /** @type {Map<string, number>} */
  const places = new Map();
  const place = Uint32Array.from({ length: positions.length / 3 }, (_, k) => {
    // Vertices at a seam may differ by rounding.
    const key = [0, 1, 2].map((j) => Math.round(positions[3 * k + j] * 1e5)).join();
    const found = places.get(key);
    if (found !== undefined) return found;
    places.set(key, k);
    return k;
  });
  /** @type {Map<number, number>} */
  const numbers = new Map();
  const of = new Uint32Array(corners.length);
  /** @type {number[]} */
  const ends = [];
  for (let k = 0; k < corners.length; k += 1) {
    const [from, to] = [place[corners[k]], place[corners[k % 3 === 2 ? k - 2 : k + 1]]];
    const key = Math.min(from, to) * (positions.length / 3) + Math.max(from, to);
    let number = numbers.get(key);
    if (number === undefined) {
      number = numbers.size;
      numbers.set(key, number);
      ends.push(from, to);
    }
    of[k] = number;
  }
  const edges = { count: numbers.size, of, ends };
  known.set(arrays, edges);
  return edges;
}
