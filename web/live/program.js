/** Compiling and linking of shaders without waiting: callers check again in the next frame. */
import { CELL } from "./cells.js";

/** Vertex shader: a triangle that covers the whole picture. */
export const EVERYWHERE = `#version 300 es
void main() { gl_Position = vec4(float(gl_VertexID & 1) * 4.0 - 1.0, float(gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;

/** Vertex shader: a polygon with given corners, or square cells around points. */
export const OUTLINED = `#version 300 es
layout(location = 0) in vec2 corner_at;
void main() {
  gl_Position = vec4(corner_at, 0.0, 1.0);
  gl_PointSize = ${CELL}.0;
}`;

/**
 * @typedef {{program: WebGLProgram, shaders: WebGLShader[], places: Map<string,
 *   WebGLUniformLocation|null>}} Linked
 */

/**
 * Starts compiling and linking.
 * @param {WebGL2RenderingContext} gl
 * @param {string} vertex
 * @param {string} fragment
 * @returns {Linked}
 */
export function link(gl, vertex, fragment) {
  const program = gl.createProgram();
  const shaders = [];
  for (const [kind, source] of /** @type {[number, string][]} */ ([
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ])) {
    const shader = gl.createShader(kind);
    if (!shader) break;
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    shaders.push(shader);
  }
  gl.linkProgram(program);
  return { program, shaders, places: new Map() };
}

/**
 * True if linking is finished. Without the extension the query blocks until it is.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 */
export function isLinked(gl, linked) {
  const parallel = gl.getExtension("KHR_parallel_shader_compile");
  return (
    !parallel ||
    gl.getProgramParameter(linked.program, parallel.COMPLETION_STATUS_KHR) === true ||
    gl.isContextLost()
  );
}

/**
 * Reason why linking failed; null if it succeeded, or if the context is lost, which is not an error
 * of the shader.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 * @returns {string|null}
 */
export function linkError(gl, linked) {
  if (gl.isContextLost() || gl.getProgramParameter(linked.program, gl.LINK_STATUS)) return null;
  const logs = linked.shaders.map((shader) => gl.getShaderInfoLog(shader)).filter(Boolean);
  return logs.join("\n") || gl.getProgramInfoLog(linked.program) || "no reason given";
}

/** @param {WebGL2RenderingContext} gl @param {Linked} linked */
export function deleteProgram(gl, linked) {
  for (const shader of linked.shaders) gl.deleteShader(shader);
  gl.deleteProgram(linked.program);
}

/**
 * Location of a uniform, queried once.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 * @param {string} name
 */
export function uniformLocation(gl, linked, name) {
  if (!linked.places.has(name))
    linked.places.set(name, gl.getUniformLocation(linked.program, name));
  return linked.places.get(name) ?? null;
}

/**
 * Binds textures by their names in a shader.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Record<string, WebGLTexture>} textures
 */
export function read(gl, pen, textures) {
  gl.useProgram(pen.program);
  Object.entries(textures).forEach(([name, held], unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, held);
    gl.uniform1i(uniformLocation(gl, pen, name), unit);
  });
}

/**
 * Compiles and links, waiting for the result; throws if that fails.
 * @param {WebGL2RenderingContext} gl
 * @param {string} vertex
 * @param {string} fragment
 * @returns {Linked}
 */
export function linkNow(gl, vertex, fragment) {
  const linked = link(gl, vertex, fragment);
  const reason = linkError(gl, linked);
  if (reason !== null) throw new Error(reason);
  return linked;
}
