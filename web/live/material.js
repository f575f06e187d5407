/**
 * A material on the GPU: the shader around its exported function, and its automatic exposure. The
 * shader reads directions and light from the textures of a surface (`surface.js`).
 *
 * @import { Linked } from "./program.js"
 * @import { Shaded, Surface, SurfacePrograms } from "./surface.js"
 * @import { PointLight } from "./camera.js"
 * @import { Spheres } from "./spheres.js"
 */
import { DEVELOPED, FILM } from "./film.js";
import { drawLitCells } from "./lit_cells.js";
import { indexOf, paintedFragment, passedOf } from "./paint.js";
import {
  OUTLINED, deleteProgram, isLinked, link, linkError, linkNow, read, uniformLocation,
} from "./program.js";
import { dropSpheres } from "./spheres.js";
import { drawWithin } from "./surface.js";
import { drawSurroundings } from "./surroundings.js";

/** Side of the pictures on which exposure is measured, and number of light angles measured. */
export const METER_SIDE = 32;
export const METER_ANGLES = 8;
/**
 * Automatic exposure: this share of the lit pixels is below this level, as docs/maths/film.md
 * defines it.
 */
const METER_SHARE = 0.97;
const METER_LEVEL = 0.9;
/**
 * Gain of the film while measuring: so small that the sRGB curve is linear for the strongest
 * reflected light, and the radiance can be computed from the code.
 */
export const METER_GAIN = 2 ** -44;
/** Slope of the sRGB curve there. */
const METER_SLOPE = 12.92;

/** True if exported code is that of a material with bumps. @param {string} source */
const hasBumps = (source) => source.includes("vec2 evolved_slopes(");

/**
 * Direction across u: n cross u, or its opposite where the texture of a material with bumps is
 * mirrored.
 * @param {string} evolved
 */
const across = (evolved) =>
  hasBumps(evolved)
    ? "vec3(0.0, dFdx(eye.z) * dFdy(eye.w) < dFdx(eye.w) * dFdy(eye.z) ? -1.0 : 1.0, 0.0)"
    : "vec3(0.0, 1.0, 0.0)";

/** Shading of a pixel under the lights. @param {string} evolved @param {number} lights */
const lighting = (evolved, lights) => `
  float coverage = 0.0;
  vec3 radiance = vec3(0.0);
  vec4 eye = texelFetch(seen, at, 0);
  vec3 wo = vec3(eye.xy, max(1e-4, sqrt(max(0.0, 1.0 - dot(eye.xy, eye.xy)))));
  vec3 y = ${across(evolved)};
  ${lights > 1 ? `for (int k = 0; k < ${lights}; k++)` : "const int k = 0;"}
  {
    vec4 light = texelFetch(lit, at + ivec2(0, (first + k) * side), 0);
    coverage = light.w;
    vec3 wi = vec3(light.xy, sqrt(max(0.0, 1.0 - dot(light.xy, light.xy))));
    vec3 f = evolved(wi, wo, vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), y, eye.zw);
    radiance += f * intensities[k] * light.z;
  }`;

/** Shading of a pixel that no light reaches. */
const NO_LIGHT = `
  float coverage = texelFetch(lit, at, 0).w;
  vec3 radiance = vec3(0.0);`;

/**
 * Fragment shader from the surface textures to a pixel's colour. Straight-line code, except for a
 * loop over several lights: software renderers run both sides of every branch, and a branch around
 * `evolved`, the material's f, costs them more than `evolved` itself. A light below the horizon has
 * cos_i 0.
 * @param {string} evolved the exported functions
 * @param {number} lights 0 for pixels that no light reaches
 * @param {{surrounded?: boolean, linear?: boolean}} how `surrounded`: true if there are
 *   environments; `linear`: true for radiance instead of the colours of the film
 */
