/**
 * Light from environments, live: the server computes the radiance of a material for all normals,
 * seen from nine places of the picture (its lit spheres); any mesh in any rotation is drawn from
 * them. Only for isotropic homogeneous materials.
 *
 * A point with normal n and direction to the eye o has the mirror direction r. On the sphere of
 * direction v it takes the normal between v and r, so that r is the same; the remaining error in
 * the normal cancels to first order in the bilinear mean of the four spheres around the point.
 *
 * While environments turn, spheres under several turns are used, from the places in the middle
 * column of the picture: radiance is the same where environments, o and r are turned alike. The
 * mean is that of the spheres of two turns and two places around o.
 *
 * @import { Camera, Light, Scene } from "../model.js"
 */
import { getBytes } from "../api/request.js";
import { postGenome } from "../api/routes.js";
import { axes } from "../scene/rotation.js";
import { readHead } from "./file.js";
import { texture } from "./texture.js";

/** Texels along the side of a sphere at rest. */
const TEXELS = 48;
/** Number of rows of spheres, and of spheres in a row at rest. */
const ROWS = 3;
/** Number of turns while environments turn, and texels along the side of a sphere. */
const TURNS = 18;
const TURNED_TEXELS = 32;
const HEAD = { magic: "broodlit", version: 3, name: "lit spheres", count: 2 };
/** Number of bytes before the texels. */
const HEAD_BYTES = 24;
/** Texels along the side of a backdrop. */
const BACKDROP_TEXELS = 64;

/**
 * Common to both shaders of places: where a sphere has the mirror direction r, from 0 to 1.
 * @param {number} texels
 */
const head = (texels) => `#version 300 es
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
layout(location = 2) out vec4 between;
vec3 view(vec2 place) {
  return normalize(-forward - (parallel ? 0.0 : lens) * (place.x * right + place.y * up));
}
vec2 within(vec3 v, vec3 r) {
  vec3 x = normalize(right - v * dot(right, v));
  vec3 n = v + r;
  vec3 local = vec3(dot(n, x), dot(n, cross(v, x)), max(dot(n, v), 0.0));
  vec2 p = local.xy / max(abs(local.x) + abs(local.y) + local.z, 1e-9);
  vec2 at = 0.5 + 0.5 * vec2(p.x + p.y, p.x - p.y);
  return (0.5 + at * ${texels - 1}.0) / ${texels}.0;
}
void mirrored(out vec3 wo, out vec3 r) {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec3 n = texelFetch(normal, here, 0).xyz;
  wo = parallel ? -forward : normalize(eye - texelFetch(point, here, 0).xyz);
  r = 2.0 * max(dot(n, wo), 0.0) * n - wo;
}`;

/** Writes the places of the four normals in the texture of the spheres, and their shares. */
export const PLACES = `${head(TEXELS)}
vec2 on(vec2 sphere, vec3 r) { return (sphere + within(view(sphere - 1.0), r)) / ${ROWS}.0; }
void main() {
  vec3 wo, r;
  mirrored(wo, r);
  vec2 across = gl_FragCoord.xy * ${ROWS - 1}.0 / float(side);
  vec2 first = floor(across);
  lower = vec4(on(first, r), on(first + vec2(1.0, 0.0), r));
  upper = vec4(on(first + vec2(0.0, 1.0), r), on(first + 1.0, r));
  between = fract(across).xxyy;
}`;

