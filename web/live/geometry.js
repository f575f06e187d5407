/**
 * Meshes in the server's binary format, decoded and uploaded to the GPU. Little-endian: the magic;
 * u32 version, numbers of vertices and triangles, and 1 if there are texture coordinates; f64
 * centre and radius of the bounding sphere; f32 positions, normals, tangents and texture
 * coordinates; u32 vertices of the triangles' corners.
 *
 * @import { Scene } from "../model.js"
 * @import { Extent } from "./camera.js"
 */
import { getBytes } from "../api/request.js";

const MAGIC = "broodgeo";
/** Delay before a failed request is repeated. */
const AGAIN_MS = 5000;
/** Number of bytes before the arrays. */
export const HEAD_BYTES = 56;

/**
 * @typedef {{extent: Extent, positions: Float32Array, within: number, corners: number, vertices:
 *   WebGLVertexArrayObject, buffers: WebGLBuffer[]}} Geometry `within`: bound on the texture
 *   coordinates; `corners`: three times the number of triangles.
 *
 * @typedef {{extent: Extent, positions: Float32Array, normals: Float32Array,
 *   tangents: Float32Array, uvs: Float32Array, corners: Uint32Array}} Arrays
 */

/**
 * Bounding sphere of a mesh, which its head contains.
 * @param {ArrayBuffer} bytes
 * @returns {Extent}
 */
export function readExtent(bytes) {
  const head = new DataView(bytes);
  const magic = String.fromCharCode(...new Uint8Array(bytes, 0, 8));
  if (magic !== MAGIC || head.getUint32(8, true) !== 1)
    throw new Error("the geometry is of another version than the page");
  return {
    centre: [head.getFloat64(24, true), head.getFloat64(32, true), head.getFloat64(40, true)],
    radius: head.getFloat64(48, true),
  };
}

/** @param {ArrayBuffer} bytes @returns {Arrays} */
export function readGeometry(bytes) {
  const extent = readExtent(bytes);
  const head = new DataView(bytes);
  const vertices = head.getUint32(12, true);
  const triangles = head.getUint32(16, true);
  let at = HEAD_BYTES;
  /** @param {number} count */
  const floats = (count) => {
    const array = new Float32Array(bytes, at, count);
    at += 4 * count;
    return array;
  };
  const positions = floats(3 * vertices);
  const normals = floats(3 * vertices);
  const tangents = floats(3 * vertices);
  const uvs = floats(2 * vertices);
  const corners = new Uint32Array(bytes, at, 3 * triangles);
  return {
    extent,
    positions,
    normals,
    tangents,
    uvs,
    corners,
  };
}

/**
 * Bound on the texture coordinates of a mesh, interpolated ones included. Slightly above a power of
 * two, so that most objects have the same bound and share generated code.
 * @param {Float32Array} uvs
 */
function reach(uvs) {
  let most = 1;
  for (const at of uvs) most = Math.max(most, Math.abs(at));
  return Math.min(65504, 1.0625 * 2 ** Math.ceil(Math.log2(most)));
}

/**
 * Path of a file of a scene's mesh.
 * @param {Pick<Scene, "mesh"|"sphere_pole">} scene
 * @param {"geometry"|"mesh.glb"} file
 */
export const meshPath = ({ mesh, sphere_pole: pole }, file) =>
  `/v1/meshes/${mesh}/${file}${pole === "z" ? "?sphere_pole=z" : ""}`;

/**
 * Paths of the geometry of all parts of a scene: the subject, the other objects, the ground.
 * @param {Scene} scene
 */
export const partPaths = (scene) => [
  meshPath(scene, "geometry"),
  ...(scene.objects ?? []).map(({ mesh = "sphere" }) => meshPath({ mesh }, "geometry")),
  ...(scene.ground ? [meshPath({ mesh: "ground" }, "geometry")] : []),
];

/**
 * Requests a mesh and uploads it.
 * @param {WebGL2RenderingContext} gl
 * @param {string} path of its geometry
 * @returns {Promise<Geometry>}
 */
async function loadGeometry(gl, path) {
  const arrays = readGeometry(await getBytes(path));
  const vertices = gl.createVertexArray();
  gl.bindVertexArray(vertices);
  const attributes = [arrays.positions, arrays.normals, arrays.tangents, arrays.uvs];
  const buffers = attributes.map((values, place) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, place === 3 ? 2 : 3, gl.FLOAT, false, 0, 0);
    return buffer;
  });
  const corners = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, corners);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, arrays.corners, gl.STATIC_DRAW);
  gl.bindVertexArray(null);
  return {
    extent: arrays.extent,
    positions: arrays.positions,
    within: reach(arrays.uvs),
    corners: arrays.corners.length,
    vertices,
    buffers: [...buffers, corners],
  };
}

/** @param {WebGL2RenderingContext} gl @param {Geometry} of */
function dropGeometry(gl, of) {
  gl.deleteVertexArray(of.vertices);
  for (const buffer of of.buffers) gl.deleteBuffer(buffer);
}

/** Meshes on the GPU by the paths of their geometry. */
export class Meshes {
  /** @type {Map<string, Geometry|null>} null: being loaded */
  #held = new Map();
  #changed;

  /** @param {() => void} changed is called when one has arrived */
  constructor(changed) {
    this.#changed = changed;
  }

  /**
   * The meshes of these paths; null until all are there. Others are dropped once these are.
   * @param {WebGL2RenderingContext} gl
   * @param {string[]} paths
   * @returns {Geometry[]|null}
   */
  all(gl, paths) {
    for (const path of paths) if (!this.#held.has(path)) void this.#load(gl, path);
    const found = paths.flatMap((path) => this.#held.get(path) ?? []);
    if (found.length < paths.length) return null;
    for (const [path, geometry] of this.#held) {
      if (paths.includes(path) || !geometry) continue;
      dropGeometry(gl, geometry);
      this.#held.delete(path);
    }
    return found;
  }

  /** Forgets the meshes of a lost context. */
  lose() {
    this.#held.clear();
  }

  /** @param {WebGL2RenderingContext} gl @param {string} path */
  async #load(gl, path) {
    this.#held.set(path, null);
    try {
      const geometry = await loadGeometry(gl, path);
      if (!gl.isContextLost()) this.#held.set(path, geometry);
    } catch {
      // The server's pictures stay visible meanwhile.
      await new Promise((done) => setTimeout(done, AGAIN_MS));
      this.#held.delete(path);
    }
    this.#changed();
  }
}
