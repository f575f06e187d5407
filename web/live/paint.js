/**
 * The surface as painted materials see it: quantities of a pixel, cosines to the lights, and their
 * gradients over a pixel, in textures that all materials share. docs/maths/painted.md defines them.
 *
 * Passes: the mesh into `slopes` (changes of normal and position to the next pixels, on the same
 * triangle); a pass that finds the changes of normal and mirror direction at each shading point;
 * and for each light a pass that writes a slot of `cosines` and of `arriving`. The first two run
 * again only if object, camera or size change.
 *
 * @import { PaintLight } from "./paint_lights.js"
 * @import { Linked } from "./program.js"
 * @import { Mesh } from "./raster.js"
 * @import { Ends } from "./ray_ends.js"
 * @import { Shadows } from "./shadows.js"
 * @import { Shaded, Surface } from "./surface.js"
 * @import { View } from "./camera.js"
 */
import { CONE, bindCone } from "./cone.js";
import { OUTLINED, linkNow, read, uniformLocation } from "./program.js";
import { angleOf, bindShadows, reaching } from "./shadows.js";
import { NEAREST_FOUND, drawWithin } from "./surface.js";
import { OUTWARDS, VERTEX, bindView, drawMesh, drawsInto } from "./raster.js";
import { texture } from "./texture.js";

// Halves suffice: gradients only widen edges.
const SLOPES = `#version 300 es
precision highp float;
in vec3 p;
in vec3 n;
uniform vec3 eye;
uniform vec3 forward;
uniform bool parallel;
layout(location = 0) out vec4 first;
layout(location = 1) out vec4 second;
layout(location = 2) out vec4 third;
${OUTWARDS}
void main() {
  vec3 normal = outwards(p, n, parallel ? -forward : eye - p);
  vec3 nx = dFdx(normal);
  vec3 ny = dFdy(normal);
  vec3 px = dFdx(p);
  vec3 py = dFdy(p);
  first = clamp(vec4(nx, ny.x), -100.0, 100.0);
  second = clamp(vec4(ny.yz, px.xy), -100.0, 100.0);
  third = clamp(vec4(px.z, py), -100.0, 100.0);
}`;

