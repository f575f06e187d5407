/**
 * Spread of the materials that match the pictures of a search: its map as pixels, and the next
 * picture in words.
 *
 * @import { Spread } from "../model.js"
 */

/** Deviation of ln f that is shown as full red: a factor of e. */
const OPEN = 1;
/** Share of the samples that is shown as full green, times the number of cells. */
const MANY = 8;

/**
 * Pixels of the map, one for each cell: red where the material is open, green where pixels are.
 * @param {Pick<Spread, "cells"|"seen"|"deviation">} of
 */
export function mapPixels({ cells, seen, deviation }) {
  const count = cells * cells;
  const pixels = new Uint8ClampedArray(4 * count);
  for (let at = 0; at < count; at++) {
    const known = Math.sqrt(Math.min(1, ((seen[at] ?? 0) * count) / MANY));
    const open = Math.min(1, (deviation[at] ?? 0) / OPEN);
    pixels.set([255 * open, 255 * known, 32, 255], 4 * at);
  }
  return pixels;
}

/** Next picture in words. @param {NonNullable<Spread["next"]>} of */
export function nextInWords({ light_deg, scene }) {
  if (!light_deg) return `turn the environment: "light_deg" ${scene.light_deg ?? 0}`;
  const [right = 0, up = 0] = light_deg;
  const side = right < 0 ? "left" : "right";
  const height = up < 0 ? "below" : "above";
  return `the lamp ${Math.round(Math.abs(right))}° to the ${side} of the camera and ${Math.round(Math.abs(up))}° ${height} it`;
}
