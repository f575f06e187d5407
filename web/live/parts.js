/**
 * The part of a surface that lights may reach: about half of an object at any time, and all of it that need be shaded. What the
 * surface shows is read back without waiting; until it is there, nothing is known. Owns that and the cells as points; knows
 * nothing of materials.
 *
 * @import { Cells } from "./cells.js"
 * @import { PointLight } from "./view.js"
 */
import { CELL, cellsOf, reached } from "./cells.js";

/**
 * @typedef {{cells: Cells|null, fence: WebGLSync|null, pixels: WebGLBuffer|null, vertices: WebGLVertexArrayObject, buffer: WebGLBuffer, lit: number}} Parts
 *   `cells`: null until they are known; `lit`: how many of them lights may reach.
 */

/** @param {WebGL2RenderingContext} gl @returns {Parts} */
export function makeParts(gl) {
  const [vertices, buffer] = [gl.createVertexArray(), gl.createBuffer()];
  gl.bindVertexArray(vertices);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  gl.bindVertexArray(null);
  return { cells: null, fence: null, pixels: null, vertices, buffer, lit: 0 };
}

/** The surface shows something else. @param {WebGL2RenderingContext} gl @param {Parts} of */
export function forgetParts(gl, of) {
  gl.deleteSync(of.fence);
  gl.deleteBuffer(of.pixels);
  of.fence = null;
  of.pixels = null;
  of.cells = null;
}

/** @param {WebGL2RenderingContext} gl @param {Parts} of */
export function dropParts(gl, of) {
  forgetParts(gl, of);
  gl.deleteVertexArray(of.vertices);
  gl.deleteBuffer(of.buffer);
}

/**
 * Brings it one step nearer to being known.
 * @param {WebGL2RenderingContext} gl
 * @param {{side: number, foundFramebuffer: WebGLFramebuffer, parts: Parts}} surface
 * @returns {boolean} whether there is more to be done
 */
export function learnParts(gl, { side, foundFramebuffer, parts }) {
  // Few graphics processors, if any, cannot draw points as large.
  if (parts.cells || gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE)[1] < CELL) return false;
  const numbers = 4 * side * side;
  if (!parts.fence) {
    parts.pixels = gl.createBuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, foundFramebuffer);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, parts.pixels);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, 8 * numbers, gl.STREAM_READ);
    // Points, then normals.
    for (const k of [0, 1]) {
      gl.readBuffer(gl.COLOR_ATTACHMENT1 + k);
      gl.readPixels(0, 0, side, side, gl.RGBA, gl.FLOAT, 4 * numbers * k);
    }
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    parts.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    return true;
  }
  if (gl.clientWaitSync(parts.fence, 0, 0) === gl.TIMEOUT_EXPIRED) return true;
  const found = new Float32Array(2 * numbers);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, parts.pixels);
  gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, found);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  forgetParts(gl, parts);
  parts.cells = cellsOf(found.subarray(0, numbers), found.subarray(numbers), side);
  return false;
}

/** Finds what the lights may reach, where that can be known. @param {WebGL2RenderingContext} gl @param {Parts} of @param {PointLight[]} lights */
export function lightParts(gl, of, lights) {
  if (!of.cells) return;
  const middles = reached(of.cells, lights);
  gl.bindBuffer(gl.ARRAY_BUFFER, of.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, middles, gl.DYNAMIC_DRAW);
  of.lit = middles.length / 2;
}

/**
 * Draws what lights may reach in the square at a corner. Cells lie on even pixels of the screen, whatever the corner.
 * @param {WebGL2RenderingContext} gl
 * @param {{side: number, parts: Parts}} surface
 * @param {[number, number]} corner
 */
export function drawReached(gl, { side, parts: { cells, vertices, lit } }, corner) {
  if (!cells) return;
  gl.viewport(corner[0] & ~1, corner[1] & ~1, CELL * cells.across, CELL * cells.across);
  gl.enable(gl.SCISSOR_TEST);
  gl.scissor(corner[0], corner[1], side, side);
  gl.bindVertexArray(vertices);
  gl.drawArrays(gl.POINTS, 0, lit);
  gl.bindVertexArray(null);
  gl.disable(gl.SCISSOR_TEST);
}
