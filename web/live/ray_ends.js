/**
 * Ends of the rays of a clear subject: the server follows the mirrored eye ray and two ways through
 * the body from each pixel, once for an object, a camera and an index of refraction. The ends on a
 * part are a surface like those that the camera sees, with a point in each pixel.
 *
 * @import { Scene } from "../model.js"
 * @import { Shadows } from "./shadows.js"
 * @import { Shaded } from "./surface.js"
 */
import { getBytes } from "../api/request.js";
import { readHead } from "./file.js";
import { areComplete, drawsInto } from "./raster.js";
import { NO_SHADOWS, makeTexture, placesKey, shadowKey } from "./shadows.js";
import { dropWithin, makeWithin } from "./surface.js";
import { texture } from "./texture.js";

const HEAD = { magic: "broodend", version: 1, name: "ray ends", count: 4 };
/** Number of bytes before the numbers of rows. */
const HEAD_BYTES = 28;
/** Largest side that is requested; larger pictures read the nearest pixel. */
const LARGEST_SIDE = 640;
/** Delay before a request is repeated that failed. */
const AGAIN_MS = 5000;
/** Requests at a time: browsers allow six connections to a server, and pictures come first. */
const FETCHES = 2;
/** Memory of textures that are kept besides those in use, bytes. */
const KEPT_BYTES = 2 ** 28;

/**
 * @typedef {{pixels: number, bytes: number, numbers: WebGLTexture, lengths: WebGLTexture, side:
 *   number, whole: boolean, all: Shaded, parts: Shaded[], paint: EndPaint, angles: WebGLTexture,
 *   shadowsOf: (passed: number) => Shadows, lit: WebGLTexture[], framebuffers: WebGLFramebuffer[],
 *   colors: WebGLTexture, colorFramebuffer: WebGLFramebuffer, shaded: string, developed: string,
 *   used: number}} Ends `pixels`: side of the picture. `bytes`: of all textures. `numbers`,
 *   `lengths`: of the rays of each pixel. `side`: of the textures with an end in each texel.
 *   `whole`: false if there was not enough memory. `all`: all ends; `parts`: those on the subject,
 *   the other objects, the ground, and the background. `angles`: at which lights reach ends. `lit`:
 *   light of parts with BRDFs and of painted ones, linear. `colors`: colours of the film. `shaded`,
 *   `developed`: keys of what these show. `used`: time of the last use.
 *
 * @typedef {{own: WebGLTexture, cosines: WebGLTexture, arriving: WebGLTexture, framebuffer:
 *   WebGLFramebuffer, lit: string}} EndPaint What painted materials read; `lit`: key of the lights
 */

/**
 * Largest side of ends with shadows that the server gives.
 * @param {number} lights
 */
export const largestLit = (lights) => Math.floor(Math.sqrt(2 ** 28 / (168 + 96 * lights)));

/** Identity of what ends depend on besides the index of refraction. @param {Scene} scene */
export const endsKey = (scene) => JSON.stringify([placesKey(scene), shadowKey(scene)]);

/**
 * Reads the head of a file of ray ends, and its blocks.
 * @param {ArrayBuffer} bytes
 */
export function readRayEnds(bytes) {
  const [pixels, side, parts, sets] = readHead(bytes, HEAD);
  const file = new DataView(bytes);
  const rows = Array.from({ length: parts }, (_, k) => file.getUint32(HEAD_BYTES + 4 * k, true));
  let at = HEAD_BYTES + 4 * parts;
  /** @template T @param {new (from: ArrayBuffer, at: number, count: number) => T} kind */
  const block = (kind, /** @type {number} */ size, /** @type {number} */ texels) => {
    const made = new kind(bytes, at, 4 * texels);
    at += size * 4 * texels;
    return made;
  };
  const ends = side * rows.reduce((sum, count) => sum + count, 0);
  return {
    pixels,
    side,
    rows,
    numbers: block(Uint32Array, 4, pixels * pixels),
    lengths: block(Uint16Array, 2, pixels * pixels),
    positions: block(Float32Array, 4, ends),
    own: block(Uint16Array, 2, ends),
    seen: block(Uint16Array, 2, ends),
    normals: block(Uint16Array, 2, ends),
    tangents: block(Uint16Array, 2, ends),
    angles: Array.from({ length: sets }, () => block(Uint32Array, 4, ends)),
  };
}

