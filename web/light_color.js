/**
 * A light's colour and strength as a person turns them, and its radiant intensity as a scene holds it. Pure functions; linear
 * light on the scene's side, sRGB on the person's.
 *
 * The two controls are independent: the colour is a hue whose strongest channel is 1, so that it has no brightness of its own,
 * and the strength counts stops from the light that a scene has where it says nothing (irradiance pi at the middle of the object).
 *
 * @import { Extent } from "./live/view.js"
 * @import { Channels, Light, Vec3 } from "./types.js"
 */

/** Distance in radii of a light that has no place of its own. */
const PLACED_RADII = 4;

/** @typedef {{color: string, ev: number}} Lamp `color` as `#rrggbb` */

/** What a scene means where it says nothing. @type {Lamp} */
export const PLAIN = { color: "#ffffff", ev: 0 };

/** @param {number} code 0 to 255 @returns {number} */
function linear(code) {
  const c = code / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

/** @param {number} x 0 to 1 @returns {number} 0 to 255 */
const encoded = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));

/**
 * The strongest of all colours of this hue, in linear light. Black has no hue, and is taken for white.
 * @param {string} color
 * @returns {Vec3}
 */
export function hueOf(color) {
  const [r, g, b] = [1, 3, 5].map((at) => linear(Number.parseInt(color.slice(at, at + 2), 16)));
  const strongest = Math.max(r, g, b);
  return strongest > 0 ? [r / strongest, g / strongest, b / strongest] : [1, 1, 1];
}

/** Fields in which a scene may hold a strength. */
const STRENGTHS = ["intensity", "intensity_cd", "flux_w", "flux_lm", "irradiance_w_m2", "illuminance_lx", "radiance_w_m2_sr", "luminance_nit", "scale"];

/** The field that the controls turn, by kind; lights with an area are as bright as they are large, and are left alone. */
const TURNED = /** @type {const} */ ({
  point: "intensity",
  spot: "intensity",
  ies: "intensity",
  directional: "irradiance_w_m2",
  ambient: "radiance_w_m2_sr",
  environment: "scale",
  sphere: null,
  disk: null,
  rectangle: null,
});

/**
 * The field in which the strength is that the controls turn; null where there is none, or the scene has it in another one.
 * @param {Light} light
 */
export function strengthField(light) {
  const field = TURNED[light.kind ?? "point"];
  const given = Object.entries(light).filter(([name, value]) => value !== null && STRENGTHS.includes(name));
  return given.every(([name]) => name === field) ? field : null;
}

/**
 * The strength that a light has where the scene says nothing: irradiance pi at the middle of the object; of an environment the
 * picture's own.
 * @param {Light} light
 * @param {Extent} extent of the unturned object
 */
export function plainStrength(light, extent) {
  const field = strengthField(light);
  if (field === "irradiance_w_m2") return Math.PI;
  return field === "intensity" ? plainIntensity(light, extent) : 1;
}

/**
 * The intensity that gives irradiance pi at the middle of the object.
 * @param {Light} light
 * @param {Extent} extent of the unturned object
 */
export function plainIntensity({ position }, { centre, radius }) {
  const distance = position
    ? Math.hypot(position[0] - centre[0], position[1] - centre[1], position[2] - centre[2])
    : PLACED_RADII * radius;
  return Math.PI * distance ** 2;
}

/**
 * @param {Lamp} lamp
 * @param {number} plain
 * @returns {Vec3|null} null where the scene need say nothing
 */
export function intensityOf({ color, ev }, plain) {
  const [r, g, b] = hueOf(color);
  if (ev === 0 && r === 1 && g === 1 && b === 1) return null;
  const strength = 2 ** ev * plain;
  return [r * strength, g * strength, b * strength];
}

/**
 * @param {Channels|undefined} strength
 * @param {number} plain
 * @returns {Lamp|null} null where the light is dark
 */
export function lampOf(strength, plain) {
  if (strength === null || strength === undefined) return PLAIN;
  const intensity = typeof strength === "number" ? [strength, strength, strength] : strength;
  const strongest = Math.max(...intensity);
  if (!(strongest > 0 && plain > 0)) return null;
  const color = intensity.map((channel) => encoded(channel / strongest).toString(16).padStart(2, "0")).join("");
  return { color: `#${color}`, ev: Math.round(100 * Math.log2(strongest / plain)) / 100 };
}
