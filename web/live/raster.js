/**
 * Geometry buffer: position, normal and tangent of the nearest part of the scene at the middle of
 * each pixel, and what each part covers of a pixel, in textures that all materials share. It is
 * drawn again only if an object, the camera or the size change.
 *
 * @import { Geometry } from "./geometry.js"
 * @import { Linked } from "./program.js"
 * @import { Place } from "./stage.js"
 * @import { View } from "./camera.js"
 */
import { linkNow, uniformLocation } from "./program.js";
import { texture } from "./texture.js";

/** Vertex shader of passes over the mesh. */
export const VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 tangent;
layout(location = 3) in vec2 uv;
uniform mat3 turn;
uniform vec4 offset;
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
  p = offset.xyz + offset.w * (turn * position);
  vec3 d = p - eye;
  float z = dot(d, forward);
  float near = lens.y;
  float far = lens.z;
  vec2 at = vec2(dot(d, right), dot(d, up)) / lens.x;
  gl_Position = parallel
    ? vec4(at, 2.0 * (z - near) / (far - near) - 1.0, 1.0)
    : vec4(at, ((far + near) * z - 2.0 * far * near) / (far - near), z);
  n = turn * normal;
  u = turn * tangent;
  t = uv;
}`;

/**
 * GLSL: the normal on the side of the eye. The outside is where the mesh's normals point, for
 * either winding of its triangles.
 */
export const OUTWARDS = `
vec3 outwards(vec3 p, vec3 n, vec3 wo) {
  vec3 face = cross(dFdx(p), dFdy(p));
  vec3 normal = length(n) > 1e-9 ? normalize(n) : normalize(face);
  vec3 outside = dot(face, normal) < 0.0 ? -face : face;
  return dot(outside, wo) < 0.0 ? -normal : normal;
}`;

const LAYERS = `#version 300 es
precision highp float;
in vec3 p;
in vec3 n;
in vec3 u;
in vec2 t;
uniform vec3 eye;
uniform vec3 forward;
uniform bool parallel;
uniform bool facets;
uniform mat3 turn;
uniform float number;
layout(location = 0) out vec4 places;
layout(location = 1) out vec4 normals;
layout(location = 2) out vec4 tangents;
${OUTWARDS}
void main() {
  vec3 normal = outwards(p, n, parallel ? -forward : eye - p);
  vec3 wanted = u;
  if (facets) {
    // Direction of growing u on the triangle, from the differences between pixels.
    vec2 a = dFdx(t);
    vec2 b = dFdy(t);
    float det = a.x * b.y - a.y * b.x;
    vec3 grows = (dFdx(p) * b.y - dFdy(p) * a.y) * sign(det);
    float size = length(grows);
    vec3 own = normal * turn;
    wanted = size > 0.0 ? grows / size : turn * vec3(own.z, 0.0, -own.x);
  }
  vec3 along = wanted - normal * dot(wanted, normal);
  vec3 other = abs(normal.x) < 0.9 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
  along = length(along) > 1e-9 ? normalize(along) : normalize(cross(other, normal));
  places = vec4(p, number);
  normals = vec4(normal, t.x);
  tangents = vec4(along, t.y);
}`;

const MASK = `#version 300 es
precision highp float;
uniform vec4 channel;
out vec4 covered;
void main() { covered = channel; }`;

/** Number of samples per pixel for coverage. */
const MASK_SAMPLES = 4;
/** Parts whose coverage one mask holds, one in each channel. */
const CHANNELS = 4;

/**
 * @typedef {{side: number, parts: number, whole: boolean, layers: WebGLTexture[], masks:
 *   WebGLTexture[], depth: WebGLRenderbuffer, framebuffer: WebGLFramebuffer, maskFramebuffers:
 *   WebGLFramebuffer[], many: WebGLFramebuffer, manyMask: WebGLRenderbuffer, manyDepth:
 *   WebGLRenderbuffer}} Raster
 *   `side`: in pixels. `parts`: largest number of parts. `whole`: false if there was not enough
 *   memory. `layers`: position with the number of the part from 1, normal, tangent. `masks`:
 *   coverage by four parts each. `many`: the multisampled framebuffer of the masks.
 *
 * @typedef {{geometry: Geometry, tangents: "vertex"|"triangle", place: Place}} Mesh `tangents`: as
 *   in scenes
 *
 * @typedef {{layers: Linked, mask: Linked}} RasterPrograms
 */

/** @param {WebGL2RenderingContext} gl @returns {RasterPrograms} */
export const linkRasterPrograms = (gl) => ({
  layers: linkNow(gl, VERTEX, LAYERS),
  mask: linkNow(gl, VERTEX, MASK),
});

/**
 * @param {WebGL2RenderingContext} gl
 * @param {number} format
 * @param {number} side
 * @param {number} samples
 */
function renderbuffer(gl, format, side, samples) {
  const made = gl.createRenderbuffer();
  gl.bindRenderbuffer(gl.RENDERBUFFER, made);
  gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, side, side);
  return made;
}

/**
 * Creates a framebuffer that draws into textures, one shader output into each.
 * @param {WebGL2RenderingContext} gl
 * @param {WebGLTexture[]} into
 */
export function drawsInto(gl, ...into) {
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  into.forEach((one, k) =>
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + k, gl.TEXTURE_2D, one, 0),
  );
  gl.drawBuffers(into.map((_, k) => gl.COLOR_ATTACHMENT0 + k));
  return framebuffer;
}

/**
 * True if framebuffers can be drawn into. Leaves none bound.
 * @param {WebGL2RenderingContext} gl
 * @param {WebGLFramebuffer[]} all
 */
export function areComplete(gl, all) {
  const complete = all.every((made) => {
    gl.bindFramebuffer(gl.FRAMEBUFFER, made);
    return gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
  });
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return complete;
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {number} side
 * @param {number} parts
 * @returns {Raster}
 */
export function makeRaster(gl, side, parts) {
  const layers = [0, 1, 2].map(() => texture(gl, gl.RGBA32F, side));
  const masks = Array.from({ length: Math.ceil(parts / CHANNELS) }, () =>
    texture(gl, gl.RGBA8, side),
  );
  const depth = renderbuffer(gl, gl.DEPTH_COMPONENT24, side, 0);
  const framebuffer = drawsInto(gl, ...layers);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  const many = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, many);
  const manyMask = renderbuffer(gl, gl.RGBA8, side, MASK_SAMPLES);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, manyMask);
  const manyDepth = renderbuffer(gl, gl.DEPTH_COMPONENT24, side, MASK_SAMPLES);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, manyDepth);
  const maskFramebuffers = masks.map((mask) => drawsInto(gl, mask));
  const whole = areComplete(gl, [framebuffer, many, ...maskFramebuffers]);
  return {
    side,
    parts,
    whole,
    layers,
    masks,
    depth,
    framebuffer,
    maskFramebuffers,
    many,
    manyMask,
    manyDepth,
  };
}

/** @param {WebGL2RenderingContext} gl @param {Raster} of */
export function dropRaster(gl, of) {
  for (const made of [...of.layers, ...of.masks]) gl.deleteTexture(made);
  for (const made of [of.framebuffer, of.many, ...of.maskFramebuffers]) gl.deleteFramebuffer(made);
  for (const made of [of.depth, of.manyMask, of.manyDepth]) gl.deleteRenderbuffer(made);
}

/**
 * The mask that holds the coverage by a part, and the channel.
 * @param {Raster} of
 * @param {number} part
 * @returns {{mask: WebGLTexture, channel: number[]}}
 */
export const coverageOf = ({ masks }, part) => ({
  mask: masks[Math.floor(part / CHANNELS)],
  channel: [0, 1, 2, 3].map((k) => (k === part % CHANNELS ? 1 : 0)),
});

/**
 * Sets the uniforms of a view; those that a shader lacks are skipped.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {View} view
 */
export function bindView(gl, pen, view) {
  for (const name of /** @type {const} */ (["eye", "right", "up", "forward"]))
    gl.uniform3fv(uniformLocation(gl, pen, name), view[name]);
  gl.uniform1i(uniformLocation(gl, pen, "parallel"), view.parallel ? 1 : 0);
}

/**
 * Draws a mesh with a program.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Mesh} mesh
 * @param {View} view
 */
export function drawMesh(gl, pen, { geometry, tangents, place }, view) {
  gl.useProgram(pen.program);
  bindView(gl, pen, view);
  gl.uniform3f(uniformLocation(gl, pen, "lens"), view.half, view.near, view.far);
  gl.uniform1i(uniformLocation(gl, pen, "facets"), tangents === "triangle" ? 1 : 0);
  gl.uniformMatrix3fv(uniformLocation(gl, pen, "turn"), true, place.turn);
  gl.uniform4f(uniformLocation(gl, pen, "offset"), ...place.offset, place.size);
  gl.bindVertexArray(geometry.vertices);
  gl.drawElements(gl.TRIANGLES, geometry.corners, gl.UNSIGNED_INT, 0);
  gl.bindVertexArray(null);
}

/**
 * Draws all parts of a scene.
 * @param {WebGL2RenderingContext} gl
 * @param {RasterPrograms} pens
 * @param {Raster} into
 * @param {Mesh[]} meshes
 * @param {View} view
 */
export function drawRaster(gl, pens, into, meshes, view) {
  const { side } = into;
  gl.viewport(0, 0, side, side);
  gl.disable(gl.SCISSOR_TEST);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(0, 0, 0, 0);
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.framebuffer);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  meshes.forEach((mesh, part) => {
    gl.useProgram(pens.layers.program);
    gl.uniform1f(uniformLocation(gl, pens.layers, "number"), part + 1);
    drawMesh(gl, pens.layers, mesh, view);
  });
  into.masks.forEach((mask, group) => {
    gl.bindFramebuffer(gl.FRAMEBUFFER, into.many);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    meshes.forEach((mesh, part) => {
      const { mask: own, channel } = coverageOf(into, part);
      gl.useProgram(pens.mask.program);
      gl.uniform4fv(
        uniformLocation(gl, pens.mask, "channel"),
        own === mask ? channel : [0, 0, 0, 0],
      );
      drawMesh(gl, pens.mask, mesh, view);
    });
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, into.many);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, into.maskFramebuffers[group]);
    gl.blitFramebuffer(0, 0, side, side, 0, 0, side, side, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  });
  gl.disable(gl.DEPTH_TEST);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}
