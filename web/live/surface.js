/**
 * What the camera sees of the object, and the light that falls on it, in textures shared by all
 * materials (deferred shading). The surface is drawn again only if object, camera or size change,
 * the light if it moves.
 *
 * Passes: the mesh into `layers` (position, normal, tangent of each pixel's centre); the mesh with
 * multisampling into `mask` (coverage); a pass over all pixels that finds a shading point for each
 * and writes `seen` and `found`; and for each light a pass that writes a slot of `lit`. The last is
 * straight-line code: software renderers run both sides of every branch and lose more time on the
 * branch than on its content.
 *
 * A material reads two texels a pixel: `seen` holds the direction to the eye (its tangential part
 * in the local frame) and the texture coordinates, `lit` the direction to a light (likewise), cos_i
 * over the squared distance, and the coverage.
 *
 * @import { Geometry } from "./geometry.js"
 * @import { LitCells } from "./lit_cells.js"
 * @import { Linked } from "./program.js"
 * @import { PointLight, View } from "./camera.js"
 * @import { Spheres } from "./spheres.js"
 */
import { dropLitCells, makeLitCells, resetLitCells } from "./lit_cells.js";
import { SIDES, outline, triangles } from "./outline.js";
import { EVERYWHERE, OUTLINED, linkNow, read, uniformLocation } from "./program.js";
import { REACHED, angleOf } from "./shadows.js";
import { PLACES, SURROUNDINGS, TURNED_PLACES } from "./spheres.js";
import { texture } from "./texture.js";

/** Vertex shader of passes over the mesh. */
export const VERTEX = `#version 300 es
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

const SURFACE = `#version 300 es
precision highp float;
in vec3 p;
in vec3 n;
in vec3 u;
in vec2 t;
uniform vec3 eye;
uniform vec3 forward;
uniform bool parallel;
uniform bool facets;
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
    wanted = size > 0.0 ? grows / size : vec3(normal.z, 0.0, -normal.x);
  }
  vec3 along = wanted - normal * dot(wanted, normal);
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

/** GLSL: the pixel whose point a pixel takes: its own, or one beside it; -1 if there is none. */
export const NEAREST_FOUND = `
ivec2 found(ivec2 at) {
  ivec2 last = textureSize(places, 0) - 1;
  for (int k = 0; k < 9; k++) {
    // The pixel itself, then those beside it, then those at its corners.
    int way = (k * 2 + (k > 4 ? 0 : 4)) % 9;
    ivec2 beside = k == 0 ? at : clamp(at + ivec2(way % 3 - 1, way / 3 - 1), ivec2(0), last);
    if (texelFetch(places, beside, 0).w != 0.0) return beside;
  }
  return ivec2(-1);
}`;

/**
 * Finds the shading point of each pixel, once for all lights: an edge pixel whose centre misses the
 * object takes that of a neighbour.
 */
