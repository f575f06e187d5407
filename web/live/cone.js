/**
 * Cones of spot lights: the share of the intensity in a direction, linear in the cosine between
 * the inner and the outer cone.
 *
 * @import { Light, Vec3 } from "../model.js"
 * @import { Linked } from "./program.js"
 */
import { uniformLocation } from "./program.js";

const DEGREE = Math.PI / 180;
/** Half angles of a spot light by default, degrees. */
const HOTSPOT_DEG = 10;
const FALLOFF_DEG = 15;
/** Least difference of the cosines of both cones. */
const LEAST = 1e-9;

/**
 * @typedef {{axis: Vec3, outer: number, slope: number}} Cone `axis`: unit direction of the light;
 *   `outer`: cosine of the outer cone's half angle; `slope`: of the share over the cosine
 */

/** All directions alike. @type {Cone} */
export const EVERY_WAY = { axis: [0, 0, 0], outer: -1, slope: 1 };

/**
 * Cone of a spot light.
 * @param {Light} light
 * @param {Vec3} axis unit direction of the light
 * @returns {Cone}
 */
export function coneOf({ hotspot_deg, falloff_deg }, axis) {
  const inner = Math.cos((hotspot_deg ?? HOTSPOT_DEG) * DEGREE);
  const outer = Math.cos((falloff_deg ?? FALLOFF_DEG) * DEGREE);
  return { axis, outer, slope: 1 / Math.max(inner - outer, LEAST) };
}

/** GLSL: share of a light's intensity, from the unit direction to the light. */
export const CONE = `
uniform vec4 cone;
uniform float slope;
float in_cone(vec3 towards) { return clamp((-dot(towards, cone.xyz) - cone.w) * slope, 0.0, 1.0); }`;

/** @param {WebGL2RenderingContext} gl @param {Linked} pen @param {Cone} cone */
export function bindCone(gl, pen, { axis, outer, slope }) {
  gl.uniform4f(uniformLocation(gl, pen, "cone"), ...axis, outer);
  gl.uniform1f(uniformLocation(gl, pen, "slope"), slope);
}