const fragment = (evolved, lights, { surrounded, linear }) => `#version 300 es
${evolved}
precision highp sampler2D;
uniform sampler2D seen;
uniform sampler2D lit;
uniform ivec2 corner;
uniform int side;
uniform int first;
uniform vec3 intensities[${Math.max(1, lights)}];
${surrounded ? "uniform sampler2D surroundings;\nuniform float around;" : ""}
out vec4 color;
${linear ? "" : FILM + DEVELOPED}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - corner;
  ${lights > 0 ? lighting(evolved, lights) : NO_LIGHT}
  ${surrounded ? "radiance += around * texelFetch(surroundings, at, 0).rgb;" : ""}
  color = vec4(${linear ? "radiance" : "developed(toned(radiance * gain), coverage)"}, 1.0) * coverage;
}`;

/** True if exported code is that of a painted material. @param {string} source */
export const isStyle = (source) => source.includes("vec3 styled(");

/**
 * @typedef {{linked: Linked, painted: boolean, index: number|null, passed: number, bumps: boolean,
 *   metered: boolean, lights: number, spheres: Spheres|null, state:
 *   "linking"|"metering"|"ready"|"refused", drawable: boolean, gain: number, fence: WebGLSync|null,
 *   pixels: WebGLBuffer|null}} Material
 *   `painted`: true if it has colours, not a BRDF. `index`: of refraction of a clear one, else
 *   null. `passed`: share of light that passes through it. `bumps`: true if it has some. `metered`:
 *   true if it has an exposure. `spheres`: null without environments. `state`: the shader is being
 *   compiled, the exposure is being measured, done, or the driver rejected the shader. `drawable`:
 *   true from the first measurement on. `gain`: of automatic exposure. `fence`, `pixels`: of the
 *   measurement while it runs.
 *
 * @typedef {{surface: Surface, lights: PointLight[], around: number}} Look A surface, the lights in
 *   its slots, and the factor of environments. On the meter's surface these are the scene's lights
 *   at each measured angle, angle after angle.
 *
 * @typedef {Omit<Look, "surface"> & {surface: Shaded}} ShadedLook As `Look`, also on the ends of
 * rays
 *
 * @typedef {{framebuffer: WebGLFramebuffer, texture: WebGLTexture}} Meter Holds one picture for
 *   each measured angle, side by side.
 */

/**
 * Starts compiling a material.
 * @param {WebGL2RenderingContext} gl
 * @param {string} source the exported functions
 * @param {number} lights number of lights of the scene; of a painted material, of the functions
 * @param {Spheres|null} spheres the material in the environments of the scene
 * @param {boolean} [linear] true to draw linear light instead of colours of the film
 * @returns {Material}
 */
export function makeMaterial(gl, source, lights, spheres, linear = false) {
  const painted = isStyle(source);
  const text = painted
    ? paintedFragment(source, lights, linear)
    : fragment(source, lights, { surrounded: spheres !== null, linear });
  return {
    linked: link(gl, OUTLINED, text),
    painted,
    index: painted ? indexOf(source) : null,
    passed: painted ? passedOf(source) : 0,
    bumps: hasBumps(source),
    metered: !(painted || linear),
    lights,
    spheres,
    state: "linking",
    drawable: false,
    gain: 1,
    fence: null,
    pixels: null,
  };
}

/**
 * Programs that draw pixels that no light reaches, the same for all materials: without and with
 * environments.
 * @param {WebGL2RenderingContext} gl
 */
export const linkDark = (gl) =>
  [false, true].map((surrounded) =>
    linkNow(gl, OUTLINED, fragment("precision highp float;", 0, { surrounded })),
  );

/** Key of the environments of a material; empty without. @param {Material} of */
export const environmentOf = ({ spheres }) => spheres?.environment ?? "";

/**
 * Replaces the environments of a material that has some, and measures its exposure again.
 * @param {WebGL2RenderingContext} gl
 * @param {Material} of
 * @param {Spheres|null} spheres
 */
export function replaceSpheres(gl, of, spheres) {
  if (of.spheres) dropSpheres(gl, of.spheres);
  of.spheres = spheres;
  remeter(gl, of);
}

/** @param {WebGL2RenderingContext} gl @param {Material} of */
export function dropMaterial(gl, of) {
  deleteProgram(gl, of.linked);
  if (of.spheres) dropSpheres(gl, of.spheres);
  if (of.fence) gl.deleteSync(of.fence);
  if (of.pixels) gl.deleteBuffer(of.pixels);
}