export class RayEnds {
  /** @type {Map<string, Ends>} */
  #held = new Map();
  /** Keys of what is being loaded. @type {Set<string>} */
  #loading = new Set();
  /** Number of drawings. */
  #clock = 0;
  /** True if the GPU has not enough memory. */
  overflows = false;
  #changed;

  /** @param {() => void} changed is called when ends have arrived */
  constructor(changed) {
    this.#changed = changed;
  }

  /** Begins a drawing. */
  begin() {
    this.#clock += 1;
  }

  /**
   * The ends in a scene; null while they are being loaded.
   * @param {WebGL2RenderingContext} gl
   * @param {{key: string, sceneId: string, slots: number, hasShadows?: boolean}} scene `slots`:
   *   number of lights
   * @param {{index: number, side: number}} of `side`: of the frame
   * @returns {Ends|null}
   */
  of(gl, { key, sceneId, slots, hasShadows }, { index, side }) {
    // Each light and each set of angles has its part of a texture, whose side is at most sqrt(3)
    // times the pixels.
    const sets = hasShadows ? 2 * slots : slots;
    const most = Math.floor(gl.getParameter(gl.MAX_TEXTURE_SIZE) / (1.8 * sets));
    const largest = hasShadows ? Math.min(most, largestLit(slots)) : most;
    const pixels = Math.max(16, Math.min(side, LARGEST_SIDE, largest));
    const own = JSON.stringify([key, index, pixels, slots]);
    const held = this.#held.get(own);
    if (held) {
      held.used = this.#clock;
      return held;
    }
    const path = `/v1/scenes/${sceneId}/ray-ends?side=${pixels}&index=${index}`;
    if (!this.#loading.has(own) && this.#loading.size < FETCHES)
      void this.#load(gl, own, path, slots);
    return null;
  }

  /** Forgets the textures of a lost context. */
  lose() {
    this.#held.clear();
    this.overflows = false;
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {string} key
   * @param {string} path
   * @param {number} slots
   */
  async #load(gl, key, path, slots) {
    this.#loading.add(key);
    try {
      const file = readRayEnds(await getBytes(path));
      if (!gl.isContextLost()) {
        const ends = makeEnds(gl, file, slots, this.#clock);
        this.#forget(gl);
        if (ends.whole) this.#held.set(key, ends);
        else dropEnds(gl, ends);
        this.overflows ||= !ends.whole;
      }
    } catch {
      // The server's pictures stay visible meanwhile.
      await new Promise((done) => setTimeout(done, AGAIN_MS));
    }
    this.#loading.delete(key);
    this.#changed();
  }

  /** @param {WebGL2RenderingContext} gl */
  #forget(gl) {
    let kept = 0;
    for (const [key, ends] of [...this.#held].sort(([, a], [, b]) => b.used - a.used)) {
      if (ends.used >= this.#clock - 1) continue;
      kept += ends.bytes;
      if (kept <= KEPT_BYTES) continue;
      dropEnds(gl, ends);
      this.#held.delete(key);
    }
  }
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {ReturnType<typeof readRayEnds>} file
 * @param {number} slots
 * @param {number} used
 * @returns {Ends}
 */
function makeEnds(gl, file, slots, used) {
  const { pixels, side, rows } = file;
  const filled = rows.reduce((sum, count) => sum + count, 0);
  /**
   * @param {number} format @param {[number, number, number]} size texture, and rows of data
   * @param {[number, number]} kind @param {ArrayBufferView} data
   */
  const made = (format, [width, height, given], [channels, type], data) => {
    const one = texture(gl, format, width, height);
    if (given > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, given, channels, type, data);
    return one;
  };
  /** @type {[number, number, number]} */
  const ofPixels = [pixels, pixels, pixels];
  /** @param {Uint16Array} data */
  const halves = (data) =>
    made(gl.RGBA16F, [side, side, filled], [gl.RGBA, gl.HALF_FLOAT], data);
  const point = made(gl.RGBA32F, [side, side, filled], [gl.RGBA, gl.FLOAT], file.positions);
  const found = [point, halves(file.normals), halves(file.tangents)];
  const lit = texture(gl, gl.RGBA32F, side, side * slots);
  const shared = {
    side,
    found,
    seen: halves(file.seen),
    lit,
    litFramebuffer: drawsInto(gl, lit),
    litCells: { cells: null },
    surroundings: new Map(),
  };
  /** @param {number} from @param {number} count */
  const within = (from, count) => {
    const [low, high] = [from, from + count].map((row) => (2 * row) / side - 1);
    return makeWithin(gl, new Float32Array([-1, low, 1, low, -1, high, -1, high, 1, low, 1, high]));
  };
  let first = 0;
  const sets = file.angles.length;
  const angles =
    sets === 0 ? makeTexture(gl, 1, 1, NO_SHADOWS) : texture(gl, gl.RGBA32UI, side, side * sets);
  file.angles.forEach((set, k) => {
    const [format, type] = [gl.RGBA_INTEGER, gl.UNSIGNED_INT];
    if (filled > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, k * side, side, filled, format, type, set);
  });
  const parts = rows.map((count) => {
    const own = { ...shared, within: within(first, count) };
    first += count;
    return own;
  });
  const [cosines, arriving] = [0, 1].map(() => texture(gl, gl.RGBA32F, side, side * slots));
  const paint = {
    own: halves(file.own), cosines, arriving, framebuffer: drawsInto(gl, cosines, arriving), lit: "",
  };
  const light = [0, 1].map(() => texture(gl, gl.RGBA16F, side));
  const framebuffers = light.map((one) => drawsInto(gl, one));
  const colors = texture(gl, gl.RGBA8, side);
  const colorFramebuffer = drawsInto(gl, colors);
  const drawn = [shared.litFramebuffer, paint.framebuffer, ...framebuffers, colorFramebuffer];
  return {
    pixels,
    bytes: side ** 2 * (68 + 48 * slots + 16 * sets) + pixels ** 2 * 24,
    numbers: made(gl.RGBA32UI, ofPixels, [gl.RGBA_INTEGER, gl.UNSIGNED_INT], file.numbers),
    lengths: made(gl.RGBA16F, ofPixels, [gl.RGBA, gl.HALF_FLOAT], file.lengths),
    side,
    whole: areComplete(gl, drawn),
    all: { ...shared, within: within(0, filled) },
    parts,
    paint,
    angles,
    shadowsOf: (passed) =>
      sets === 0 ? { angles, clear: 0, passed: 0 } : { angles, clear: sets / 2, passed },
    lit: light,
    framebuffers,
    colors,
    colorFramebuffer,
    shaded: "",
    developed: "",
    used,
  };
}

/** @param {WebGL2RenderingContext} gl @param {Ends} of */
function dropEnds(gl, of) {
  const { all, parts, paint, lit, numbers, lengths, colors } = of;
  const { own, cosines, arriving } = paint;
  for (const made of [...all.found, all.seen, all.lit, ...lit, own, cosines, arriving])
    gl.deleteTexture(made);
  for (const made of [numbers, lengths, colors, of.angles]) gl.deleteTexture(made);
  const framebuffers = [all.litFramebuffer, paint.framebuffer, ...of.framebuffers];
  for (const made of [...framebuffers, of.colorFramebuffer]) gl.deleteFramebuffer(made);
  for (const { within } of [all, ...parts]) dropWithin(gl, within);
}
