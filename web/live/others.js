/**
 * Pictures of the parts of a scene beside the subject, which all frames share: shaded once for an
 * angle of the light, developed once for an exposure, and copied into each frame before the subject
 * is added. Parts are mixed in linear light, each by what it covers of a pixel.
 *
 * @import { Scene } from "../model.js"
 * @import { Making } from "./material_cache.js"
 * @import { Material } from "./material.js"
 * @import { Paint, Seen } from "./paint.js"
 * @import { PaintLight } from "./paint_lights.js"
 * @import { Linked } from "./program.js"
 * @import { PointLight } from "./camera.js"
 * @import { Shadows } from "./shadows.js"
 * @import { Shaded, Surface, SurfacePrograms } from "./surface.js"
 * @import { Tools } from "./tools.js"
 */
import { materialsOf } from "./camera.js";
import { DEVELOPED, FILM } from "./film.js";
import { GroundExposure } from "./ground_exposure.js";
import { drawMaterial } from "./material.js";
import { MaterialCache } from "./material_cache.js";
import { drawPainted } from "./paint.js";
import { EVERYWHERE, linkNow, read, uniformLocation } from "./program.js";
import { areComplete, drawsInto } from "./raster.js";
import { NO_ENVIRONMENT } from "./spheres.js";
import { liveStore } from "./store.js";
import { lightSurface } from "./surface.js";
import { texture } from "./texture.js";