/** @param {WebGL2RenderingContext} gl @returns {Meter} */
export function makeMeter(gl) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, METER_SIDE * METER_ANGLES, METER_SIDE);
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return { framebuffer, texture };
}

/**
 * Binds textures and lights of a look to a program.
 * @param {WebGL2RenderingContext} gl
 * @param {Linked} linked
 * @param {ShadedLook} look
 * @param {Spheres|null} spheres
 */
function bindLook(gl, linked, { surface, lights, around }, spheres) {
  const surrounding = spheres && surface.surroundings.get(spheres);
  read(gl, linked, {
    seen: surface.seen,
    lit: surface.lit,
    ...(surrounding && { surroundings: surrounding.texture }),
  });
  if (spheres) gl.uniform1f(uniformLocation(gl, linked, "around"), around * spheres.unit);
  gl.uniform1i(uniformLocation(gl, linked, "side"), surface.side);
  gl.uniform1i(uniformLocation(gl, linked, "first"), 0);
  if (lights.length > 0)
    gl.uniform3fv(
      uniformLocation(gl, linked, "intensities"),
      lights.flatMap((light) => light.intensity),
    );
}

/**
 * Draws a material into the square at a corner of the present framebuffer. Its surroundings are
 * drawn by then. Once the lit cells are known, only these are shaded by lights. If colours are
 * added to those of other objects, lit cells must not add their coverage again.
 * @param {WebGL2RenderingContext} gl
 * @param {Material} of
 * @param {Linked[]} dark
 * @param {ShadedLook} look
 * @param {{corner: [number, number], gain: number, tone: number, marks: boolean, adds: boolean}}
 *   where `corner`: lower left in pixels; `gain`, `tone`: of the film; `marks`: true to mark
 *   burnt-out and black pixels; `adds`: true if what is drawn is added to the framebuffer
 */
export function drawMaterial(gl, of, dark, look, { corner, gain, tone, marks, adds }) {
  const { surface } = look;
  // What is drawn without light must be black where it is added to.
  const { litCells } = surface;
  const known = "lit" in litCells && litCells.cells !== null && !(adds && (marks || of.spheres));
  /** @param {Linked} linked @param {PointLight[]} lights */
  const ready = (linked, lights) => {
    bindLook(gl, linked, { ...look, lights }, of.spheres);
    gl.uniform2i(uniformLocation(gl, linked, "corner"), ...corner);
    gl.uniform1f(uniformLocation(gl, linked, "gain"), gain);
    gl.uniform1i(uniformLocation(gl, linked, "tone"), tone);
    gl.uniform1i(uniformLocation(gl, linked, "marks"), marks ? 1 : 0);
  };
  ready(known ? dark[of.spheres ? 1 : 0] : of.linked, known ? [] : look.lights);
  gl.viewport(corner[0], corner[1], surface.side, surface.side);
  drawWithin(gl, surface);
  if (!known) return;
  ready(of.linked, look.lights);
  gl.colorMask(true, true, true, !adds);
  drawLitCells(gl, { side: surface.side, litCells }, corner);
  gl.colorMask(true, true, true, true);
}

/**
 * Starts measuring the exposure over a whole turn of the light, so that it does not flicker.
 * @param {WebGL2RenderingContext} gl
 * @param {Material} of
 * @param {{meter: Meter, look: Look, pens: SurfacePrograms}} scene `look`: the lights at all
 *   measured angles
 */
