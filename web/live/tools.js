/**
 * What all materials share, made at the first drawing: programs, and the surfaces of the scene as
 * the frames (`small`), the centre (`large`) and the meters of exposures see them.
 *
 * @import { Scene } from "../model.js"
 * @import { Layout } from "./canvas.js"
 * @import { Linked } from "./program.js"
 * @import { Meter } from "./material.js"
 * @import { Surface, SurfacePrograms } from "./surface.js"
 */
import { linkBackdrop } from "./backdrop.js";
import { LIGHTS } from "./camera.js";
import { layOut } from "./canvas.js";
import { GROUND_SIDE } from "./ground_exposure.js";
import { METER_ANGLES, METER_SIDE, linkDark, makeMeter } from "./material.js";
import { dropSurfaces, linkSurfacePrograms, makeSurfaces } from "./surface.js";

/**
 * @typedef {{pens: SurfacePrograms, dark: Linked[], backdrop: Linked, meter: Meter}} Programs
 *
 * @typedef {{small: Surface[], large: Surface[], metering: Surface[], ground: Surface[]}} Surfaces
 *   `small`, `large`: of all parts; `metering`: of the subject; `ground`: of the ground if there is
 *   one
 *
 * @typedef {Programs & Surfaces & {layout: Layout, isNew: boolean}} Tools `isNew`: true if
 *   surfaces have been made, which show nothing yet
 */

export class ToolBox {
  /** @type {Programs|null} */
  #programs = null;
  /** @type {Surfaces|null} */
  #surfaces = null;
  /** Numbers of parts and slots, and if there is a ground. */
  #key = "";
  #dropped;

  /**
   * @param {(gl: WebGL2RenderingContext, surface: Surface) => void} dropped is called before a
   *   surface is dropped
   */
  constructor(dropped) {
    this.#dropped = dropped;
  }

  /**
   * Sizes the buffers, and makes surfaces anew whose size or number has changed.
   * @param {WebGL2RenderingContext} gl
   * @param {HTMLCanvasElement} canvas
   * @param {Scene} scene
   * @param {number} ratio resolution relative to the screen's
   * @returns {Tools|null} null if nothing is visible, or without enough memory
   */
  prepare(gl, canvas, scene, ratio) {
    // A texture holds the light on the large frame from each light, one below the other.
    const slots = Math.max(1, Math.min(LIGHTS, scene.lights?.length ?? 1));
    const layout = layOut(canvas, ratio, gl.getParameter(gl.MAX_TEXTURE_SIZE) / slots);
    if (!layout) return null;
    if (canvas.width !== layout.width || canvas.height !== layout.height) {
      canvas.width = layout.width;
      canvas.height = layout.height;
    }
    Object.assign(canvas.style, layout.css);
    this.#programs ??= {
      pens: linkSurfacePrograms(gl),
      dark: linkDark(gl),
      backdrop: linkBackdrop(gl),
      meter: makeMeter(gl),
    };
    const isNew = this.#makeSurfaces(gl, scene, layout, slots);
    const surfaces = this.#surfaces;
    if (!surfaces || !Object.values(surfaces).flat().every(({ whole }) => whole)) return null;
    return { layout, isNew, ...this.#programs, ...surfaces };
  }

  /** Forgets everything of a lost context. */
  lose() {
    this.#programs = null;
    this.#surfaces = null;
    this.#key = "";
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Scene} scene
   * @param {Layout} layout
   * @param {number} slots
   * @returns {boolean} true if any was made
   */
  #makeSurfaces(gl, { objects, ground }, layout, slots) {
    const parts = 1 + (objects ?? []).length + (ground ? 1 : 0);
    const key = JSON.stringify([parts, slots, Boolean(ground)]);
    const before = this.#key === key ? this.#surfaces : null;
    const stay = /** @type {const} */ (["small", "large"]).filter(
      (name) => before?.[name][0].side === layout[name],
    );
    if (before && stay.length === 2) return false;
    for (const [name, surfaces] of Object.entries(this.#surfaces ?? {})) {
      const kept = before && !(["small", "large"].includes(name) && !stay.some((one) => one === name));
      if (kept || surfaces.length === 0) continue;
      for (const surface of surfaces) this.#dropped(gl, surface);
      dropSurfaces(gl, surfaces);
    }
    /** @param {"small"|"large"} name */
    const ofSize = (name) =>
      before && stay.includes(name) ? before[name] : makeSurfaces(gl, layout[name], slots, parts);
    this.#surfaces = {
      small: ofSize("small"),
      large: ofSize("large"),
      metering: before?.metering ?? makeSurfaces(gl, METER_SIDE, LIGHTS * METER_ANGLES, parts, [0]),
      ground:
        before?.ground ?? (ground ? makeSurfaces(gl, GROUND_SIDE, slots, parts, [parts - 1]) : []),
    };
    this.#key = key;
    return true;
  }
}
