/**
 * Controls of a light's shape: size of lights with an area, cone and softness of a spot. Pure
 * functions.
 *
 * @import { Light } from "../model.js"
 * @import { Extent } from "../live/camera.js"
 */

/** Half angles of a spot's cone that the server assumes, in degrees. */
const SPOT = { hotspot_deg: 10, falloff_deg: 15 };

/**
 * @typedef {{id: string, name: string, title: string, value: number, min: number, max: number,
 *   step: number, shown: string, change: (value: number) => Partial<Light>}} ShapeControl `change`:
 *   fields of the light at a value of the control
 */

/**
 * A size in radii of the object.
 * @param {"radius"|"width"|"height"} field
 * @param {Light} light
 * @param {Extent} extent
 * @param {number} otherwise the server's default, in radii
 * @returns {ShapeControl}
 */
function size(field, light, { radius }, otherwise) {
  const given = light[field];
  const value = typeof given === "number" ? given / radius : otherwise;
  return {
    id: `light-${field}`,
    name: { radius: "Radius", width: "Width", height: "Height" }[field],
    title: `${field === "radius" ? "Radius" : "Side"} of the light, relative to the object's radius: a larger light has softer highlights and shadows`,
    value,
    min: 0.05,
    max: 4,
    step: 0.05,
    shown: `${Number(value.toFixed(2))} ×`,
    change: (to) => ({ [field]: Number((to * radius).toPrecision(4)) }),
  };
}

/** Cone and softness of a spot. @param {Light} light @returns {ShapeControl[]} */
function cone(light) {
  const falloff = light.falloff_deg ?? SPOT.falloff_deg;
  const hotspot = light.hotspot_deg ?? SPOT.hotspot_deg;
  const softness = falloff > 0 ? Math.max(0, 1 - hotspot / falloff) : 0;
  /** @param {number} outer @param {number} soft @returns {Partial<Light>} */
  const angles = (outer, soft) => ({
    falloff_deg: outer,
    hotspot_deg: Number((outer * (1 - soft)).toFixed(3)),
  });
  return [
    {
      id: "light-cone",
      name: "Cone",
      title: "Half angle of the spot's cone",
      value: falloff,
      min: 2,
      max: 80,
      step: 1,
      shown: `${Number(falloff.toFixed(1))}°`,
      change: (to) => angles(to, softness),
    },
    {
      id: "light-softness",
      name: "Softness",
      title: "Share of the cone in which the spot fades out",
      value: softness,
      min: 0,
      max: 1,
      step: 0.05,
      shown: softness.toFixed(2),
      change: (to) => angles(falloff, to),
    },
  ];
}

/**
 * Controls of a light's shape; none for lights without one.
 * @param {Light} light
 * @param {Extent} extent bounding sphere of the object
 * @returns {ShapeControl[]}
 */
export function shapeControls(light, extent) {
  switch (light.kind) {
    case "sphere":
    case "disk":
      return [size("radius", light, extent, 0.5)];
    case "rectangle":
      return [size("width", light, extent, 1), size("height", light, extent, 1)];
    case "spot":
      return cone(light);
    default:
      return [];
  }
}
