/**
 * What the camera sees of the parts of a scene, and the light that falls on them, in textures
 * shared by all materials (deferred shading). Surfaces are drawn again only if an object, the
 * camera or the size change, the light if it moves.
 *
 * Passes: all meshes into a geometry buffer (`raster.js`); for each part a pass over all pixels
 * that finds a shading point for each and writes `seen` and `found`; and for each light a pass that
 * writes a slot of `lit`. The last is straight-line code: software renderers run both sides of
 * every branch and lose more time on the branch than on its content.
 *
 * A material reads two texels a pixel: `seen` holds the direction to the eye (its tangential part
 * in the local frame) and the texture coordinates, `lit` the direction to a light (likewise), cos_i
 * over the squared distance, and the coverage.
 *
 * @import { LitCells } from "./lit_cells.js"
 * @import { Linked } from "./program.js"
 * @import { Mesh, Raster, RasterPrograms } from "./raster.js"
 * @import { PointLight, View } from "./camera.js"
 * @import { Shadows } from "./shadows.js"
 * @import { Spheres } from "./spheres.js"
 */
import { CONE, bindCone } from "./cone.js";
import { dropLitCells, makeLitCells, resetLitCells } from "./lit_cells.js";
import { SIDES, outline, triangles } from "./outline.js";
import { EVERYWHERE, OUTLINED, linkNow, read, uniformLocation } from "./program.js";
import {
  areComplete, bindView, coverageOf, drawRaster, drawsInto, dropRaster, linkRasterPrograms,
  makeRaster,
} from "./raster.js";
import { angleOf, bindShadows, reaching } from "./shadows.js";
import { PLACES, SURROUNDINGS, TURNED_PLACES } from "./spheres.js";
import { viewFrom } from "./stage.js";
import { texture } from "./texture.js";

/**
 * GLSL: the pixel whose point a pixel takes for a part: its own, or one beside it; -1 if there is
 * none.
 */
export const NEAREST_FOUND = `
uniform float number;
ivec2 found(ivec2 at) {
  ivec2 last = textureSize(places, 0) - 1;
  for (int k = 0; k < 9; k++) {
    // The pixel itself, then those beside it, then those at its corners.
    int way = (k * 2 + (k > 4 ? 0 : 4)) % 9;
    ivec2 beside = k == 0 ? at : clamp(at + ivec2(way % 3 - 1, way / 3 - 1), ivec2(0), last);
    if (texelFetch(places, beside, 0).w == number) return beside;
  }
  return ivec2(-1);
}`;

/**
 * Finds the shading point of each pixel, once for all lights: an edge pixel whose centre misses the
 * part takes that of a neighbour.
 */
