/**
 * Light from environments, live: the server computes the radiance of a material for all normals,
 * seen from nine places of the picture (its lit spheres); any mesh in any rotation is drawn from
 * them. Only for isotropic homogeneous materials.
 *
 * A point with normal n and direction to the eye o has the mirror direction r. On the sphere of
 * direction v it takes the normal between v and r, so that r is the same; the remaining error in
 * the normal cancels to first order in the bilinear mean of the four spheres around the point.
 *
 * @import { Scene } from "../model.js"
 */
import { getBytes } from "../api/request.js";

/** Texels along the side of a sphere. */
const TEXELS = 48;
/** Number of spheres in a row, and of rows. */
const ACROSS = 3;
const MAGIC = "broodlit";
/** Number of bytes before the texels. */
const HEAD_BYTES = 20;
/** Texels along the side of a backdrop. */
const BACKDROP_TEXELS = 64;

/** Writes the places of the four normals in the texture of the spheres. */
export const PLACES = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D point;
uniform sampler2D normal;
uniform int side;
uniform vec3 eye;
uniform vec3 right;
uniform vec3 up;
uniform vec3 forward;
uniform float lens;
uniform bool parallel;
layout(location = 0) out vec4 lower;
layout(location = 1) out vec4 upper;
vec2 on(vec2 sphere, vec3 r) {
  vec2 place = sphere - 1.0;
  vec3 v = normalize(-forward - (parallel ? 0.0 : lens) * (place.x * right + place.y * up));
  vec3 x = normalize(right - v * dot(right, v));
  vec3 n = v + r;
  vec3 local = vec3(dot(n, x), dot(n, cross(v, x)), max(dot(n, v), 0.0));
  vec2 p = local.xy / max(abs(local.x) + abs(local.y) + local.z, 1e-9);
  vec2 at = 0.5 + 0.5 * vec2(p.x + p.y, p.x - p.y);
  return (sphere + (0.5 + at * ${TEXELS - 1}.0) / ${TEXELS}.0) / ${ACROSS}.0;
}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec3 n = texelFetch(normal, here, 0).xyz;
  vec3 wo = parallel ? -forward : normalize(eye - texelFetch(point, here, 0).xyz);
  vec3 r = 2.0 * max(dot(n, wo), 0.0) * n - wo;
  vec2 first = floor(gl_FragCoord.xy * ${ACROSS - 1}.0 / float(side));
  lower = vec4(on(first, r), on(first + vec2(1.0, 0.0), r));
  upper = vec4(on(first + vec2(0.0, 1.0), r), on(first + 1.0, r));
}`;

/** Writes the radiance of a material at the places. */
export const SURROUNDINGS = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D lower;
uniform sampler2D upper;
uniform sampler2D spheres;
uniform int side;
out vec4 radiance;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 below = texelFetch(lower, at, 0);
  vec4 above = texelFetch(upper, at, 0);
  vec2 across = fract(gl_FragCoord.xy * ${ACROSS - 1}.0 / float(side));
  radiance = vec4(mix(
    mix(texture(spheres, below.xy).rgb, texture(spheres, below.zw).rgb, across.x),
    mix(texture(spheres, above.xy).rgb, texture(spheres, above.zw).rgb, across.x),
    across.y
  ), 1.0);
}`;

/**
 * @typedef {{texture: WebGLTexture, unit: number}} Radiance `unit`: radiance of a texel of 1
 *
 * @typedef {Radiance & {backdrop: Radiance|null}} Spheres `backdrop`: the environments behind the
 *   object, from the top; null if the scene shows none
 */

/** Environments of a scene. @param {Pick<Scene, "lights">} scene */
const environmentsOf = ({ lights }) => (lights ?? []).filter(({ kind }) => kind === "environment");

/** True if environments turn with the light. @param {Pick<Scene, "lights">} scene */
export const isTurning = (scene) => environmentsOf(scene).some(({ fixed }) => !fixed);

/**
 * Identity of what lit spheres depend on besides the material; empty without environments.
 * @param {Scene} scene
 */
export function environmentKey(scene) {
  const environments = environmentsOf(scene);
  if (environments.length === 0) return "";
  const backdrop = scene.backdrop?.kind === "environment" ? scene.backdrop : null;
  const turned = isTurning(scene) ? scene.light_deg : 0;
  return JSON.stringify([environments, turned, scene.camera, backdrop]);
}

/**
 * Reads the head of a file of lit spheres, its texels, and those of its backdrop if it has one.
 * @param {ArrayBuffer} bytes
 */
export function readSpheres(bytes) {
  const head = new DataView(bytes);
  const magic = String.fromCharCode(...new Uint8Array(bytes, 0, 8));
  const [version, side] = [head.getUint32(8, true), head.getUint32(12, true)];
  if (magic !== MAGIC || version !== 2 || side !== TEXELS)
    throw new Error("the lit spheres are of another version than the page");
  const texels = new Uint16Array(bytes, HEAD_BYTES, 3 * (ACROSS * side) ** 2);
  const end = HEAD_BYTES + texels.byteLength;
  const backdrop = bytes.byteLength > end && {
    unit: head.getFloat32(end, true),
    texels: new Uint16Array(bytes, end + 4, 3 * BACKDROP_TEXELS ** 2),
  };
  return { unit: head.getFloat32(16, true), texels, backdrop: backdrop || null };
}

/**
 * Requests the lit spheres of an individual in a scene.
 * @param {string} id
 * @param {string} sceneId
 */
export const getSpheres = (id, sceneId) =>
  getBytes(`/v1/individuals/${id}/lit-spheres?scene=${sceneId}&texels=${TEXELS}`);

/**
 * Uploads lit spheres to the GPU.
 * @param {WebGL2RenderingContext} gl
 * @param {ArrayBuffer} bytes
 * @returns {Spheres}
 */
export function makeSpheres(gl, bytes) {
  const { unit, texels, backdrop } = readSpheres(bytes);
  return {
    texture: makeTexture(gl, ACROSS * TEXELS, texels),
    unit,
    backdrop: backdrop && {
      texture: makeTexture(gl, BACKDROP_TEXELS, backdrop.texels),
      unit: backdrop.unit,
    },
  };
}

/** @param {WebGL2RenderingContext} gl @param {Spheres} of */
export function dropSpheres(gl, of) {
  gl.deleteTexture(of.texture);
  if (of.backdrop) gl.deleteTexture(of.backdrop.texture);
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {number} side
 * @param {Uint16Array} texels
 */
function makeTexture(gl, side, texels) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGB16F, side, side);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, side, side, gl.RGB, gl.HALF_FLOAT, texels);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
    gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
  for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
    gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  return texture;
}