/** Writes n.e and depth with their gradients, and the changes of normal and mirror direction. */
const STANDING = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D places;
uniform sampler2D point;
uniform sampler2D normal;
uniform sampler2D first;
uniform sampler2D second;
uniform sampler2D third;
uniform vec3 eye;
uniform vec3 forward;
uniform bool parallel;
layout(location = 0) out vec4 own;
layout(location = 1) out vec4 low;
layout(location = 2) out vec4 middle;
layout(location = 3) out vec4 high;
${NEAREST_FOUND}
vec3 towards(vec3 p) { return parallel ? -forward : normalize(eye - p); }
vec3 mirrored(vec3 n, vec3 e) { return 2.0 * dot(n, e) * n - e; }
float depth(vec3 p, vec3 e) { return 0.5 * (1.0 - dot(p, e)); }
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  ivec2 at = found(here);
  vec3 p = texelFetch(point, here, 0).xyz;
  vec3 n = texelFetch(normal, here, 0).xyz;
  vec4 a = texelFetch(first, max(at, 0), 0);
  vec4 b = texelFetch(second, max(at, 0), 0);
  vec4 c = texelFetch(third, max(at, 0), 0);
  vec3 nx = a.xyz;
  vec3 ny = vec3(a.w, b.xy);
  vec3 px = p + vec3(b.zw, c.x);
  vec3 py = p + c.yzw;
  vec3 e = towards(p);
  vec3 ex = towards(px);
  vec3 ey = towards(py);
  float facing = dot(n, e);
  float far = depth(p, e);
  vec2 facing_change = vec2(dot(n + nx, ex), dot(n + ny, ey)) - facing;
  vec2 depth_change = vec2(depth(px, ex), depth(py, ey)) - far;
  own = vec4(max(facing, 0.0), far, min(length(facing_change), 1.0), min(length(depth_change), 1.0));
  vec3 r = mirrored(n, e);
  vec3 rx = mirrored(n + nx, ex) - r;
  vec3 ry = mirrored(n + ny, ey) - r;
  low = vec4(nx, ny.x);
  middle = vec4(ny.yz, rx.xy);
  high = vec4(rx.z, ry);
}`;

/**
 * Writes what a light is at each pixel; `light.w` is 0 for a direction. At the ends of rays, `seen`
 * has the eye, and nothing changes.
 * @param {boolean} isClear true if light passes through the subject
 */
const paintLit = (isClear) => `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D point;
uniform sampler2D normal;
uniform sampler2D tangent;
uniform sampler2D low;
uniform sampler2D middle;
uniform sampler2D high;
uniform sampler2D seen;
uniform bool ends;
uniform int base;
uniform vec4 light;
uniform vec3 eye;
uniform vec3 forward;
uniform bool parallel;
layout(location = 0) out vec4 cosines;
layout(location = 1) out vec4 arriving;
${reaching(isClear)}
${CONE}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy) - ivec2(0, base);
  vec3 p = texelFetch(point, here, 0).xyz;
  vec3 n = texelFetch(normal, here, 0).xyz;
  vec4 u = texelFetch(tangent, here, 0);
  vec3 x = u.xyz;
  ivec2 there = ends ? ivec2(0) : here;
  vec4 a = texelFetch(low, there, 0);
  vec4 b = texelFetch(middle, there, 0);
  vec4 c = texelFetch(high, there, 0);
  vec4 s = texelFetch(seen, here, 0);
  vec3 towards = light.xyz - p * light.w;
  float squared = light.w == 0.0 ? 1.0 : dot(towards, towards);
  vec3 l = towards * inversesqrt(squared);
  vec3 back = s.x * x + s.y * cross(n, x) + sqrt(max(0.0, 1.0 - dot(s.xy, s.xy))) * n;
  vec3 e = ends ? back : parallel ? -forward : normalize(eye - p);
  float cosine = clamp(dot(n, l), -1.0, 1.0);
  float mirror = clamp(dot(2.0 * dot(n, e) * n - e, l), -1.0, 1.0);
  vec2 cosine_change = vec2(dot(a.xyz, l), dot(vec3(a.w, b.xy), l));
  vec2 mirror_change = vec2(dot(vec3(b.zw, c.x), l), dot(c.yzw, l));
  cosines = vec4(cosine, mirror, min(length(cosine_change), 1.0), min(length(mirror_change), 1.0));
  float share = in_cone(l);
  arriving = vec4(dot(l, x), dot(l, cross(n, x)), share / squared, reached_share(point_of(here, u.w)));
  // A light has no effect outside of its cone.
  if (share == 0.0) cosines = arriving = vec4(0.0);
}`;

/** GLSL: display values to linear light. */
const LINEAR = `
  code = mix(pow((code + 0.055) / 1.055, vec3(2.4)), code / 12.92, lessThanEqual(code, vec3(0.04045)));`;

/**
 * Constant of a clear material in exported code; null without glass.
 * @param {string} styled
 * @param {"INDEX"|"PASSED"} name
 */
function constantOf(styled, name) {
  const found = new RegExp(`^const float STYLED_${name} = ([\\d.]+);$`, "m").exec(styled);
  return found ? Number(found[1]) : null;
}

/** Index of refraction of exported code; null without glass. @param {string} styled */
export const indexOf = (styled) => constantOf(styled, "INDEX");

/** Share of light that passes through a body of exported code. @param {string} styled */
export const passedOf = (styled) => constantOf(styled, "PASSED") ?? 0;

/** GLSL: `StyledGlass` of a pixel, from the colours at the ends of its rays. */
const SEEN = `
precision highp usampler2D;
uniform usampler2D numbers;
uniform sampler2D lengths;
uniform sampler2D colors;
uniform sampler2D tangent;
vec4 color_of(uint number) {
  int place = max(int(number) - 1, 0);
  int across = textureSize(colors, 0).x;
  vec4 found = texelFetch(colors, ivec2(place % across, place / across), 0);
  return number == 0u || found.a < 0.5 ? vec4(0.0) : found;
}
StyledGlass glass_at(ivec2 here) {
  int step = int(texelFetch(tangent, here, 0).w) + 4;
  ivec2 point = here + ivec2(step % 3, step / 3) - 1;
  int size = textureSize(numbers, 0).x;
  ivec2 pixel = min((2 * point + 1) * size / (2 * side), size - 1);
  uvec4 rays = texelFetch(numbers, pixel, 0);
  vec4 inside = texelFetch(lengths, pixel, 0);
  vec4 mirrored = color_of(rays.x);
  vec4 first = color_of(rays.y);
  vec4 second = color_of(rays.z);
  vec3 seen = vec3(mirrored.a, first.a, second.a);
  vec3 reach = mix(vec3(65504.0), inside.xyz, greaterThan(seen, vec3(0.5)));
  return StyledGlass(mirrored.rgb, reach.x, first.rgb, reach.y, second.rgb, reach.z, inside.w);
}`;

/**
 * Fragment shader from the textures to a pixel's colour.
 * @param {string} styled the exported functions
 * @param {number} lights
 * @param {boolean} linear true for linear light instead of display values
 */
export const paintedFragment = (styled, lights, linear) => `#version 300 es
${styled}
precision highp sampler2D;
uniform sampler2D seen;
uniform sampler2D normal;
uniform sampler2D own;
uniform sampler2D cosines;
uniform sampler2D arriving;
uniform ivec2 corner;
uniform int side;
uniform vec3 intensities[${lights}];
out vec4 color;
${indexOf(styled) === null ? "" : SEEN}
StyledLight lightAt(ivec2 at, int k) {
  ivec2 there = at + ivec2(0, k * side);
  vec4 c = texelFetch(cosines, there, 0);
  vec4 a = texelFetch(arriving, there, 0);
  vec3 reaching = min(intensities[k] * a.z, vec3(1.0));
  // As in the server's pictures: the normal, if the point is outside of the light's cone.
  vec3 direction = a.z > 0.0 ? vec3(a.xy, c.x) : vec3(0.0, 0.0, 1.0);
  return StyledLight(c.x, c.y, a.w, reaching, c.z, c.w, direction);
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - corner;
  vec4 o = texelFetch(own, at, 0);
  vec4 s = texelFetch(seen, at, 0);
  vec3 e = vec3(s.xy, sqrt(max(0.0, 1.0 - dot(s.xy, s.xy))));
  StyledPoint here = StyledPoint(o.x, o.y, o.z, o.w, e, s.zw);
  StyledLight[${lights}] all = StyledLight[${lights}](${Array.from({ length: lights }, (_, k) => `lightAt(at, ${k})`).join(", ")});
  vec3 code = styled(here, all${indexOf(styled) === null ? "" : ", glass_at(at)"});
  ${linear ? LINEAR : ""}
  color = vec4(code, 1.0) * texelFetch(normal, at, 0).w;
}`;

/**
 * @typedef {{slots: number, standing: string, lit: string, slopes: WebGLTexture[], own:
 *   WebGLTexture, changes: WebGLTexture[], cosines: WebGLTexture, arriving: WebGLTexture,
 *   framebuffers: WebGLFramebuffer[]}} Paint
 *   `standing`, `lit`: keys of what the textures show. `framebuffers`: of the three passes.
 *
 * @typedef {Pick<Paint, "own"|"cosines"|"arriving">} Seen What painted materials read of a surface
 */

export class PaintedSurfaces {
  /** @type {{slopes: Linked, standing: Linked, lit: Linked, litThrough: Linked|null}|null} */
  #pens = null;
  /** @type {Map<Surface, Paint>} */
  #held = new Map();
  /** A texel of changes that are 0. @type {WebGLTexture|null} */
  #still = null;

  /**
   * Brings the textures of a surface up to date.
   * @param {WebGL2RenderingContext} gl
   * @param {Surface} surface
   * @param {{key: string, mesh: Mesh, view: View}} shown
   * @param {{key: string, lights: PaintLight[], shadows: Shadows}} lit
   * @returns {Paint}
   */
  prepare(gl, surface, { key, mesh, view }, { key: litKey, lights, shadows }) {
    const pens = this.#linked(gl);
    let paint = this.#held.get(surface);
    if (paint && paint.slots < lights.length) {
      this.drop(gl, surface);
      paint = undefined;
    }
    if (!paint) {
      paint = makePaint(gl, surface, lights.length);
      this.#held.set(surface, paint);
    }
    if (paint.standing !== key) {
      drawSlopes(gl, pens.slopes, paint, surface, mesh, view);
      drawStanding(gl, pens.standing, paint, surface, view);
      paint.standing = key;
      paint.lit = "";
    }
    if (paint.lit !== litKey) {
      const [, , framebuffer] = paint.framebuffers;
      const { changes } = paint;
      const pen = this.#penFor(gl, shadows);
      drawLights(gl, pen, { framebuffer, changes, view }, surface, { lights, shadows });
      paint.lit = litKey;
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return paint;
  }

  /**
   * Brings what painted materials read at the ends of rays up to date.
   * @param {WebGL2RenderingContext} gl
   * @param {Ends} ends
   * @param {{key: string, paintLights: PaintLight[], shadows: Shadows}} light
   * @returns {Seen}
   */
  lightEnds(gl, { all, paint }, { key, paintLights: lights, shadows }) {
    if (paint.lit !== key) {
      this.#still ??= texture(gl, gl.RGBA16F, 1);
      const changes = [this.#still, this.#still, this.#still];
      const { framebuffer } = paint;
      const pen = this.#penFor(gl, shadows);
      drawLights(gl, pen, { framebuffer, changes, view: null }, all, { lights, shadows });
      paint.lit = key;
    }
    return paint;
  }

  /** @param {WebGL2RenderingContext} gl @param {Shadows} shadows */
  #penFor(gl, { passed }) {
    const pens = this.#linked(gl);
    return passed > 0 ? (pens.litThrough ??= linkNow(gl, OUTLINED, paintLit(true))) : pens.lit;
  }

  /** @param {WebGL2RenderingContext} gl */
  #linked(gl) {
    this.#pens ??= {
      slopes: linkNow(gl, VERTEX, SLOPES),
      standing: linkNow(gl, OUTLINED, STANDING),
      lit: linkNow(gl, OUTLINED, paintLit(false)),
      litThrough: null,
    };
    return this.#pens;
  }

  /**
   * Drops the textures of a surface.
   * @param {WebGL2RenderingContext} gl
   * @param {Surface} surface
   */
  drop(gl, surface) {
    const paint = this.#held.get(surface);
    if (!paint) return;
    for (const made of [...paint.slopes, paint.own, ...paint.changes, paint.cosines, paint.arriving])
      gl.deleteTexture(made);
    for (const made of paint.framebuffers) gl.deleteFramebuffer(made);
    this.#held.delete(surface);
  }

  /** Forgets the textures of a lost context. */
  lose() {
    this.#pens = null;
    this.#still = null;
    this.#held.clear();
  }
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {Surface} surface
 * @param {number} slots
 * @returns {Paint}
 */
function makePaint(gl, { side, raster: { depth } }, slots) {
  const slopes = [0, 1, 2].map(() => texture(gl, gl.RGBA16F, side));
  const changes = [0, 1, 2].map(() => texture(gl, gl.RGBA16F, side));
  const own = texture(gl, gl.RGBA32F, side);
  const [cosines, arriving] = [0, 1].map(() => texture(gl, gl.RGBA32F, side, side * slots));
  const ofSlopes = drawsInto(gl, ...slopes);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  const framebuffers = [ofSlopes, drawsInto(gl, own, ...changes), drawsInto(gl, cosines, arriving)];
  return { slots, standing: "", lit: "", slopes, own, changes, cosines, arriving, framebuffers };
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Paint} into
 * @param {Surface} surface
 * @param {Mesh} mesh
 * @param {View} view
 */
function drawSlopes(gl, pen, into, { side }, mesh, view) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.framebuffers[0]);
  gl.viewport(0, 0, side, side);
  gl.disable(gl.SCISSOR_TEST);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  drawMesh(gl, pen, mesh, view);
  gl.disable(gl.DEPTH_TEST);
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {Paint} into
 * @param {Surface} surface
 * @param {View} view
 */
function drawStanding(gl, pen, into, surface, view) {
  const [first, second, third] = into.slopes;
  const [point, normal] = surface.found;
  gl.bindFramebuffer(gl.FRAMEBUFFER, into.framebuffers[1]);
  gl.viewport(0, 0, surface.side, surface.side);
  read(gl, pen, { places: surface.raster.layers[0], point, normal, first, second, third });
  gl.uniform1f(uniformLocation(gl, pen, "number"), surface.part + 1);
  bindView(gl, pen, view);
  drawWithin(gl, surface);
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} pen
 * @param {{framebuffer: WebGLFramebuffer, changes: WebGLTexture[], view: View|null}} into `view`:
 *   null at the ends of rays
 * @param {Shaded} surface
 * @param {{lights: PaintLight[], shadows: Shadows}} lit
 */
function drawLights(gl, pen, { framebuffer, changes, view }, surface, { lights, shadows }) {
  const [low, middle, high] = changes;
  const [point, normal, tangent] = surface.found;
  const { side, seen } = surface;
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  read(gl, pen, { point, normal, tangent, seen, low, middle, high, angles: shadows.angles });
  bindShadows(gl, pen, shadows);
  if (view) bindView(gl, pen, view);
  gl.uniform1i(uniformLocation(gl, pen, "ends"), view ? 0 : 1);
  gl.uniform1i(uniformLocation(gl, pen, "side"), side);
  lights.forEach(({ place, isDirection, cone, index, degrees }, slot) => {
    gl.viewport(0, slot * side, side, side);
    gl.uniform1i(uniformLocation(gl, pen, "base"), slot * side);
    gl.uniform4f(uniformLocation(gl, pen, "light"), ...place, isDirection ? 0 : 1);
    bindCone(gl, pen, cone);
    gl.uniform1ui(uniformLocation(gl, pen, "angle"), angleOf(degrees));
    gl.uniform1i(uniformLocation(gl, pen, "numbered"), index);
    drawWithin(gl, surface);
  });
}

/**
 * Draws a painted material into the square at a corner of the present framebuffer.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 * @param {Shaded} surface
 * @param {{paint: Seen, lights: PaintLight[], corner: [number, number], ends?: Ends|null}} how
 *   `corner`: lower left in pixels; `ends`: of the rays of a clear material
 */
export function drawPainted(gl, linked, surface, { paint, lights, corner, ends }) {
  const { own, cosines, arriving } = paint;
  const { seen, found } = surface;
  const [, normal, tangent] = found;
  read(gl, linked, {
    seen,
    normal,
    own,
    cosines,
    arriving,
    ...(ends && { tangent, numbers: ends.numbers, lengths: ends.lengths, colors: ends.colors }),
  });
  gl.uniform2i(uniformLocation(gl, linked, "corner"), ...corner);
  gl.uniform1i(uniformLocation(gl, linked, "side"), surface.side);
  gl.uniform3fv(uniformLocation(gl, linked, "intensities"), lights.flatMap(({ color }) => color));
  gl.viewport(corner[0], corner[1], surface.side, surface.side);
  drawWithin(gl, surface);
}