function startMetering(gl, of, { meter, look, pens }) {
  if (of.spheres) drawSurroundings(gl, pens, look.surface, of.spheres);
  gl.bindFramebuffer(gl.FRAMEBUFFER, meter.framebuffer);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT);
  const together = look.lights.length / METER_ANGLES;
  for (let k = 0; k < METER_ANGLES; k += 1) {
    const lights = look.lights.slice(k * together, (k + 1) * together);
    bindLook(gl, of.linked, { ...look, lights }, of.spheres);
    gl.uniform2i(uniformLocation(gl, of.linked, "corner"), k * METER_SIDE, 0);
    gl.uniform1i(uniformLocation(gl, of.linked, "first"), k * together);
    gl.uniform1f(uniformLocation(gl, of.linked, "gain"), METER_GAIN);
    gl.uniform1i(uniformLocation(gl, of.linked, "tone"), 0);
    gl.uniform1i(uniformLocation(gl, of.linked, "marks"), 0);
    gl.viewport(k * METER_SIDE, 0, METER_SIDE, METER_SIDE);
    drawWithin(gl, look.surface);
  }
  of.pixels = of.pixels ?? gl.createBuffer();
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, of.pixels);
  gl.bufferData(gl.PIXEL_PACK_BUFFER, 16 * METER_ANGLES * METER_SIDE * METER_SIDE, gl.STREAM_READ);
  gl.readPixels(0, 0, METER_ANGLES * METER_SIDE, METER_SIDE, gl.RGBA, gl.FLOAT, 0);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  of.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
}

/**
 * Reads a finished measurement; returns the gain.
 * @param {WebGL2RenderingContext} gl
 * @param {Material} of
 */
function readMeter(gl, of) {
  const pixels = new Float32Array(4 * METER_ANGLES * METER_SIDE * METER_SIDE);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, of.pixels);
  gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, pixels);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  if (of.pixels) gl.deleteBuffer(of.pixels);
  if (of.fence) gl.deleteSync(of.fence);
  of.pixels = null;
  of.fence = null;
  return autoGain(pixels);
}

/**
 * Gain of automatic exposure.
 * @param {Float32Array} pixels drawn at the meter's gain, four numbers each
 */
export function autoGain(pixels) {
  const lit = [];
  for (let k = 0; k < pixels.length; k += 4) {
    const largest = Math.max(pixels[k], pixels[k + 1], pixels[k + 2]);
    // Pixels without light do not count.
    if (largest > 0) lit.push(largest / (pixels[k + 3] * METER_SLOPE * METER_GAIN));
  }
  const level = percentileOf(lit);
  return level === null ? 1 : METER_LEVEL / level;
}

/**
 * The level that automatic exposure measures; null if there is no light.
 * @param {number[]} lit levels of the lit pixels
 */
export function percentileOf(lit) {
  lit.sort((a, b) => a - b);
  const level = lit[Math.ceil(METER_SHARE * lit.length) - 1];
  return level === undefined || level < 1e-8 ? null : level;
}

/**
 * Advances a material by one step towards being drawable, without waiting.
 * @param {WebGL2RenderingContext} gl
 * @param {Material} of
 * @param {{meter: Meter, look: Look, pens: SurfacePrograms}} scene
 * @returns {boolean} true if anything has changed
 */
export function advance(gl, of, scene) {
  if (of.state === "linking") {
    if (!isLinked(gl, of.linked)) return false;
    const reason = linkError(gl, of.linked);
    if (reason !== null) {
      console.warn(`a material stays a picture: ${reason}`);
      of.state = "refused";
      return true;
    }
    if (!of.metered) {
      of.drawable = true;
      of.state = "ready";
      return true;
    }
    // Also if the film's exposure is fixed: software renderers compile at the first drawing, which
    // is thus not on the screen.
    startMetering(gl, of, scene);
    of.state = "metering";
    return true;
  }
  if (of.state !== "metering" || !of.fence) return false;
  const status = gl.clientWaitSync(of.fence, 0, 0);
  if (status === gl.TIMEOUT_EXPIRED) return false;
  of.gain = readMeter(gl, of);
  of.drawable = true;
  of.state = "ready";
  return true;
}

/**
 * Measures the exposure again after object or lights have changed: `advance` finds the shader
 * linked and starts a measurement.
 * @param {WebGL2RenderingContext} gl
 * @param {Material} of
 */
export function remeter(gl, of) {
  if (!of.metered || (of.state !== "ready" && of.state !== "metering")) return;
  if (of.fence) gl.deleteSync(of.fence);
  of.fence = null;
  of.state = "linking";
}