const FOUND = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D places;
uniform sampler2D normals;
uniform sampler2D tangents;
uniform sampler2D mask;
uniform vec3 eye;
uniform vec3 forward;
uniform bool parallel;
layout(location = 0) out vec4 seen;
layout(location = 1) out vec4 point;
layout(location = 2) out vec4 normal;
layout(location = 3) out vec4 tangent;
${NEAREST_FOUND}
void main() {
  seen = vec4(0.0);
  point = vec4(0.0);
  // Unit vectors, so that pixels off the object cause no division by 0.
  normal = vec4(0.0, 0.0, 1.0, 0.0);
  tangent = vec4(1.0, 0.0, 0.0, 0.0);
  ivec2 here = ivec2(gl_FragCoord.xy);
  ivec2 at = found(here);
  if (at.x < 0) return;
  vec3 p = texelFetch(places, at, 0).xyz;
  vec4 n = texelFetch(normals, at, 0);
  vec4 x = texelFetch(tangents, at, 0);
  vec3 wo = parallel ? -forward : normalize(eye - p);
  vec3 own = vec3(dot(wo, x.xyz), dot(wo, cross(n.xyz, x.xyz)), dot(wo, n.xyz));
  // Where the interpolated normal faces away from the eye, the eye is put just above the horizon.
  if (own.z <= 0.0) own.xy = (length(own.xy) > 1e-9 ? normalize(own.xy) : vec2(1.0, 0.0)) * 0.999999995;
  seen = vec4(own.xy, n.w, x.w);
  point = vec4(p, 1.0);
  normal = vec4(n.xyz, texelFetch(mask, here, 0).r);
  tangent = vec4(x.xyz, 0.0);
}`;

const LIT = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D point;
uniform sampler2D normal;
uniform sampler2D tangent;
uniform int base;
uniform vec3 light;
out vec4 result;
${REACHED}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy) - ivec2(0, base);
  vec4 p = texelFetch(point, here, 0);
  vec4 n = texelFetch(normal, here, 0);
  vec3 x = texelFetch(tangent, here, 0).xyz;
  vec3 towards = light - p.xyz;
  float squared = dot(towards, towards);
  vec3 wi = towards * inversesqrt(squared);
  float cos_i = dot(wi, n.xyz);
  result = vec4(dot(wi, x), dot(wi, cross(n.xyz, x)), cos_i > 0.0 && reached(here) ? p.w * cos_i / squared : 0.0, n.w);
}`;

/** Number of samples per pixel for coverage. */
const MASK_SAMPLES = 4;

/**
 * @typedef {{side: number, slots: number, whole: boolean, within: {vertices:
 *   WebGLVertexArrayObject, buffer: WebGLBuffer, corners: number}, parts: LitCells, layers:
 *   WebGLTexture[], mask: WebGLTexture, found: WebGLTexture[], seen: WebGLTexture, lit:
 *   WebGLTexture, framebuffer: WebGLFramebuffer, depth: WebGLRenderbuffer, maskFramebuffer:
 *   WebGLFramebuffer, foundFramebuffer: WebGLFramebuffer, litFramebuffer: WebGLFramebuffer,
 *   places: WebGLTexture[], placesFramebuffer: WebGLFramebuffer, surroundings: Map<Spheres,
 *   Surrounding>, many: WebGLFramebuffer, manyMask: WebGLRenderbuffer, manyDepth:
 *   WebGLRenderbuffer}} Surface
 *   `side`: of its pictures in pixels. `slots`: largest number of lights, whose pictures in `lit`
 *   are stacked. `whole`: false if there was not enough memory. `within`: a polygon around the
 *   object, outside of which nothing is shaded. `parts`: cells that lights may reach. `found`:
 *   position, normal and tangent of the shading points. `places`: of their normals on lit spheres,
 *   and shares. `surroundings`: radiances in the environments, by material (`surroundings.js`).
 *   `many`: the multisampled framebuffer of the mask.
 *
 * @typedef {{texture: WebGLTexture, framebuffer: WebGLFramebuffer, known: boolean}} Surrounding
 *   `known`: false until it is drawn at the present places.
 *
 * @typedef {{geometry: Geometry, tangents: "vertex"|"triangle"}} Mesh `tangents`: as in scenes
 *
 * @typedef {{surface: Linked, mask: Linked, found: Linked, lit: Linked, places: Linked,
 *   turnedPlaces: Linked, surroundings: Linked}} SurfacePrograms
 */

