/**
 * Shaders compiled and linked without waiting: whoever asks looks again at the next frame. Owns compilation; knows nothing of
 * what the shaders do.
 */
import { CELL } from "./cells.js";

/** A triangle that covers everything. */
export const EVERYWHERE = `#version 300 es
void main() { gl_Position = vec4(float(gl_VertexID & 1) * 4.0 - 1.0, float(gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;

/** What lies in a polygon, whose corners are given, or in cells around points. */
export const OUTLINED = `#version 300 es
layout(location = 0) in vec2 corner_at;
void main() {
  gl_Position = vec4(corner_at, 0.0, 1.0);
  gl_PointSize = ${CELL}.0;
}`;

/**
 * @typedef {{program: WebGLProgram, shaders: WebGLShader[], places: Map<string, WebGLUniformLocation|null>}} Linked
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
  for (const [kind, source] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
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
 * Whether linking is over. Without the extension it is asked for at once, which waits.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 */
export function isLinked(gl, linked) {
  const parallel = gl.getExtension("KHR_parallel_shader_compile");
  return !parallel || gl.getProgramParameter(linked.program, parallel.COMPLETION_STATUS_KHR) === true || gl.isContextLost();
}

/**
 * Why it could not be linked; null where it could, and where the context is lost, which says nothing about the shader.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 * @returns {string|null}
 */
export function refusal(gl, linked) {
  if (gl.isContextLost() || gl.getProgramParameter(linked.program, gl.LINK_STATUS)) return null;
  const logs = linked.shaders.map((shader) => gl.getShaderInfoLog(shader)).filter(Boolean);
  return logs.join("\n") || gl.getProgramInfoLog(linked.program) || "no reason given";
}

/** @param {WebGL2RenderingContext} gl @param {Linked} linked */
export function drop(gl, linked) {
  for (const shader of linked.shaders) gl.deleteShader(shader);
  gl.deleteProgram(linked.program);
}

/**
 * Where a uniform is, looked up once.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 * @param {string} name
 */
export function place(gl, linked, name) {
  if (!linked.places.has(name)) linked.places.set(name, gl.getUniformLocation(linked.program, name));
  return linked.places.get(name) ?? null;
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {string} vertex
 * @param {string} fragment
 * @returns {Linked}
 */
export function linkNow(gl, vertex, fragment) {
  const linked = link(gl, vertex, fragment);
  const reason = refusal(gl, linked);
  if (reason !== null) throw new Error(reason);
  return linked;
}
