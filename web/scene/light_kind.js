/**
 * Kinds of light that the page offers.
 *
 * @import { LightKind } from "../model.js"
 */

/**
 * Field of the strength that the controls adjust. Lights with an area are not adjusted, because
 * their strength depends on their size.
 * @typedef {"intensity"|"irradiance_w_m2"|"radiance_w_m2_sr"|"scale"|null} Adjusted
 */

/** Names on the page of the built-in environments, by their names in scenes. */
export const ENVIRONMENTS = {
  studio: "studio",
  overcast: "overcast sky",
  "low-sun": "low sun",
  interior: "interior",
};

/**
 * By kind: the name on the page, the adjusted field, whether the light has a position, and the
 * endings of its file if it needs one.
 * @type {Record<LightKind, {name: string, adjusted: Adjusted, isPlaced: boolean, accept?: string}>}
 */
export const LIGHT_KINDS = {
  point: { name: "point", adjusted: "intensity", isPlaced: true },
  directional: { name: "directional", adjusted: "irradiance_w_m2", isPlaced: false },
  spot: { name: "spot", adjusted: "intensity", isPlaced: true },
  sphere: { name: "sphere", adjusted: null, isPlaced: true },
  disk: { name: "disk", adjusted: null, isPlaced: true },
  rectangle: { name: "rectangle", adjusted: null, isPlaced: true },
  ambient: { name: "ambient", adjusted: "radiance_w_m2_sr", isPlaced: false },
  ies: { name: "IES profile", adjusted: "intensity", isPlaced: true, accept: ".ies,.IES" },
  environment: { name: "environment", adjusted: "scale", isPlaced: false, accept: ".hdr,.exr" },
};
