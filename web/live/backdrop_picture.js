/**
 * Picture of the backdrop on the GPU: the image that the scene names, in codes times opacity, with
 * smaller levels. One is held at a time.
 *
 * @import { Backdrop } from "../model.js"
 */
import { getBytes, isOutage, problemOf } from "../api/request.js";
import { imageUrl } from "../api/routes.js";
import { readExif } from "../photo/exif.js";
import { liveStore } from "./store.js";

/** Delay before a request is repeated that failed. */
const AGAIN_MS = 5000;

/**
 * @typedef {{id: string, texture: WebGLTexture, cover: [number, number]}} Picture `cover`: share of
 *   width and height that a square frame shows
 */

/**
 * Share of the width and height of a picture that is seen if it just covers a square.
 * @param {{width: number, height: number}} size
 * @returns {[number, number]}
 */
export function coverOf({ width, height }) {
  const shorter = Math.min(width, height);
  return [shorter / width, shorter / height];
}

/**
 * Size of a picture that fits into a square.
 * @param {{width: number, height: number}} size
 * @param {number} most side of the square
 */
export function fitted({ width, height }, most) {
  const fit = Math.min(1, most / Math.max(width, height));
  /** @param {number} side */
  const of = (side) => Math.max(1, Math.round(side * fit));
  return { width: of(width), height: of(height) };
}

/**
 * Decodes an image as the server does: without its colour profile.
 * @param {ArrayBuffer} bytes
 * @param {number} most largest side of a texture
 */
async function decode(bytes, most) {
  // Browsers turn such images, the server does not.
  if (readExif(bytes).orientation !== 1) throw new Error("the image is turned");
  /** @type {ImageBitmapOptions} */
  const how = { premultiplyAlpha: "premultiply", colorSpaceConversion: "none" };
  const whole = await createImageBitmap(new Blob([bytes]), how);
  if (Math.max(whole.width, whole.height) <= most) return whole;
  const { width, height } = fitted(whole, most);
  const size = { resizeWidth: width, resizeHeight: height };
  const smaller = await createImageBitmap(whole, { ...how, ...size, resizeQuality: "high" });
  whole.close();
  return smaller;
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {ImageBitmap} bitmap
 */
function makeTexture(gl, bitmap) {
  const { width, height } = bitmap;
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  const levels = 1 + Math.floor(Math.log2(Math.max(width, height)));
  gl.texStorage2D(gl.TEXTURE_2D, levels, gl.RGBA8, width, height);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
    gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  return made;
}

export class BackdropPicture {
  /** The picture of the scene; null if it has none. @type {Picture|null} */
  held = null;
  /** Id of the image that is being loaded; empty if none is. */
  #loading = "";
  #changed;

  /** @param {() => void} changed is called when the picture has arrived */
  constructor(changed) {
    this.#changed = changed;
  }

  /**
   * Requests the picture of a backdrop if it is one, and drops another one.
   * @param {WebGL2RenderingContext} gl
   * @param {Backdrop|null} [backdrop]
   * @returns {boolean} false if it is not loaded yet
   */
  prepare(gl, backdrop) {
    const id = backdrop?.kind === "image" ? backdrop.image : "";
    if (this.held && this.held.id !== id) {
      gl.deleteTexture(this.held.texture);
      this.held = null;
    }
    if (id === "") this.#loading = "";
    else if (!this.held && this.#loading !== id) {
      this.#loading = id;
      void this.#load(gl, id);
    }
    return id === "" || this.held !== null;
  }

  /** Forgets the texture of a lost context. */
  lose() {
    this.held = null;
  }

  /** @param {WebGL2RenderingContext} gl @param {string} id */
  async #load(gl, id) {
    try {
      const bytes = await getBytes(imageUrl(id));
      // A lost context has no limits.
      const most = gl.isContextLost() ? 1 : gl.getParameter(gl.MAX_TEXTURE_SIZE);
      const bitmap = await decode(bytes, most);
      if (this.#loading === id && !gl.isContextLost() && most > 1)
        this.held = { id, texture: makeTexture(gl, bitmap), cover: coverOf(bitmap) };
      bitmap.close();
    } catch (error) {
      const problem = problemOf(error);
      // The server's pictures stay visible meanwhile.
      if (isOutage(problem) || problem.status >= 500)
        await new Promise((done) => setTimeout(done, AGAIN_MS));
      else liveStore.refusedImages.value = new Set([...liveStore.refusedImages.value, id]);
    }
    if (this.#loading === id) this.#loading = "";
    this.#changed();
  }
}
