/**
 * Exposure that a lit ground decides, by the angle of the light: the server puts the 97th
 * percentile of the ground at one half, in pictures of 64 pixels. Measured at several angles
 * together; between them, stops are interpolated.
 *
 * @import { Material, Meter } from "./material.js"
 * @import { Linked } from "./program.js"
 * @import { PointLight } from "./camera.js"
 * @import { Shadows } from "./shadows.js"
 * @import { Surface, SurfacePrograms } from "./surface.js"
 */
import { drawMaterial, percentileOf } from "./material.js";
import { drawsInto } from "./raster.js";
import { lightSurface } from "./surface.js";
import { texture } from "./texture.js";

/** Side of the pictures in pixels, and number of measured angles. */
export const GROUND_SIDE = 64;
const ANGLES = 48;
/** Level of the percentile. */
const LEVEL = 0.5;

/**
 * @typedef {{pens: SurfacePrograms, dark: Linked[], surface: Surface, material: Material, lightsAt:
 *   (degrees: number) => PointLight[], shadows: Shadows}} Ground
 *   `surface`: of the ground in pictures of this side; `lightsAt`: lights of strengths near 1
 */

/**
 * Gain at an angle; null if no light reaches the ground there.
 * @param {(number|null)[]} gains at equal steps of the circle
 * @param {number} degrees
 */
export function gainBetween(gains, degrees) {
  const at = ((((degrees % 360) + 360) % 360) * gains.length) / 360;
  const first = Math.floor(at) % gains.length;
  const [a, b] = [gains[first], gains[(first + 1) % gains.length]];
  return a === null || b === null ? (a ?? b) : a * (b / a) ** (at - Math.floor(at));
}

export class GroundExposure {
  /** @type {Meter|null} */
  #meter = null;
  /** Key of what was measured, or is being measured. */
  #key = "";
  /** @type {(number|null)[]|null} */
  #gains = null;
  /** @type {WebGLBuffer|null} */
  #pixels = null;
  /** @type {WebGLSync|null} */
  #fence = null;

  /** True if gains are known, perhaps of an earlier light. */
  get known() {
    return this.#gains !== null;
  }

  /** True if gains are known of the light with a key. @param {string} key */
  isOf(key) {
    return this.known && this.#fence === null && this.#key === key;
  }

  /**
   * Gain for lights of strengths near 1; null if the ground decides none.
   * @param {number} degrees
   */
  gainAt(degrees) {
    return this.#gains && gainBetween(this.#gains, degrees);
  }

  /**
   * Advances the measurement by one step, without waiting. Earlier gains stay until the next are
   * known. A measurement that runs ends before the next, so that dragged objects are followed.
   * @param {WebGL2RenderingContext} gl
   * @param {string} key of everything that the light on the ground depends on
   * @param {Ground} ground
   * @returns {boolean} true if more steps are needed
   */
  work(gl, key, ground) {
    if (!this.#fence) {
      if (this.#key === key) return false;
      this.#draw(gl, ground);
      this.#key = key;
      return true;
    }
    if (gl.clientWaitSync(this.#fence, 0, 0) === gl.TIMEOUT_EXPIRED) return true;
    const pixels = new Float32Array(4 * ANGLES * GROUND_SIDE * GROUND_SIDE);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.#pixels);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, pixels);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.deleteSync(this.#fence);
    this.#fence = null;
    this.#gains = gainsOf(pixels);
    return false;
  }

  /** Forgets what is measured of a scene without a lit ground, and of a lost context. */
  forget() {
    this.#key = "";
    this.#gains = null;
    this.#fence = null;
  }

  /** Forgets everything of a lost context. */
  lose() {
    this.forget();
    this.#meter = null;
    this.#pixels = null;
  }

  /** @param {WebGL2RenderingContext} gl @param {Ground} ground */
  #draw(gl, { pens, dark, surface, material, lightsAt, shadows }) {
    if (!this.#meter) {
      const made = texture(gl, gl.RGBA32F, GROUND_SIDE * ANGLES, GROUND_SIDE);
      this.#meter = { framebuffer: drawsInto(gl, made), texture: made };
    }
    const { framebuffer } = this.#meter;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const where = { gain: 1, tone: 0, marks: false, adds: false };
    for (let k = 0; k < ANGLES; k += 1) {
      const lights = lightsAt((360 * k) / ANGLES);
      lightSurface(gl, pens, surface, lights, shadows);
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      drawMaterial(
        gl, material, dark, { surface, lights, around: 1 }, { ...where, corner: [k * GROUND_SIDE, 0] },
      );
    }
    this.#pixels ??= gl.createBuffer();
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, this.#pixels);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, 16 * ANGLES * GROUND_SIDE * GROUND_SIDE, gl.STREAM_READ);
    gl.readPixels(0, 0, ANGLES * GROUND_SIDE, GROUND_SIDE, gl.RGBA, gl.FLOAT, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.#fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }
}

/** Gain at each angle. @param {Float32Array} pixels pictures side by side */
function gainsOf(pixels) {
  return Array.from({ length: ANGLES }, (_, k) => {
    const levels = [];
    for (let row = 0; row < GROUND_SIDE; row += 1) {
      const first = 4 * GROUND_SIDE * (row * ANGLES + k);
      for (let at = first; at < first + 4 * GROUND_SIDE; at += 4) {
        const largest = Math.max(pixels[at], pixels[at + 1], pixels[at + 2]);
        if (largest > 0) levels.push(largest / pixels[at + 3]);
      }
    }
    const level = percentileOf(levels);
    return level === null ? null : LEVEL / level;
  });
}
