/**
 * Colours that the rays of clear subjects see, made once for an angle of the light. Frames of one
 * size whose materials have the same index of refraction share them. A ray that ends at the subject
 * itself, at most one of 500 on the built-in meshes, sees the colour of the depth.
 *
 * @import { Cell, Scene } from "../model.js"
 * @import { Picture } from "./backdrop_picture.js"
 * @import { Material } from "./material.js"
 * @import { Light } from "./others.js"
 * @import { PaintedSurfaces } from "./paint.js"
 * @import { Linked } from "./program.js"
 * @import { Ends } from "./ray_ends.js"
 * @import { SurfacePrograms } from "./surface.js"
 */
import { develop, drawPart, linkDevelop } from "./others.js";
import { OUTLINED, linkNow, read, uniformLocation } from "./program.js";
import { RayEnds, endsKey } from "./ray_ends.js";
import { drawWithin, lightSurface } from "./surface.js";

/** Colours of a backdrop where rays see it. */
const BEHIND = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D point;
uniform sampler2D backdrop;
uniform bool pictured;
uniform vec3 plain;
uniform vec2 cover;
uniform float pixels;
out vec4 color;
void main() {
  vec2 at = texelFetch(point, ivec2(gl_FragCoord.xy), 0).xy;
  ivec2 size = textureSize(backdrop, 0);
  float level = log2(max(1.0, float(min(size.x, size.y)) / pixels));
  // The first row is the top.
  vec4 texel = textureLod(backdrop, 0.5 + cover * (vec2(at.x, 1.0 - at.y) - 0.5), level);
  vec4 straight = texel.a >= 0.5 ? vec4(texel.rgb / texel.a, 1.0) : vec4(0.0);
  color = pictured ? straight : vec4(plain, 1.0);
}`;

export class ClearBodies {
  #ends;
  /** @type {{develop: Linked, behind: Linked}|null} */
  #pens = null;

  /** @param {() => void} changed is called when ends of rays have arrived */
  constructor(changed) {
    this.#ends = new RayEnds(changed);
  }

  /**
   * True if clear subjects can be drawn: where all parts are as in the stored scene, and without
   * environments, which rays would see.
   * @param {Scene} scene
   * @param {Scene} confirmed the stored scene
   */
  canDraw(scene, confirmed) {
    const isLit = (scene.lights ?? []).every(({ kind }) => kind !== "environment");
    const isKnown = () => confirmed.id && endsKey(scene) === endsKey(confirmed);
    return isLit && !this.#ends.overflows && Boolean(isKnown());
  }

  /**
   * The ends of the rays of clear materials.
   * @param {WebGL2RenderingContext} gl
   * @param {{scene: Scene, slots: number}} of `scene`: the stored one; `slots`: number of lights
   * @param {{cell: Cell, material: Material, side: number}[]} drawn `side`: of the frame
   * @returns {Map<Cell, Ends>|null} null while some are being loaded
   */
  prepare(gl, { scene, slots }, drawn) {
    const clear = drawn.filter(({ material }) => material.index !== null);
    if (clear.length === 0) return new Map();
    const of = { key: endsKey(scene), sceneId: scene.id ?? "", slots, hasShadows: scene.shadows };
    this.#ends.begin();
    // The centre is requested first, because users look there first.
    clear.sort((one, other) => Number(other.cell === "centre") - Number(one.cell === "centre"));
    const found = clear.map(({ cell, material, side }) =>
      /** @type {const} */ ([cell, this.#ends.of(gl, of, { index: material.index ?? 1, side })]),
    );
    const known = found.flatMap(([cell, ends]) => (ends ? [/** @type {const} */ ([cell, ends])] : []));
    return known.length === found.length ? new Map(known) : null;
  }

  /**
   * Colours what rays see, unless it is known.
   * @param {WebGL2RenderingContext} gl
   * @param {{pens: SurfacePrograms, dark: Linked[], painted: PaintedSurfaces}} tools
   * @param {Ends} ends
   * @param {Material[]} materials of the other parts
   * @param {Light & {passed: number}} light
   *   `passed`: share of light that passes through the subject
   * @param {{scene: Scene, picture: Picture|null, gain: number, tone: number}} film `picture`: of
   *   the backdrop; `gain`: for the lights of `light`
   */
  shade(gl, { pens, dark, painted }, ends, materials, light, { scene, picture, gain, tone }) {
    const others = ends.parts.slice(1, -1);
    if (ends.shaded !== light.key) {
      gl.disable(gl.SCISSOR_TEST);
      gl.clearColor(0, 0, 0, 0);
      for (const made of ends.framebuffers) {
        gl.bindFramebuffer(gl.FRAMEBUFFER, made);
        gl.clear(gl.COLOR_BUFFER_BIT);
      }
      const { lights, paintLights } = light;
      const shadows = ends.shadowsOf(light.passed);
      for (const [index, surface] of others.entries()) {
        const material = materials[index];
        const paint = material.painted ? painted.lightEnds(gl, ends, { ...light, shadows }) : null;
        if (!paint) lightSurface(gl, pens, surface, lights, shadows);
        drawPart(gl, dark, ends.framebuffers, material, { surface, paint, lights, paintLights });
      }
      ends.shaded = light.key;
      ends.developed = "";
    }
    const { backdrop } = scene;
    const developed = JSON.stringify([gain, tone, backdrop]);
    if (ends.developed !== developed) {
      this.#pens ??= { develop: linkDevelop(gl), behind: linkNow(gl, OUTLINED, BEHIND) };
      gl.bindFramebuffer(gl.FRAMEBUFFER, ends.colorFramebuffer);
      gl.viewport(0, 0, ends.side, ends.side);
      develop(gl, this.#pens.develop, ends.lit, { gain, tone, marks: false });
      if (backdrop?.kind === "color" || (backdrop?.kind === "image" && picture)) {
        const pen = this.#pens.behind;
        const [point] = ends.all.found;
        // A shader without a picture reads any texture.
        read(gl, pen, { point, backdrop: picture?.texture ?? point });
        gl.uniform1i(uniformLocation(gl, pen, "pictured"), backdrop.kind === "image" ? 1 : 0);
        gl.uniform3fv(
          uniformLocation(gl, pen, "plain"),
          backdrop.kind === "color" ? backdrop.color : [0, 0, 0],
        );
        gl.uniform2f(uniformLocation(gl, pen, "cover"), ...(picture?.cover ?? [1, 1]));
        gl.uniform1f(uniformLocation(gl, pen, "pixels"), ends.pixels);
        drawWithin(gl, ends.parts[ends.parts.length - 1]);
      }
      ends.developed = developed;
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** Forgets everything of a lost context. */
  lose() {
    this.#pens = null;
    this.#ends.lose();
  }
}
