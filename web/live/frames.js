/**
 * Drawing of the frames whose materials are ready. Frames whose materials let the same share of
 * light pass are drawn together: they share the light on all parts, and the pictures of the other
 * parts.
 *
 * @import { Cell, Scene } from "../model.js"
 * @import { Picture } from "./backdrop_picture.js"
 * @import { PointLight, View } from "./camera.js"
 * @import { ClearBodies } from "./clear.js"
 * @import { GroundExposure } from "./ground_exposure.js"
 * @import { Material } from "./material.js"
 * @import { OtherParts } from "./others.js"
 * @import { PaintLight } from "./paint_lights.js"
 * @import { Mesh } from "./raster.js"
 * @import { Ends } from "./ray_ends.js"
 * @import { Shadows } from "./shadows.js"
 * @import { Surface } from "./surface.js"
 * @import { Tools } from "./tools.js"
 */
import { drawBackdrop } from "./backdrop.js";
import { toneNumber } from "./film.js";
import { drawMaterial } from "./material.js";
import { PaintedSurfaces, drawPainted } from "./paint.js";
import { lightSurface } from "./surface.js";
import { drawSurroundings, keepSurroundings } from "./surroundings.js";

/**
 * @typedef {{cell: Cell, corner: [number, number], material: Material}} Frame `corner`: lower left
 *   in pixels
 *
 * @typedef {{key: string, view: View, parts: Mesh[]}} Seen `key`: of everything that decides what
 *   the camera sees
 *
 * @typedef {{key: string, lights: PointLight[], strength: number, shared: PointLight[],
 *   paintLights: PaintLight[]|null, shadowsOf: (passed: number) => Shadows}} Lit
 *   `key`: of the light at this angle; `shared`: lights divided by `strength`; `shadowsOf`: where a
 *   share of light passes through the subject
 *
 * @typedef {{materials: Material[], gains: GroundExposure|null}|null} Beside The other parts
 */

export class FramePainter {
  #others;
  #clear;
  #painted = new PaintedSurfaces();
  /** Keys of the light on surfaces. @type {WeakMap<Surface, string>} */
  #lit = new WeakMap();

  /** @param {OtherParts} others @param {ClearBodies} clear */
  constructor(others, clear) {
    this.#others = others;
    this.#clear = clear;
  }