/** @param {WebGL2RenderingContext} gl @returns {SurfacePrograms} */
export const linkSurfacePrograms = (gl) => ({
  surface: linkNow(gl, VERTEX, SURFACE),
  mask: linkNow(gl, VERTEX, MASK),
  found: linkNow(gl, EVERYWHERE, FOUND),
  lit: linkNow(gl, OUTLINED, LIT),
  places: linkNow(gl, OUTLINED, PLACES),
  turnedPlaces: linkNow(gl, OUTLINED, TURNED_PLACES),
  surroundings: linkNow(gl, OUTLINED, SURROUNDINGS),
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
 * Creates the textures and framebuffers of a surface.
 * @param {WebGL2RenderingContext} gl
 * @param {number} side
 * @param {number} slots
 * @returns {Surface}
 */
export function makeSurface(gl, side, slots) {
  const layers = [0, 1, 2].map(() => texture(gl, gl.RGBA32F, side));
  const mask = texture(gl, gl.RGBA8, side);
  const depth = renderbuffer(gl, gl.DEPTH_COMPONENT24, side, 0);
  const framebuffer = drawsInto(gl, ...layers);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  const many = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, many);
  const manyMask = renderbuffer(gl, gl.RGBA8, side, MASK_SAMPLES);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, manyMask);
  const manyDepth = renderbuffer(gl, gl.DEPTH_COMPONENT24, side, MASK_SAMPLES);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, manyDepth);
  const seen = texture(gl, gl.RGBA32F, side);
  const lit = texture(gl, gl.RGBA32F, side, side * slots);
  const within = { vertices: gl.createVertexArray(), buffer: gl.createBuffer(), corners: 0 };
  gl.bindVertexArray(within.vertices);
  gl.bindBuffer(gl.ARRAY_BUFFER, within.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, 4 * 2 * 3 * (SIDES - 2), gl.DYNAMIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  gl.bindVertexArray(null);
  const found = [0, 1, 2].map(() => texture(gl, gl.RGBA32F, side));
  const places = [0, 1, 2].map(() => texture(gl, gl.RGBA32F, side));
  const maskFramebuffer = drawsInto(gl, mask);
  const foundFramebuffer = drawsInto(gl, seen, ...found);
  const litFramebuffer = drawsInto(gl, lit);
  const placesFramebuffer = drawsInto(gl, ...places);
  const whole = [framebuffer, many, maskFramebuffer, foundFramebuffer, litFramebuffer, placesFramebuffer].every(
    (made) => {
      gl.bindFramebuffer(gl.FRAMEBUFFER, made);
      return gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
    },
  );
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return {
    side,
    slots,
    whole,
    within,
    parts: makeLitCells(gl),
    layers,
    mask,
    found,
    seen,
    lit,
    places,
    framebuffer,
    depth,
    maskFramebuffer,
    foundFramebuffer,
    litFramebuffer,
    placesFramebuffer,
    surroundings: new Map(),
    many,
    manyMask,
    manyDepth,
  };
}

/** @param {WebGL2RenderingContext} gl @param {Surface} of */
export function dropSurface(gl, of) {
  const surroundings = [...of.surroundings.values()];
  for (const made of [
    ...of.layers,
    ...of.found,
    of.mask,
    of.seen,
    of.lit,
    ...of.places,
    ...surroundings.map((one) => one.texture),
  ])
    gl.deleteTexture(made);
  for (const made of [
    of.framebuffer,
    of.maskFramebuffer,
    of.foundFramebuffer,
    of.litFramebuffer,
    of.placesFramebuffer,
    ...surroundings.map((one) => one.framebuffer),
    of.many,
  ])
    gl.deleteFramebuffer(made);
  gl.deleteVertexArray(of.within.vertices);
  gl.deleteBuffer(of.within.buffer);
  dropLitCells(gl, of.parts);
  for (const made of [of.depth, of.manyMask, of.manyDepth]) gl.deleteRenderbuffer(made);
}

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
 * Draws the mesh with a program.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Mesh} mesh
 * @param {View} view
 */
export function drawMesh(gl, pen, { geometry, tangents }, view) {
  gl.useProgram(pen.program);
  bindView(gl, pen, view);
  gl.uniform3f(uniformLocation(gl, pen, "lens"), view.half, view.near, view.far);
  gl.uniform1i(uniformLocation(gl, pen, "facets"), tangents === "triangle" ? 1 : 0);
  gl.bindVertexArray(geometry.vertices);
  gl.drawElements(gl.TRIANGLES, geometry.corners, gl.UNSIGNED_INT, 0);
  gl.bindVertexArray(null);
}

/**
 * Draws the object: fills `layers`, `mask`, `seen` and `found`, and clears the light, which is
 * drawn within the object's polygon only.
 * @param {WebGL2RenderingContext} gl
 * @param {SurfacePrograms} pens
 * @param {Surface} into
 * @param {Mesh} mesh
 * @param {View} view
 */
