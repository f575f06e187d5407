/**
 * Cells of a surface that lights may reach: about half of the object at any time, and all that has
 * to be shaded. The surface is read back from the GPU without waiting; until then the cells are
 * unknown.
 *
 * @import { Cells } from "./cells.js"
 * @import { PointLight } from "./camera.js"
 */
import { CELL, cellsOf, litMiddles } from "./cells.js";

/**
 * @typedef {{cells: Cells|null, fence: WebGLSync|null, pixels: WebGLBuffer|null, vertices:
 *   WebGLVertexArrayObject, buffer: WebGLBuffer, lit: number}} LitCells `cells`: null while
 *   unknown; `fence`, `pixels`: of the read-back while it runs; `buffer`: middles of the cells that
 *   lights may reach; `lit`: number of these.
 */

/** @param {WebGL2RenderingContext} gl @returns {LitCells} */
export function makeLitCells(gl) {
  const [vertices, buffer] = [gl.createVertexArray(), gl.createBuffer()];
  gl.bindVertexArray(vertices);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  gl.bindVertexArray(null);
  return { cells: null, fence: null, pixels: null, vertices, buffer, lit: 0 };
}

/**
 * Discards the cells because the surface has changed.
 * @param {WebGL2RenderingContext} gl
 * @param {LitCells} of
 */
export function resetLitCells(gl, of) {
  gl.deleteSync(of.fence);
  gl.deleteBuffer(of.pixels);
  of.fence = null;
  of.pixels = null;
  of.cells = null;
}

/** @param {WebGL2RenderingContext} gl @param {LitCells} of */
export function dropLitCells(gl, of) {
  resetLitCells(gl, of);
  gl.deleteVertexArray(of.vertices);
  gl.deleteBuffer(of.buffer);
}

/**
 * Advances the read-back by one step.
 * @param {WebGL2RenderingContext} gl
 * @param {{side: number, foundFramebuffer: WebGLFramebuffer, litCells: LitCells}} surface
 * @returns {boolean} true if more steps are needed
 */
export function readLitCells(gl, { side, foundFramebuffer, litCells }) {
  // Without points of this size the cells cannot be drawn. Almost all GPUs have them.
  if (litCells.cells || gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE)[1] < CELL) return false;
  const numbers = 4 * side * side;
  if (!litCells.fence) {
    litCells.pixels = gl.createBuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, foundFramebuffer);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, litCells.pixels);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, 8 * numbers, gl.STREAM_READ);
    // Points first, then normals.
    for (const k of [0, 1]) {
      gl.readBuffer(gl.COLOR_ATTACHMENT1 + k);
      gl.readPixels(0, 0, side, side, gl.RGBA, gl.FLOAT, 4 * numbers * k);
    }
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    litCells.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    return true;
  }
  if (gl.clientWaitSync(litCells.fence, 0, 0) === gl.TIMEOUT_EXPIRED) return true;
  const found = new Float32Array(2 * numbers);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, litCells.pixels);
  gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, found);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  resetLitCells(gl, litCells);
  litCells.cells = cellsOf(found.subarray(0, numbers), found.subarray(numbers), side);
  return false;
}

/**
 * Finds the cells that the lights may reach.
 * @param {WebGL2RenderingContext} gl
 * @param {LitCells} of
 * @param {PointLight[]} lights
 */
export function updateLitCells(gl, of, lights) {
  if (!of.cells) return;
  const middles = litMiddles(of.cells, lights);
  gl.bindBuffer(gl.ARRAY_BUFFER, of.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, middles, gl.DYNAMIC_DRAW);
  of.lit = middles.length / 2;
}

/**
 * Draws the lit cells in the square at a corner. Cells are aligned to even pixels of the screen.
 * @param {WebGL2RenderingContext} gl
 * @param {{side: number, litCells: LitCells}} surface
 * @param {[number, number]} corner
 */
export function drawLitCells(gl, { side, litCells: { cells, vertices, lit } }, corner) {
  if (!cells) return;
  gl.viewport(corner[0] & ~1, corner[1] & ~1, CELL * cells.across, CELL * cells.across);
  gl.enable(gl.SCISSOR_TEST);
  gl.scissor(corner[0], corner[1], side, side);
  gl.bindVertexArray(vertices);
  gl.drawArrays(gl.POINTS, 0, lit);
  gl.bindVertexArray(null);
  gl.disable(gl.SCISSOR_TEST);
}
