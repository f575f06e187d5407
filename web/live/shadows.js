/**
 * Hard shadows of point, spot and directional lights that circle, live: the server finds the angles
 * at which each light reaches each pixel, once for an object, a camera and the places of the
 * lights.
 *
 * @import { Scene } from "../model.js"
 * @import { Linked } from "./program.js"
 */
import { getBytes } from "../api/request.js";
import { readHead } from "./file.js";
import { uniformLocation } from "./program.js";
import { texture } from "./texture.js";

const HEAD = { magic: "broodang", version: 1, name: "lit angles", count: 2 };
/** Number of bytes before the angles. */
const HEAD_BYTES = 20;
/** Angles of a circle. */
const ANGLES = 65_535;
/** Angles of a pixel and a light, 16 bits each. */
const TOGGLES = 8;
/** Angles of a light that always shines. */
export const NO_SHADOWS = new Uint32Array([0xffff_0000, ~0, ~0, ~0]);
/** Largest side the server takes; larger pictures read the nearest pixel. */
const LARGEST_SIDE = 1024;
/** Delay before a request is repeated that failed. */
const AGAIN_MS = 5000;

/** GLSL: the share of a light that reaches a pixel through the subject. */
const THROUGH = `
uniform int clear;
uniform float passed;
float through(ivec2 at) { return is_lit(at, numbered + clear) ? passed : 0.0; }`;

/**
 * GLSL: the share of a light that reaches a pixel. A texture of one pixel serves all.
 * @param {boolean} isClear true if a share `passed` goes through the subject; software renderers
 *   would run both sides of a branch
 */
export const reaching = (isClear) => `
uniform highp usampler2D angles;
uniform uint angle;
uniform int side;
uniform int numbered;
bool is_lit(ivec2 at, int light) {
  ivec2 size = textureSize(angles, 0);
  uvec4 pairs = texelFetch(angles, min(at + ivec2(0, light * size.x), size - 1), 0);
  uvec4 before = uvec4(lessThanEqual(pairs & 0xFFFFu, uvec4(angle)))
    + uvec4(lessThanEqual(pairs >> 16, uvec4(angle)));
  return ((before.x + before.y + before.z + before.w) & 1u) == 1u;
}
${isClear ? THROUGH : "float through(ivec2 at) { return 0.0; }"}
float reached_at(ivec2 at) { return is_lit(at, numbered) ? 1.0 : through(at); }
// The pixel of a shading point, as the geometry buffer has it.
ivec2 point_of(ivec2 here, float step) {
  int all = int(step) + 4;
  return here + ivec2(all % 3, all / 3) - 1;
}
float reached(ivec2 here) {
  int size = textureSize(angles, 0).x;
  return reached_at((2 * here + 1) * size / (2 * side));
}
// Share of a pixel that a light reaches, where there are more angles than pixels.
float reached_share(ivec2 here) {
  int size = textureSize(angles, 0).x;
  int across = clamp((size + side / 2) / side, 1, 4);
  float sum = 0.0;
  for (int k = 0; k < across * across; k++) {
    ivec2 at = here * across + ivec2(k % across, k / across);
    at = (2 * at + 1) * size / (2 * side * across);
    sum += reached_at(at);
  }
  return sum / float(across * across);
}`;

/** An angle of the light in the unit of files. @param {number} degrees */
export const angleOf = (degrees) => Math.floor(((((degrees % 360) + 360) % 360) * ANGLES) / 360);

/**
 * Identity of what the angles depend on; empty without shadows.
 * @param {Scene} scene
 */
export function shadowKey(scene) {
  if (!scene.shadows) return "";
  const lights = (scene.lights ?? []).map(({ kind, position, direction }) =>
    kind === "directional" ? { direction: direction ?? null } : (position ?? null),
  );
  return JSON.stringify([placesKey(scene), lights]);
}

/**
 * Identity of where all parts and the camera of a scene are.
 * @param {Scene} scene
 */
export function placesKey(scene) {
  const { mesh, rotation_deg, scale, camera, tangents, sphere_pole, ground } = scene;
  const others = (scene.objects ?? []).map(({ material, ...place }) => place);
  const height = ground ? (ground.height ?? "lowest") : null;
  return [[mesh, rotation_deg, scale, camera, tangents, sphere_pole], others, height];
}