/** The same for spheres under several turns. */
export const TURNED_PLACES = `${head(TURNED_TEXELS)}
const float STEP = 6.28318530718 / ${TURNS}.0;
uniform float turn;
uniform mat3 world;
vec3 turned(vec3 d, float angle) {
  vec3 y = world[1];
  return d * cos(angle) + cross(y, d) * sin(angle) + y * dot(y, d) * (1.0 - cos(angle));
}
float azimuth(vec3 d) { return atan(dot(d, world[0]), dot(d, world[2])); }
float elevation(vec3 d) { return asin(clamp(dot(d, world[1]), -1.0, 1.0)); }
vec2 on(float row, float k, vec3 r) {
  vec2 in_sphere = within(view(vec2(0.0, row - 1.0)), turned(r, k * STEP - turn));
  float rows = mod(k, ${TURNS}.0) * ${ROWS}.0 + row;
  return vec2(in_sphere.x, (rows + in_sphere.y) / ${ROWS * TURNS}.0);
}
vec4 in_row(float row, vec3 wo, vec3 r, out float share) {
  float at = (turn + azimuth(view(vec2(0.0, row - 1.0))) - azimuth(wo)) / STEP;
  share = fract(at);
  return vec4(on(row, floor(at), r), on(row, floor(at) + 1.0, r));
}
void main() {
  vec3 wo, r;
  mirrored(wo, r);
  float here = elevation(wo);
  // The eye is seen highest from the lower edge.
  float row = here > elevation(view(vec2(0.0))) ? 0.0 : 1.0;
  float below = elevation(view(vec2(0.0, row - 1.0)));
  float above = elevation(view(vec2(0.0, row)));
  between = vec4(0.0, 0.0, clamp((below - here) / max(below - above, 1e-6), 0.0, 1.0), 0.0);
  lower = in_row(row, wo, r, between.x);
  upper = in_row(row + 1.0, wo, r, between.y);
}`;

