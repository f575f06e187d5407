/**
 * What the camera sees of the object, pixel by pixel: place, normal, tangent, texture position and coverage, drawn once for all
 * materials and again only when object, camera or size change. Owns the textures; knows nothing of materials and lights.
 *
 * @import { Geometry } from "./geometry.js"
 * @import { Linked } from "./program.js"
 * @import { View } from "./view.js"
 */
import { linkNow, place } from "./program.js";

const VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 tangent;
layout(location = 3) in vec2 uv;
uniform vec3 eye;
uniform vec3 right;
uniform vec3 up;
uniform vec3 forward;
uniform vec3 lens;
uniform bool parallel;
out vec3 p;
out vec3 n;
out vec3 u;
out vec2 t;
void main() {
  vec3 d = position - eye;
  float z = dot(d, forward);
  float near = lens.y;
  float far = lens.z;
  vec2 at = vec2(dot(d, right), dot(d, up)) / lens.x;
  gl_Position = parallel
    ? vec4(at, 2.0 * (z - near) / (far - near) - 1.0, 1.0)
    : vec4(at, ((far + near) * z - 2.0 * far * near) / (far - near), z);
  p = position;
  n = normal;
  u = tangent;
  t = uv;
}`;

// The normal is put on the side that the eye sees; outside is where the mesh's normals point, whichever way corners go round.
const SURFACE = `#version 300 es
precision highp float;
in vec3 p;
in vec3 n;
in vec3 u;
in vec2 t;
uniform vec3 eye;
uniform vec3 forward;
uniform bool parallel;
layout(location = 0) out vec4 places;
layout(location = 1) out vec4 normals;
layout(location = 2) out vec4 tangents;
void main() {
  vec3 face = cross(dFdx(p), dFdy(p));
  vec3 normal = length(n) > 1e-9 ? normalize(n) : normalize(face);
  vec3 outwards = dot(face, normal) < 0.0 ? -face : face;
  vec3 wo = parallel ? -forward : eye - p;
  if (dot(outwards, wo) < 0.0) normal = -normal;
  vec3 along = u - normal * dot(u, normal);
  vec3 other = abs(normal.x) < 0.9 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
  along = length(along) > 1e-9 ? normalize(along) : normalize(cross(other, normal));
  places = vec4(p, 1.0);
  normals = vec4(normal, t.x);
  tangents = vec4(along, t.y);
}`;

const MASK = `#version 300 es
precision highp float;
out vec4 covered;
void main() { covered = vec4(1.0); }`;

/** Rays of a pixel that decide how much of it is covered. */
const MASK_SAMPLES = 4;

/**
 * @typedef {{side: number, layers: WebGLTexture[], mask: WebGLTexture, framebuffer: WebGLFramebuffer, depth: WebGLRenderbuffer,
 *   maskFramebuffer: WebGLFramebuffer, many: WebGLFramebuffer, manyMask: WebGLRenderbuffer, manyDepth: WebGLRenderbuffer}} Surface
 *
 * @typedef {{surface: Linked, mask: Linked}} Pens
 */

/** @param {WebGL2RenderingContext} gl @returns {Pens} */
export const makePens = (gl) => ({ surface: linkNow(gl, VERTEX, SURFACE), mask: linkNow(gl, VERTEX, MASK) });

/** @param {WebGL2RenderingContext} gl @param {number} format @param {number} side */
function texture(gl, format, side) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, side, side);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  return made;
}

/** @param {WebGL2RenderingContext} gl @param {number} format @param {number} side @param {number} samples */
function renderbuffer(gl, format, side, samples) {
  const made = gl.createRenderbuffer();
  gl.bindRenderbuffer(gl.RENDERBUFFER, made);
  gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, side, side);
  return made;
}

/** @param {WebGL2RenderingContext} gl @param {number} side @returns {Surface} */
export function makeSurface(gl, side) {
  const layers = [0, 1, 2].map(() => texture(gl, gl.RGBA32F, side));
  const mask = texture(gl, gl.RGBA8, side);
  const depth = renderbuffer(gl, gl.DEPTH_COMPONENT24, side, 0);
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  layers.forEach((layer, k) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + k, gl.TEXTURE_2D, layer, 0));
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1, gl.COLOR_ATTACHMENT2]);
  const many = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, many);
  const manyMask = renderbuffer(gl, gl.RGBA8, side, MASK_SAMPLES);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, manyMask);
  const manyDepth = renderbuffer(gl, gl.DEPTH_COMPONENT24, side, MASK_SAMPLES);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, manyDepth);
  const maskFramebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, maskFramebuffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, mask, 0);
  return { side, layers, mask, framebuffer, depth, maskFramebuffer, many, manyMask, manyDepth };
}

/** @param {WebGL2RenderingContext} gl @param {Surface} of */
export function dropSurface(gl, of) {
  for (const made of [...of.layers, of.mask]) gl.deleteTexture(made);
  for (const made of [of.framebuffer, of.maskFramebuffer, of.many]) gl.deleteFramebuffer(made);
  for (const made of [of.depth, of.manyMask, of.manyDepth]) gl.deleteRenderbuffer(made);
}

/** @param {WebGL2RenderingContext} gl @param {Linked} pen @param {Geometry} geometry @param {View} view */
function draw(gl, pen, geometry, view) {
  gl.useProgram(pen.program);
  for (const name of /** @type {const} */ (["eye", "right", "up", "forward"])) gl.uniform3fv(place(gl, pen, name), view[name]);
  gl.uniform3f(place(gl, pen, "lens"), view.half, view.near, view.far);
  gl.uniform1i(place(gl, pen, "parallel"), view.parallel ? 1 : 0);
  gl.bindVertexArray(geometry.vertices);
  gl.drawElements(gl.TRIANGLES, geometry.corners, gl.UNSIGNED_INT, 0);
  gl.bindVertexArray(null);
}

/**
 * Draws the object into the textures.
 * @param {WebGL2RenderingContext} gl
 * @param {Pens} pens
 * @param {Surface} into
 * @param {Geometry} geometry
 * @param {View} view
 */
export function drawSurface(gl, pens, into, geometry, view) {
  gl.viewport(0, 0, into.side, into.side);
  gl.disable(gl.SCISSOR_TEST);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(0, 0, 0, 0);
  for (const [framebuffer, pen] of /** @type {[WebGLFramebuffer, Linked][]} */ ([[into.framebuffer, pens.surface], [into.many, pens.mask]])) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    draw(gl, pen, geometry, view);
  }
  gl.disable(gl.DEPTH_TEST);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, into.many);
  gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, into.maskFramebuffer);
  gl.blitFramebuffer(0, 0, into.side, into.side, 0, 0, into.side, into.side, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}
