/**
 * Backdrop of live frames: the environments or a colour behind the object.
 *
 * @import { Scene } from "../model.js"
 * @import { Linked } from "./program.js"
 * @import { Spheres } from "./spheres.js"
 */
import { FILM } from "./film.js";
import { EVERYWHERE, linkNow, read, uniformLocation } from "./program.js";

const BACKDROP = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D backdrop;
uniform bool lit;
uniform vec3 plain;
uniform float gain;
uniform vec2 corner;
uniform float side;
out vec4 color;
${FILM}
void main() {
  vec2 at = (gl_FragCoord.xy - corner) / side;
  // The first row is the top.
  vec3 radiance = texture(backdrop, vec2(at.x, 1.0 - at.y)).rgb;
  color = vec4(lit ? srgb(toned(radiance * gain)) : plain, 1.0);
}`;

/** @param {WebGL2RenderingContext} gl */
export const linkBackdrop = (gl) => linkNow(gl, EVERYWHERE, BACKDROP);

/**
 * Draws the backdrop of a scene behind what the square at a corner of the framebuffer shows.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Scene} scene
 * @param {Spheres|null} spheres of the material, with the environments behind it
 * @param {{corner: [number, number], side: number, gain: number, tone: number}} where as those of
 *   the material
 */
export function drawBackdrop(gl, pen, { backdrop }, spheres, { corner, side, gain, tone }) {
  const lit = backdrop?.kind === "environment" ? (spheres?.backdrop ?? null) : null;
  if (!backdrop || (backdrop.kind === "environment" && !lit)) return;
  read(gl, pen, lit ? { backdrop: lit.texture } : {});
  gl.uniform1i(uniformLocation(gl, pen, "lit"), lit ? 1 : 0);
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