/**
 * Reads the head of a file of lit angles, and its angles, two in each number.
 * @param {ArrayBuffer} bytes
 */
export function readAngles(bytes) {
  const [side, lights] = readHead(bytes, HEAD);
  const pairs = new Uint32Array(bytes, HEAD_BYTES, (TOGGLES / 2) * side * side * lights);
  return { side, lights, pairs };
}

/**
 * @typedef {{angles: WebGLTexture, clear: number, passed: number}} Shadows `clear`: number of
 * lights before those that shine through the subject; `passed`: share of light that passes there
 */

/**
 * Sets the uniforms of shadows; their texture is read as `angles`.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Shadows} shadows
 */
export function bindShadows(gl, pen, { clear, passed }) {
  if (passed === 0) return;
  gl.uniform1i(uniformLocation(gl, pen, "clear"), clear);
  gl.uniform1f(uniformLocation(gl, pen, "passed"), passed);
}

/** Texture of the angles of the scene, and one that stands for none. */
export class ShadowTexture {
  /** @type {{key: string, isClear: boolean, lights: number, texture: WebGLTexture}|null} */
  #held = null;
  /** @type {WebGLTexture|null} */
  #none = null;
  /** Key of what is being loaded; empty if nothing is. */
  #loading = "";
  #changed;

  /** @param {() => void} changed is called when angles have arrived */
  constructor(changed) {
    this.#changed = changed;
  }

  /**
   * These shadows; none while they are not there.
   * @param {WebGL2RenderingContext} gl
   * @param {string} key
   * @param {number} passed share of light that passes through the subject
   * @returns {Shadows}
   */
  of(gl, key, passed) {
    this.#none ??= makeTexture(gl, 1, 1, NO_SHADOWS);
    const held = this.#held?.key === key ? this.#held : null;
    if (!held?.isClear) return { angles: held?.texture ?? this.#none, clear: 0, passed: 0 };
    return { angles: held.texture, clear: held.lights / 2, passed };
  }

  /**
   * True if the angles of these shadows are there.
   * @param {string} key
   * @param {boolean} isClear true for those through the subject as well
   */
  has(key, isClear) {
    return key === "" || (this.#held?.key === key && (this.#held.isClear || !isClear));
  }

  /**
   * Requests the angles of a scene, unless they are there or on their way.
   * @param {WebGL2RenderingContext} gl
   * @param {{key: string, sceneId: string, side: number, lights: number, isClear: boolean}} of
   *   `lights`: their number
   */
  request(gl, { key, sceneId, side, lights, isClear }) {
    const loading = JSON.stringify([key, isClear]);
    if (this.has(key, isClear) || this.#loading === loading) return;
    this.#loading = loading;
    const height = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const most = Math.min(LARGEST_SIDE, Math.floor(height / (isClear ? 2 * lights : lights)));
    const path = `/v1/scenes/${sceneId}/lit-angles?side=${Math.min(side, most)}&clear=${isClear}`;
    void this.#load(gl, { key, isClear, loading, path });
  }

  /** Forgets the textures of a lost context. */
  lose() {
    this.#held = null;
    this.#none = null;
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {{key: string, isClear: boolean, loading: string, path: string}} of
   */
  async #load(gl, { key, isClear, loading, path }) {
    try {
      const { side, lights, pairs } = readAngles(await getBytes(path));
      if (this.#loading === loading && !gl.isContextLost()) {
        if (this.#held) gl.deleteTexture(this.#held.texture);
        const made = makeTexture(gl, side, side * lights, pairs);
        this.#held = { key, isClear, lights, texture: made };
      }
    } catch {
      // The server's pictures stay visible meanwhile.
      await new Promise((done) => setTimeout(done, AGAIN_MS));
    }
    if (this.#loading === loading) this.#loading = "";
    this.#changed();
  }
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {number} width
 * @param {number} height
 * @param {Uint32Array} pairs
 */
export function makeTexture(gl, width, height, pairs) {
  const made = texture(gl, gl.RGBA32UI, width, height);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, pairs);
  return made;
}