/** Writes the radiance of a material at the places. */
export const SURROUNDINGS = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D lower;
uniform sampler2D upper;
uniform sampler2D between;
uniform sampler2D spheres;
out vec4 radiance;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 below = texelFetch(lower, at, 0);
  vec4 above = texelFetch(upper, at, 0);
  vec4 share = texelFetch(between, at, 0);
  radiance = vec4(mix(
    mix(texture(spheres, below.xy).rgb, texture(spheres, below.zw).rgb, share.x),
    mix(texture(spheres, above.xy).rgb, texture(spheres, above.zw).rgb, share.y),
    share.z
  ), 1.0);
}`;

/**
 * @typedef {{texture: WebGLTexture, unit: number}} Radiance `unit`: radiance of a texel of 1
 *
 * @typedef {Radiance & {environment: string, backdrop: Radiance|null}} Spheres `environment`: key
 *   of the environments; `backdrop`: these behind the object, from the top; null if the scene shows
 *   none
 */

/** Environments of a scene. @param {Pick<Scene, "lights">} scene */
const environmentsOf = ({ lights }) => (lights ?? []).filter(({ kind }) => kind === "environment");

/** True if an environment turns with the light. @param {Pick<Scene, "lights">} scene */
export const isTurning = (scene) => environmentsOf(scene).some(({ fixed }) => !fixed);

/** True if all environments turn with the light. @param {Pick<Scene, "lights">} scene */
export const isTurnedAsWhole = (scene) => environmentsOf(scene).every(({ fixed }) => !fixed);

/**
 * Rotation of an environment about the vertical, degrees.
 * @param {Light} light
 * @param {number} degrees angle of the light
 */
export const rotationAt = ({ rotation_deg: own = 0, fixed }, degrees) => own + (fixed ? 0 : degrees);

/**
 * Rotation of the first environment, which those of several turns are relative to, degrees.
 * @param {Pick<Scene, "lights">} scene with an environment
 * @param {number} degrees angle of the light
 */
export const turnOf = (scene, degrees) => rotationAt(environmentsOf(scene)[0], degrees);

/** @param {number} degrees */
const aroundOnce = (degrees) => ((degrees % 360) + 360) % 360;

/** @typedef {{key: string, turns: number}} Environment Identity of what lit spheres depend on
 *   besides the material, empty without environments; number of turns, 1 at rest. */

/** @type {Environment} */
export const NO_ENVIRONMENT = { key: "", turns: 1 };

/**
 * The environments of a scene at rest.
 * @param {Scene} scene
 * @returns {Environment}
 */
export function restingEnvironment(scene) {
  const environments = environmentsOf(scene);
  if (environments.length === 0) return NO_ENVIRONMENT;
  const rotations = environments.map((one) => aroundOnce(rotationAt(one, scene.light_deg ?? 0)));
  const backdrop = scene.backdrop?.kind === "environment" ? scene.backdrop : null;
  return { key: keyOf(environments, rotations, [scene.camera, backdrop]), turns: 1 };
}

/**
 * The environments of a scene in any rotation as a whole; null if they cannot be drawn so.
 * @param {Scene} scene
 * @returns {Environment|null}
 */
export function turningEnvironment(scene) {
  const environments = environmentsOf(scene);
  const degrees = scene.light_deg ?? 0;
  if (environments.length === 0) return null;
  // A backdrop would have to turn as well.
  if (scene.backdrop?.kind === "environment" || !isUpright(scene.camera)) return null;
  const first = turnOf(scene, degrees);
  const rotations = environments.map((one) => aroundOnce(rotationAt(one, degrees) - first));
  return { key: keyOf(environments, rotations, ["turned", scene.camera]), turns: TURNS };
}

/**
 * @param {Light[]} environments
 * @param {number[]} rotations
 * @param {unknown[]} rest
 */
const keyOf = (environments, rotations, rest) =>
  JSON.stringify([
    environments.map((one, k) => ({ ...one, fixed: true, rotation_deg: rotations[k] })),
    ...rest,
  ]);

/**
 * True if directions to the eye fall from the lower to the upper edge of the picture.
 * @param {Camera} camera
 */
function isUpright(camera) {
  if (camera.orthographic !== undefined) return true;
  const { up, back } = axes(camera);
  const half = Math.tan((0.5 * (camera.fov_y_deg ?? 30) * Math.PI) / 180);
  /** @param {number} place */
  const height = (place) => {
    const [x, y, z] = back.map((part, k) => part - half * place * up[k]);
    return y / Math.hypot(x, y, z);
  };
  // As in the shader.
  const [lower, middle, upper] = [-1, 0, 1].map(height);
  return lower > middle && middle > upper;
}

/**
 * Reads the head of a file of lit spheres, its texels, and those of its backdrop if it has one.
 * @param {ArrayBuffer} bytes
 */
export function readSpheres(bytes) {
  const [side, turns] = readHead(bytes, HEAD);
  const file = new DataView(bytes);
  if (side !== (turns === 1 ? TEXELS : TURNED_TEXELS))
    throw new Error("the lit spheres have another size than the page expects");
  const across = turns === 1 ? ROWS * side : side;
  const height = ROWS * side * turns;
  const texels = new Uint16Array(bytes, HEAD_BYTES, 3 * across * height);
  const end = HEAD_BYTES + texels.byteLength;
  const backdrop = bytes.byteLength > end && {
    unit: file.getFloat32(end, true),
    texels: new Uint16Array(bytes, end + 4, 3 * BACKDROP_TEXELS ** 2),
  };
  const unit = file.getFloat32(20, true);
  return { unit, across, height, texels, backdrop: backdrop || null };
}

/**
 * @param {string} sceneId
 * @param {number} turns
 */
const optionsOf = (sceneId, turns) =>
  `scene=${sceneId}&texels=${turns === 1 ? TEXELS : TURNED_TEXELS}&turns=${turns}`;

/**
 * Requests the lit spheres of an individual in a scene; empty if its material has none.
 * @param {string} id
 * @param {string} sceneId
 * @param {number} turns
 */
export const getSpheres = (id, sceneId, turns) =>
  getBytes(`/v1/individuals/${id}/lit-spheres?${optionsOf(sceneId, turns)}`);

/**
 * Requests the lit spheres of a genome that is not stored.
 * @param {string} text
 * @param {string} sceneId
 * @param {number} turns
 */
export const lightGenome = async (text, sceneId, turns) =>
  (await postGenome(`/v1/lit-spheres?${optionsOf(sceneId, turns)}`, text)).arrayBuffer();

/**
 * Uploads lit spheres to the GPU.
 * @param {WebGL2RenderingContext} gl
 * @param {ArrayBuffer} bytes
 * @param {string} environment key of the environments
 * @returns {Spheres}
 */
export function makeSpheres(gl, bytes, environment) {
  const { unit, across, height, texels, backdrop } = readSpheres(bytes);
  return {
    texture: makeTexture(gl, [across, height], texels),
    unit,
    environment,
    backdrop: backdrop && {
      texture: makeTexture(gl, [BACKDROP_TEXELS, BACKDROP_TEXELS], backdrop.texels),
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
 * @param {[number, number]} size width and height
 * @param {Uint16Array} texels
 */
function makeTexture(gl, [width, height], texels) {
  const made = texture(gl, gl.RGB16F, width, height, gl.LINEAR);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGB, gl.HALF_FLOAT, texels);
  return made;
}