  /**
   * Draws frames to the screen.
   * @param {WebGL2RenderingContext} gl
   * @param {Tools} tools
   * @param {Frame[]} frames
   * @param {{scene: Scene, seen: Seen, lit: Lit, beside: Beside, glass: Map<Cell, Ends>, picture:
   *   Picture|null, degrees: number, marks: boolean}} of `glass`: ends of rays of clear materials;
   *   `picture`: of the backdrop
   * @returns {boolean} false if there was not enough memory
   */
  draw(gl, tools, frames, of) {
    const { pens, small, large, metering } = tools;
    /** @param {Frame} frame */
    const surfaceOf = ({ cell }) => surfacesOf(tools, cell)[0];
    for (const frame of frames)
      if (frame.material.spheres)
        drawSurroundings(gl, pens, surfaceOf(frame), frame.material.spheres);
    for (const surface of [small[0], large[0], metering[0]]) {
      const drawn = frames.filter((frame) => surfaceOf(frame) === surface);
      keepSurroundings(gl, surface, new Set(drawn.map(({ material }) => material.spheres)));
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    // Without shadows, all have the same light.
    const passedOf = (/** @type {Frame} */ { material }) => of.lit.shadowsOf(material.passed).passed;
    return [...new Set(frames.map(passedOf))].every((passed) =>
      this.#drawTogether(gl, tools, frames.filter((one) => passedOf(one) === passed), of, passed),
    );
  }

  /**
   * Draws frames whose materials let the same share of light pass.
   * @param {WebGL2RenderingContext} gl
   * @param {Tools} tools
   * @param {Frame[]} frames
   * @param {Parameters<FramePainter["draw"]>[3]} of
   * @param {number} passed
   */
  #drawTogether(gl, tools, frames, of, passed) {
    const { scene, seen, lit, beside, glass, picture, degrees, marks } = of;
    const { lights, strength, paintLights } = lit;
    const { pens, dark, backdrop } = tools;
    const shadows = lit.shadowsOf(passed);
    const key = JSON.stringify([lit.key, passed]);
    /** @param {Surface} surface @param {PaintLight[]} under */
    const paintOf = (surface, under) => {
      const { key: standing, view, parts } = seen;
      const shown = { key: standing, mesh: parts[surface.part], view };
      return this.#painted.prepare(gl, surface, shown, { key, lights: under, shadows });
    };
    const decided = beside?.gains?.gainAt(degrees) ?? null;
    const tone = toneNumber(scene.film.tone);
    /** @param {Material} material */
    const gainOf = (material) => gainIn(scene, material, strength, decided);
    for (const { cell, material } of frames) {
      const [surface] = surfacesOf(tools, cell);
      if (material.painted && paintLights) paintOf(surface, paintLights);
      else if (this.#lit.get(surface) !== key) {
        lightSurface(gl, pens, surface, lights, shadows);
        this.#lit.set(surface, key);
      }
    }
    const light = paintLights && {
      key,
      lights: lit.shared,
      shadows,
      paint: (/** @type {Surface} */ surface) => paintOf(surface, paintLights),
      paintLights,
    };
    if (beside && light)
      for (const surfaces of new Set(frames.map(({ cell }) => surfacesOf(tools, cell))))
        if (!this.#others.shade(gl, tools, surfaces, beside.materials, light)) return false;
    for (const { cell, material } of frames) {
      const ends = glass.get(cell);
      const film = { scene, picture, gain: strength * gainOf(material), tone };
      const hands = { pens, dark, painted: this.#painted };
      if (ends && light)
        this.#clear.shade(gl, hands, ends, beside?.materials ?? [], { ...light, passed }, film);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    for (const { cell, corner, material } of frames) {
      const [surface] = surfacesOf(tools, cell);
      const where = { corner, gain: gainOf(material), tone, marks, adds: beside !== null };
      if (beside) {
        this.#others.copy(gl, surfacesOf(tools, cell), { ...where, gain: where.gain * strength });
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.ONE, gl.ONE);
      }
      if (material.painted && paintLights) {
        const how = { paint: paintOf(surface, paintLights), lights: paintLights, corner };
        drawPainted(gl, material.linked, surface, { ...how, ends: glass.get(cell) });
      } else drawMaterial(gl, material, dark, { surface, lights, around: 1 }, where);
      gl.disable(gl.BLEND);
      const behind = { spheres: material.spheres, picture };
      drawBackdrop(gl, backdrop, scene, behind, { ...where, side: surface.side });
    }
    return true;
  }

  /** Forgets the light on surfaces, which were drawn anew. */
  forget() {
    this.#lit = new WeakMap();
  }

  /** @param {WebGL2RenderingContext} gl @param {Surface} surface is about to be dropped */
  drop(gl, surface) {
    this.#painted.drop(gl, surface);
    this.#others.drop(gl, surface);
  }

  /** Forgets everything of a lost context. */
  lose() {
    this.#painted.lose();
    this.#others.lose();
    this.#clear.lose();
    this.forget();
  }
}

/** Surfaces of all parts as a frame shows them. @param {Tools} tools @param {Cell} cell */
const surfacesOf = ({ small, large }, cell) => (cell === "centre" ? large : small);

/**
 * Gain of the film for a frame.
 * @param {Scene} scene
 * @param {Material} material
 * @param {number} strength of the lights
 * @param {number|null} decided by a ground, for lights of strengths near 1
 */
function gainIn({ film: { exposure } }, material, strength, decided) {
  if (exposure !== "auto") return 2 ** exposure;
  if (decided !== null) return decided / strength;
  return material.painted ? 1 : material.gain / strength;
}