/** Develops the light of parts with BRDFs, and adds painted parts. */
const DEVELOP = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D lit;
uniform sampler2D painted;
out vec4 color;
${FILM}
${DEVELOPED}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 light = texelFetch(lit, at, 0);
  vec4 paint = texelFetch(painted, at, 0);
  float coverage = min(light.a + paint.a, 1.0);
  vec3 shown = light.a * clamp(toned(gain * light.rgb / max(light.a, 1e-6)), 0.0, 1.0) + paint.rgb;
  color = vec4(developed(shown / max(coverage, 1e-6), coverage), 1.0) * coverage;
}`;

/**
 * @typedef {{side: number, whole: boolean, shaded: string, developed: string, light:
 *   WebGLTexture[], framebuffers: WebGLFramebuffer[], picture: WebGLTexture, pictureFramebuffer:
 *   WebGLFramebuffer}} Held
 *   `whole`: false if there was not enough memory. `shaded`, `developed`: keys of what the textures
 *   show. `light`: of parts with BRDFs and of painted ones, linear, multiplied by coverage.
 *   `picture`: colours of the film.
 *
 * @typedef {{key: string, lights: PointLight[], shadows: Shadows, paint: (surface: Surface) =>
 *   Paint, paintLights: PaintLight[]}} Light
 *   `key`: of everything that the light on the parts depends on; `lights`: of strengths near 1
 */

/** Source of a material for the cache. @param {string} name */
const sourceOf = (name) => ({ id: name, hash: name });

export class OtherParts {
  #cache;
  #exposure = new GroundExposure();
  /** @type {Linked|null} */
  #develop = null;
  /** @type {Map<Surface, Held>} by the surface of the subject */
  #held = new Map();

  /** @param {() => void} changed is called when a material has arrived */
  constructor(changed) {
    this.#cache = new MaterialCache(changed, {
      pathOf: ({ id }) => `/v1/exports/glsl-es-300?${id ? `material=${encodeURIComponent(id)}&` : ""}`,
      linear: true,
    });
  }

  /**
   * Prepares the materials of the other parts.
   * @param {WebGL2RenderingContext} gl
   * @param {Scene} scene
   * @param {Making} making
   * @returns {boolean} true if there is more to do
   */
  work(gl, scene, making) {
    const sources = [...new Set(materialsOf(scene))].map(sourceOf);
    if (sources.length === 0) return false;
    return this.#cache.work(gl, sources, { ...making, environment: NO_ENVIRONMENT });
  }

  /** True if the materials of all other parts are known and have no bumps. @param {Scene} scene */
  areSmooth = (scene) =>
    materialsOf(scene).every(
      (name) => this.#cache.drawable(sourceOf(name), NO_ENVIRONMENT)?.bumps === false,
    );

  /**
   * Prepares what the other parts are drawn with: their materials, and the exposure if the ground
   * decides it.
   * @param {WebGL2RenderingContext} gl
   * @param {Scene} scene
   * @param {Tools} tools
   * @param {{key: string, lightsAt: (degrees: number) => PointLight[], shadows: Shadows}} light
   *   `key`: of the light at all angles; `lightsAt`: of strengths near 1
   * @param {boolean} follows true while something is dragged: the exposure may be a bit late
   * @returns {{materials: Material[], gains: GroundExposure|null, measures: boolean}|null} null if
   *   they are not ready
   */
  prepare(gl, scene, { pens, dark, ground }, { key, lightsAt, shadows }, follows) {
    const names = materialsOf(scene);
    const refused = names.filter((name) => this.#cache.isUnknown(sourceOf(name)));
    if (refused.length > 0)
      liveStore.refusedMaterials.value = new Set([...liveStore.refusedMaterials.value, ...refused]);
    const materials = names.flatMap(
      (name) => this.#cache.drawable(sourceOf(name), NO_ENVIRONMENT) ?? [],
    );
    if (materials.length < names.length) return null;
    const below = scene.ground ? materials.at(-1) : null;
    if (!below || below.painted || scene.film.exposure !== "auto") {
      this.#exposure.forget();
      return { materials, gains: null, measures: false };
    }
    const of = { pens, dark, surface: ground[0], material: below, lightsAt, shadows };
    const own = JSON.stringify([key, lightsAt(0)]);
    const measures = this.#exposure.work(gl, own, of);
    const known = follows ? this.#exposure.known : this.#exposure.isOf(own);
    return known ? { materials, gains: this.#exposure, measures } : null;
  }

  /**
   * Shades the other parts, unless they are known.
   * @param {WebGL2RenderingContext} gl
   * @param {{pens: SurfacePrograms, dark: Linked[]}} tools
   * @param {Surface[]} surfaces of all parts
   * @param {Material[]} materials of the other parts
   * @param {Light} light
   * @returns {boolean} false if there was not enough memory
   */
  shade(gl, { pens, dark }, surfaces, materials, { key, lights, shadows, paint, paintLights }) {
    const [subject, ...others] = surfaces;
    let held = this.#held.get(subject);
    if (!held) this.#held.set(subject, (held = makeHeld(gl, subject.side)));
    if (!held.whole) return false;
    if (held.shaded === key) return true;
    others.forEach((surface, index) => {
      if (materials[index].painted) paint(surface);
      else lightSurface(gl, pens, surface, lights, shadows);
    });
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 0);
    for (const made of held.framebuffers) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, made);
      gl.clear(gl.COLOR_BUFFER_BIT);
    }
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    for (const [index, surface] of others.entries()) {
      const material = materials[index];
      const made = material.painted ? paint(surface) : null;
      const look = { surface, paint: made, lights, paintLights };
      drawPart(gl, dark, held.framebuffers, material, look);
    }
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    held.shaded = key;
    held.developed = "";
    return true;
  }

  /**
   * Copies the other parts, which are shaded by then, to a corner of the screen.
   * @param {WebGL2RenderingContext} gl
   * @param {Surface[]} surfaces of all parts
   * @param {{corner: [number, number], gain: number, tone: number, marks: boolean}} where as those
   *   of a material; `gain`: for the lights that the parts were shaded with
   */
  copy(gl, [subject], { corner: [x, y], gain, tone, marks }) {
    const held = this.#held.get(subject);
    if (!held) return;
    const { side } = held;
    const key = JSON.stringify([gain, tone, marks]);
    if (held.developed !== key) {
      this.#develop ??= linkDevelop(gl);
      gl.bindFramebuffer(gl.FRAMEBUFFER, held.pictureFramebuffer);
      gl.viewport(0, 0, side, side);
      develop(gl, this.#develop, held.light, { gain, tone, marks });
      held.developed = key;
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, held.pictureFramebuffer);
    gl.blitFramebuffer(0, 0, side, side, x, y, x + side, y + side, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /**
   * Drops the pictures beside a subject.
   * @param {WebGL2RenderingContext} gl
   * @param {Surface} subject
   */
  drop(gl, subject) {
    const held = this.#held.get(subject);
    if (!held) return;
    for (const made of [...held.light, held.picture]) gl.deleteTexture(made);
    for (const made of [...held.framebuffers, held.pictureFramebuffer]) gl.deleteFramebuffer(made);
    this.#held.delete(subject);
  }

  /** Forgets everything of a lost context but code. */
  lose() {
    this.#develop = null;
    this.#held.clear();
    this.#exposure.lose();
    this.#cache.lose();
  }
}

/**
 * Draws the linear light of a part.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked[]} dark
 * @param {WebGLFramebuffer[]} into of parts with BRDFs and of painted ones
 * @param {Material} material
 * @param {{surface: Shaded, paint: Seen|null, lights: PointLight[], paintLights: PaintLight[]}}
 * look `paint`: of a painted material
 */
export function drawPart(gl, dark, into, material, { surface, paint, lights, paintLights }) {
  /** @type {[number, number]} */
  const corner = [0, 0];
  gl.bindFramebuffer(gl.FRAMEBUFFER, into[paint ? 1 : 0]);
  const where = { corner, gain: 1, tone: 0, marks: false, adds: true };
  if (paint) drawPainted(gl, material.linked, surface, { paint, lights: paintLights, corner });
  else drawMaterial(gl, material, dark, { surface, lights, around: 1 }, where);
}

/** @param {WebGL2RenderingContext} gl */
export const linkDevelop = (gl) => linkNow(gl, EVERYWHERE, DEVELOP);

/**
 * Develops light into the present framebuffer.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {WebGLTexture[]} light of parts with BRDFs and of painted ones
 * @param {{gain: number, tone: number, marks: boolean}} film
 */
export function develop(gl, pen, [lit, painted], { gain, tone, marks }) {
  read(gl, pen, { lit, painted });
  gl.uniform1f(uniformLocation(gl, pen, "gain"), gain);
  gl.uniform1i(uniformLocation(gl, pen, "tone"), tone);
  gl.uniform1i(uniformLocation(gl, pen, "marks"), marks ? 1 : 0);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}

/** @param {WebGL2RenderingContext} gl @param {number} side @returns {Held} */
function makeHeld(gl, side) {
  // Halves can be added to everywhere.
  const light = [0, 1].map(() => texture(gl, gl.RGBA16F, side));
  const picture = texture(gl, gl.RGBA8, side);
  const framebuffers = light.map((one) => drawsInto(gl, one));
  const pictureFramebuffer = drawsInto(gl, picture);
  const whole = areComplete(gl, [...framebuffers, pictureFramebuffer]);
  return { side, whole, shaded: "", developed: "", light, framebuffers, picture, pictureFramebuffer };
}
