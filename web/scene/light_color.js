/**
 * Colour and strength of a light as the controls set them, and as its radiant intensity in the
 * scene. Linear light in the scene, sRGB in the controls.
 *
 * The two controls are independent: the colour is scaled so that its strongest channel is 1, and
 * the strength counts stops from the scene's default light (irradiance pi at the centre of the
 * object).
 *
 * @import { Extent } from "../live/camera.js"
 * @import { Channels, Light, Vec3 } from "../model.js"
 */
import { colorCode, linearOf } from "../page/srgb.js";
import { LIGHT_KINDS } from "./light_kind.js";

/** Distance in radii of a light without a position. */
const PLACED_RADII = 4;

/** @typedef {{color: string, ev: number}} LightSetting `color` as `#rrggbb` */

/** Setting of the default light. @type {LightSetting} */
export const NEUTRAL = { color: "#ffffff", ev: 0 };

/**
 * The brightest colour of the same hue, in linear light. Black counts as white.
 * @param {string} color
 * @returns {Vec3}
 */
export function hueOf(color) {
  const [r, g, b] = linearOf(color);
  const strongest = Math.max(r, g, b);
  return strongest > 0 ? [r / strongest, g / strongest, b / strongest] : [1, 1, 1];
}

/** Fields that may hold the strength of a light. */
const STRENGTHS = [
  "intensity",
  "intensity_cd",
  "flux_w",
  "flux_lm",
  "irradiance_w_m2",
  "illuminance_lx",
  "radiance_w_m2_sr",
  "luminance_nit",
  "scale",
];

/**
 * Field that the controls adjust; null if there is none or the scene gives the strength in another
 * field.
 * @param {Light} light
 */
export function strengthField(light) {
  const field = LIGHT_KINDS[light.kind ?? "point"].adjusted;
  const given = Object.entries(light).filter(
    ([name, value]) => value !== null && STRENGTHS.includes(name),
  );
  return given.every(([name]) => name === field) ? field : null;
}

/**
 * Default strength of a light: irradiance pi at the centre of the object; for an environment the
 * picture's own.
 * @param {Light} light
 * @param {Extent} extent of the unturned object
 */
export function neutralStrength(light, extent) {
  const field = strengthField(light);
  if (field === "irradiance_w_m2") return Math.PI;
  return field === "intensity" ? neutralIntensity(light, extent) : 1;
}

/**
 * Intensity that gives irradiance pi at the centre of the object.
 * @param {Light} light
 * @param {Extent} extent of the unturned object
 */
export function neutralIntensity({ position }, { centre, radius }) {
  const distance = position
    ? Math.hypot(position[0] - centre[0], position[1] - centre[1], position[2] - centre[2])
    : PLACED_RADII * radius;
  return Math.PI * distance ** 2;
}

/**
 * Strength per channel of a setting.
 * @param {LightSetting} lamp
 * @param {number} plain strength at 0 EV
 * @returns {Vec3|null} null for the default light
 */
export function intensityOf({ color, ev }, plain) {
  const [r, g, b] = hueOf(color);
  if (ev === 0 && r === 1 && g === 1 && b === 1) return null;
  const strength = 2 ** ev * plain;
  return [r * strength, g * strength, b * strength];
}

/**
 * Setting of a strength: the inverse of `intensityOf`.
 * @param {Channels|undefined} strength
 * @param {number} plain strength at 0 EV
 * @returns {LightSetting|null} null if the light is dark
 */
export function settingOf(strength, plain) {
  if (strength === null || strength === undefined) return NEUTRAL;
  const intensity = typeof strength === "number" ? [strength, strength, strength] : strength;
  const strongest = Math.max(...intensity);
  if (!(strongest > 0 && plain > 0)) return null;
  const color = colorCode(intensity.map((channel) => channel / strongest));
  return { color, ev: Math.round(100 * Math.log2(strongest / plain)) / 100 };
}
