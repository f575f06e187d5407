/**
 * Radiance of materials in the environments of the scene, on a surface. It is drawn once for each
 * material while object and camera rest: lights that move do not change it.
 *
 * @import { Linked } from "./program.js"
 * @import { Spheres } from "./spheres.js"
 * @import { Surface, SurfacePrograms } from "./surface.js"
 */
import { read } from "./program.js";
import { drawsInto } from "./raster.js";
import { drawWithin } from "./surface.js";
import { texture } from "./texture.js";

/**
 * Draws the radiance of a material in the environments, unless it is known. Leaves no framebuffer
 * bound if it draws.
 * @param {WebGL2RenderingContext} gl
 * @param {SurfacePrograms} pens
 * @param {Surface} surface
 * @param {Spheres} spheres
 */
export function drawSurroundings(gl, pens, surface, spheres) {
  let held = surface.surroundings.get(spheres);
  if (!held) {
    const made = texture(gl, gl.RGBA16F, surface.side);
    held = { texture: made, framebuffer: drawsInto(gl, made), known: false };
    surface.surroundings.set(spheres, held);
  }
  if (held.known) return;
  const [lower, upper, between] = surface.places;
  gl.bindFramebuffer(gl.FRAMEBUFFER, held.framebuffer);
  gl.viewport(0, 0, surface.side, surface.side);
  read(gl, pens.surroundings, { lower, upper, between, spheres: spheres.texture });
  drawWithin(gl, surface);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  held.known = true;
}

/**
 * Drops what is held for other materials than these.
 * @param {WebGL2RenderingContext} gl
 * @param {Surface} surface
 * @param {Set<Spheres|null>} kept
 */
export function keepSurroundings(gl, surface, kept) {
  for (const [spheres, { texture: made, framebuffer }] of surface.surroundings) {
    if (kept.has(spheres)) continue;
    gl.deleteTexture(made);
    gl.deleteFramebuffer(framebuffer);
    surface.surroundings.delete(spheres);
  }
}
