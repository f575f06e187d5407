/**
 * Backdrop of live frames: the environments, a colour or a picture behind the object.
 *
 * @import { Scene } from "../model.js"
 * @import { Picture } from "./backdrop_picture.js"
 * @import { Linked } from "./program.js"
 * @import { Spheres } from "./spheres.js"
 */
import { FILM } from "./film.js";
import { EVERYWHERE, linkNow, read, uniformLocation } from "./program.js";

/** Kinds of backdrop in the order of their numbers in the shader. */
const KINDS = ["color", "environment", "image"];
/** Share of a square texture that a frame shows. @type {[number, number]} */
const WHOLE = [1, 1];

const BACKDROP = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D backdrop;
uniform int kind;
uniform vec3 plain;
uniform float gain;
uniform vec2 cover;
uniform vec2 corner;
uniform float side;
out vec4 color;
${FILM}
void main() {
  vec2 at = (gl_FragCoord.xy - corner) / side;
  // The first row is the top.
  vec4 texel = texture(backdrop, 0.5 + cover * (vec2(at.x, 1.0 - at.y) - 0.5));
  vec3 code = kind == 0 ? plain : srgb(toned(texel.rgb * gain));
  color = kind == 2 ? texel : vec4(code, 1.0);
}`;

/** @param {WebGL2RenderingContext} gl */
export const linkBackdrop = (gl) => linkNow(gl, EVERYWHERE, BACKDROP);

/**
 * Draws the backdrop of a scene behind what the square at a corner of the framebuffer shows.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Scene} scene
 * @param {{spheres: Spheres|null, picture: Picture|null}} from `spheres`: of the material, with
 *   the environments behind it; `picture`: of the scene
 * @param {{corner: [number, number], side: number, gain: number, tone: number}} where as those of
 *   the material
 */
export function drawBackdrop(gl, pen, { backdrop }, { spheres, picture }, where) {
  const { corner, side, gain, tone } = where;
  if (!backdrop) return;
  const lit = backdrop.kind === "environment" ? (spheres?.backdrop ?? null) : null;
  const seen = backdrop.kind === "image" ? picture : null;
  const shown = lit ?? seen;
  if (backdrop.kind !== "color" && !shown) return;
  read(gl, pen, shown ? { backdrop: shown.texture } : {});
  gl.uniform1i(uniformLocation(gl, pen, "kind"), KINDS.indexOf(backdrop.kind));
  gl.uniform2f(uniformLocation(gl, pen, "cover"), ...(seen?.cover ?? WHOLE));
  gl.uniform3fv(
    uniformLocation(gl, pen, "plain"),
    backdrop.kind === "color" ? backdrop.color : [0, 0, 0],
  );
  gl.uniform1f(uniformLocation(gl, pen, "gain"), gain * (lit?.unit ?? 1));
  gl.uniform1i(uniformLocation(gl, pen, "tone"), tone);
  gl.uniform2f(uniformLocation(gl, pen, "corner"), ...corner);
  gl.uniform1f(uniformLocation(gl, pen, "side"), side);
  gl.viewport(...corner, side, side);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE_MINUS_DST_ALPHA, gl.ONE);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.disable(gl.BLEND);
}
