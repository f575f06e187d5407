/**
 * Store of the photographs in the form: decoded pictures and meshes. Does no requests and no
 * drawing.
 *
 * @import { Arrays } from "../live/geometry.js"
 * @import { Signal } from "../vendor/signals-core.js"
 * @import { Codes } from "./pixels.js"
 */
import { signal } from "../vendor/signals-core.js";

/** @typedef {{url: string, codes: Codes}} Shown `url`: of the picture in this browser. */

class PhotoStore {
  /**
   * Pictures by the keys of their settings; a text says why one cannot be shown.
   * @type {Signal<Map<number, Shown|string>>}
   */
  shown = signal(new Map());
  /**
   * Meshes by their names; a text says why one cannot be loaded.
   * @type {Signal<Map<string, Arrays|string>>}
   */
  meshes = signal(new Map());
  /** Effect of a drag on a mesh. @type {Signal<"move"|"turn">} */
  dragMode = signal("move");
}

export const photoStore = new PhotoStore();