const FOUND = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D places;
uniform sampler2D normals;
uniform sampler2D tangents;
uniform sampler2D mask;
uniform vec4 channel;
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
  normal = vec4(n.xyz, dot(texelFetch(mask, here, 0), channel));
  ivec2 step = at - here;
  tangent = vec4(x.xyz, float(step.x + 3 * step.y));
}`;

/** @param {boolean} isClear true if light passes through the subject */
const lit = (isClear) => `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D point;
uniform sampler2D normal;
uniform sampler2D tangent;
uniform int base;
uniform vec3 light;
out vec4 result;
${reaching(isClear)}
${CONE}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy) - ivec2(0, base);
  vec4 p = texelFetch(point, here, 0);
  vec4 n = texelFetch(normal, here, 0);
  vec4 u = texelFetch(tangent, here, 0);
  vec3 x = u.xyz;
  vec3 towards = light - p.xyz;
  float squared = dot(towards, towards);
  vec3 wi = towards * inversesqrt(squared);
  float cos_i = dot(wi, n.xyz);
  float share = reached(point_of(here, u.w));
  result = vec4(dot(wi, x), dot(wi, cross(n.xyz, x)), cos_i > 0.0 && share > 0.0 ? share * p.w * in_cone(wi) * cos_i / squared : 0.0, n.w);
}`;

/**
 * @typedef {{vertices: WebGLVertexArrayObject, buffer: WebGLBuffer, corners: number}} Within
 *
 * @typedef {{raster: Raster, part: number, side: number, slots: number, whole: boolean, within:
 *   Within, litCells: LitCells, found: WebGLTexture[], seen: WebGLTexture, lit: WebGLTexture,
 *   foundFramebuffer: WebGLFramebuffer, litFramebuffer: WebGLFramebuffer, places: WebGLTexture[],
 *   placesFramebuffer: WebGLFramebuffer|null, surroundings: Map<Spheres, Surrounding>}} Surface
 *   What the camera sees of a part of the scene. `part`: its number, 0 for the subject. `side`: of
 *   its pictures in pixels. `slots`: largest number of lights, whose pictures in `lit` are stacked.
 *   `whole`: false if there was not enough memory. `within`: a polygon around the part, outside of
 *   which nothing is shaded. `litCells`: cells that lights may reach. `found`: position, normal and
 *   tangent of the shading points. `places`: of their normals on lit spheres, and shares; the
 *   subject's only. `surroundings`: radiances in the environments, by material
 *   (`surroundings.js`).
 *
 * @typedef {Pick<Surface, "side"|"within"|"found"|"seen"|"lit"|"litFramebuffer"|"surroundings"> &
 *   {litCells: LitCells|{cells: null}}} Shaded What materials are drawn on
 *
 * @typedef {{texture: WebGLTexture, framebuffer: WebGLFramebuffer, known: boolean}} Surrounding
 *   `known`: false until it is drawn at the present places.
 *
 * @typedef {{raster: RasterPrograms, found: Linked, lit: Linked, litThrough: Linked|null, places:
 *   Linked, turnedPlaces: Linked, surroundings: Linked}} SurfacePrograms `litThrough`: for light
 *   that passes through the subject; null until it is needed
 */

/** @param {WebGL2RenderingContext} gl @returns {SurfacePrograms} */
export const linkSurfacePrograms = (gl) => ({
  raster: linkRasterPrograms(gl),
  found: linkNow(gl, EVERYWHERE, FOUND),
  lit: linkNow(gl, OUTLINED, lit(false)),
  litThrough: null,
  places: linkNow(gl, OUTLINED, PLACES),
  turnedPlaces: linkNow(gl, OUTLINED, TURNED_PLACES),
  surroundings: linkNow(gl, OUTLINED, SURROUNDINGS),
});

/**
 * Creates a polygon.
 * @param {WebGL2RenderingContext} gl
 * @param {Float32Array} corners of triangles, in clip space
 * @returns {Within}
 */
export function makeWithin(gl, corners) {
  const within = {
    vertices: gl.createVertexArray(),
    buffer: gl.createBuffer(),
    corners: corners.length / 2,
  };
  gl.bindVertexArray(within.vertices);
  gl.bindBuffer(gl.ARRAY_BUFFER, within.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, corners, gl.DYNAMIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  gl.bindVertexArray(null);
  return within;
}

/** @param {WebGL2RenderingContext} gl @param {Within} of */
export function dropWithin(gl, { vertices, buffer }) {
  gl.deleteVertexArray(vertices);
  gl.deleteBuffer(buffer);
}

/**
 * Creates the textures and framebuffers of a part's surface.
 * @param {WebGL2RenderingContext} gl
 * @param {Raster} raster
 * @param {number} slots
 * @param {number} part
 * @returns {Surface}
 */
function makeSurface(gl, raster, slots, part) {
  const { side } = raster;
  const seen = texture(gl, gl.RGBA32F, side);
  const lit = texture(gl, gl.RGBA32F, side, side * slots);
  const within = makeWithin(gl, new Float32Array(2 * 3 * (SIDES - 2)));
  const found = [0, 1, 2].map(() => texture(gl, gl.RGBA32F, side));
  const places = part > 0 ? [] : [0, 1, 2].map(() => texture(gl, gl.RGBA32F, side));
  const foundFramebuffer = drawsInto(gl, seen, ...found);
  const litFramebuffer = drawsInto(gl, lit);
  const placesFramebuffer = part > 0 ? null : drawsInto(gl, ...places);
  const framebuffers = [foundFramebuffer, litFramebuffer, placesFramebuffer];
  const whole = raster.whole && areComplete(gl, framebuffers.filter((made) => made !== null));
  return {
    raster,
    part,
    side,
    slots,
    whole,
    within,
    litCells: makeLitCells(gl),
    found,
    seen,
    lit,
    places,
    foundFramebuffer,
    litFramebuffer,
    placesFramebuffer,
    surroundings: new Map(),
  };
}

/**
 * Creates the surfaces of parts of a scene, which share a geometry buffer.
 * @param {WebGL2RenderingContext} gl
 * @param {number} side
 * @param {number} slots
 * @param {number} parts number of parts of the scene
 * @param {number[]} [wanted] numbers of the parts; default: all
 * @returns {Surface[]}
 */
export function makeSurfaces(gl, side, slots, parts, wanted = [...Array(parts).keys()]) {
  const raster = makeRaster(gl, side, parts);
  return wanted.map((part) => makeSurface(gl, raster, slots, part));
}

/** @param {WebGL2RenderingContext} gl @param {Surface[]} all that share a geometry buffer */
export function dropSurfaces(gl, all) {
  for (const of of all) {
    const surroundings = [...of.surroundings.values()];
    const held = surroundings.map((one) => one.texture);
    for (const made of [...of.found, of.seen, of.lit, ...of.places, ...held]) gl.deleteTexture(made);
    for (const made of [
      of.foundFramebuffer,
      of.litFramebuffer,
      of.placesFramebuffer,
      ...surroundings.map((one) => one.framebuffer),
    ])
      gl.deleteFramebuffer(made);
    dropWithin(gl, of.within);
    dropLitCells(gl, of.litCells);
  }
  dropRaster(gl, all[0].raster);
}

/**
 * Draws the parts of a scene: fills the geometry buffer of surfaces, `seen` and `found`, and clears
 * the light, which is drawn within the part's polygon only.
 * @param {WebGL2RenderingContext} gl
 * @param {SurfacePrograms} pens
 * @param {Surface[]} into that share a geometry buffer
 * @param {Mesh[]} meshes of all parts
 * @param {View} view
 */
export function drawSurfaces(gl, pens, into, meshes, view) {
  const [{ raster, side }] = into;
  drawRaster(gl, pens.raster, raster, meshes, view);
  const [places, normals, tangents] = raster.layers;
  for (const surface of into) {
    const { part, within } = surface;
    const { geometry, place } = meshes[part];
    resetLitCells(gl, surface.litCells);
    const corners = triangles(outline(geometry.positions, viewFrom(view, place), side));
    within.corners = corners.length / 2;
    gl.bindBuffer(gl.ARRAY_BUFFER, within.buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, corners);
    const { mask, channel } = coverageOf(raster, part);
    gl.viewport(0, 0, side, side);
    gl.bindFramebuffer(gl.FRAMEBUFFER, surface.foundFramebuffer);
    read(gl, pens.found, { places, normals, tangents, mask });
    gl.uniform4fv(uniformLocation(gl, pens.found, "channel"), channel);
    gl.uniform1f(uniformLocation(gl, pens.found, "number"), part + 1);
    bindView(gl, pens.found, view);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, surface.litFramebuffer);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
}

/**
 * Draws the light on the surface, one slot for each light.
 * @param {WebGL2RenderingContext} gl
 * @param {SurfacePrograms} pens
 * @param {Shaded} into
 * @param {PointLight[]} lights no more than there are slots
 * @param {Shadows} shadows
 */
export function lightSurface(gl, pens, into, lights, shadows) {
  if (shadows.passed > 0) pens.litThrough ??= linkNow(gl, OUTLINED, lit(true));
  const pen = (shadows.passed > 0 ? pens.litThrough : null) ?? pens.lit;
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.litFramebuffer);
  const [point, normal, tangent] = into.found;
  read(gl, pen, { point, normal, tangent, angles: shadows.angles });
  bindShadows(gl, pen, shadows);
  gl.uniform1i(uniformLocation(gl, pen, "side"), into.side);
  lights.forEach((light, slot) => {
    gl.viewport(0, slot * into.side, into.side, into.side);
    gl.uniform1i(uniformLocation(gl, pen, "base"), slot * into.side);
    gl.uniform3fv(uniformLocation(gl, pen, "light"), light.place);
    bindCone(gl, pen, light.cone);
    gl.uniform1ui(uniformLocation(gl, pen, "angle"), angleOf(light.degrees));
    gl.uniform1i(uniformLocation(gl, pen, "numbered"), light.index);
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

/** Draws the object's polygon. @param {WebGL2RenderingContext} gl @param {Shaded} surface */
export function drawWithin(gl, { within }) {
  gl.bindVertexArray(within.vertices);
  gl.drawArrays(gl.TRIANGLES, 0, within.corners);
  gl.bindVertexArray(null);
}