export function drawSurface(gl, pens, into, mesh, view) {
  resetLitCells(gl, into.parts);
  const corners = triangles(outline(mesh.geometry.positions, view, into.side));
  into.within.corners = corners.length / 2;
  gl.bindBuffer(gl.ARRAY_BUFFER, into.within.buffer);
  gl.bufferSubData(gl.ARRAY_BUFFER, 0, corners);
  gl.viewport(0, 0, into.side, into.side);
  gl.disable(gl.SCISSOR_TEST);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(0, 0, 0, 0);
  for (const [framebuffer, pen] of /** @type {[WebGLFramebuffer, Linked][]} */ ([
    [into.framebuffer, pens.surface],
    [into.many, pens.mask],
  ])) {
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    drawMesh(gl, pen, mesh, view);
  }
  gl.disable(gl.DEPTH_TEST);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, into.many);
  gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, into.maskFramebuffer);
  gl.blitFramebuffer(
    0,
    0,
    into.side,
    into.side,
    0,
    0,
    into.side,
    into.side,
    gl.COLOR_BUFFER_BIT,
    gl.NEAREST,
  );
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.foundFramebuffer);
  read(gl, pens.found, {
    places: into.layers[0],
    normals: into.layers[1],
    tangents: into.layers[2],
    mask: into.mask,
  });
  bindView(gl, pens.found, view);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.litFramebuffer);
  gl.clear(gl.COLOR_BUFFER_BIT);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}

/**
 * Draws the light on the surface, one slot for each light.
 * @param {WebGL2RenderingContext} gl
 * @param {SurfacePrograms} pens
 * @param {Surface} into
 * @param {PointLight[]} lights no more than there are slots
 * @param {WebGLTexture} angles at which they reach the surface
 */
export function lightSurface(gl, pens, into, lights, angles) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.litFramebuffer);
  const [point, normal, tangent] = into.found;
  read(gl, pens.lit, { point, normal, tangent, angles });
  gl.uniform1i(uniformLocation(gl, pens.lit, "side"), into.side);
  lights.forEach((light, slot) => {
    gl.viewport(0, slot * into.side, into.side, into.side);
    gl.uniform1i(uniformLocation(gl, pens.lit, "base"), slot * into.side);
    gl.uniform3fv(uniformLocation(gl, pens.lit, "light"), light.place);
    gl.uniform1ui(uniformLocation(gl, pens.lit, "angle"), angleOf(light.degrees));
    gl.uniform1i(uniformLocation(gl, pens.lit, "numbered"), light.index);
    drawWithin(gl, into);
  });
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}

/**
 * Draws the places of a surface's normals on the spheres.
 * @param {WebGL2RenderingContext} gl
 * @param {SurfacePrograms} pens
 * @param {Surface} into
 * @param {View} view
 * @param {number|null} degrees turn of the environments; null at rest
 */
export function drawPlaces(gl, pens, into, view, degrees) {
  const pen = degrees === null ? pens.places : pens.turnedPlaces;
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.placesFramebuffer);
  gl.viewport(0, 0, into.side, into.side);
  read(gl, pen, { point: into.found[0], normal: into.found[1] });
  bindView(gl, pen, view);
  gl.uniform1f(uniformLocation(gl, pen, "lens"), view.half);
  if (degrees === null) gl.uniform1i(uniformLocation(gl, pen, "side"), into.side);
  else {
    gl.uniform1f(uniformLocation(gl, pen, "turn"), (degrees * Math.PI) / 180);
    gl.uniformMatrix3fv(uniformLocation(gl, pen, "world"), false, view.world.flat());
  }
  drawWithin(gl, into);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  for (const one of into.surroundings.values()) one.known = false;
}

/** Draws the object's polygon. @param {WebGL2RenderingContext} gl @param {Surface} surface */
export function drawWithin(gl, { within }) {
  gl.bindVertexArray(within.vertices);
  gl.drawArrays(gl.TRIANGLES, 0, within.corners);
  gl.bindVertexArray(null);
}
