/** Sizes of pictures in pixels. */

/** Least and most pixels of a side that the server renders. */
export const SIDE_PX = { min: 16, max: 2048 };

/**
 * Width and height of a size as the server writes it: one number for a square, else a pair.
 * @param {number|number[]} size_px
 * @returns {[number, number]}
 */
export function sidesOf(size_px) {
  const [width, height = width] = [size_px].flat();
  return [width, height];
}

/** @param {number|number[]} size_px */
export const sizeInWords = (size_px) => sidesOf(size_px).join(" × ");

/** @param {string} text */
function sideOf(text) {
  const side = /^\d{1,5}$/.test(text.trim()) ? Number(text) : 0;
  return side >= SIDE_PX.min && side <= SIDE_PX.max ? side : null;
}

/**
 * The `size` of a request from two texts, or null if one is not a valid side.
 * @param {{width: string, height: string}} sides
 */
export function requestedSize({ width, height }) {
  const sides = [sideOf(width), sideOf(height)];
  return sides.includes(null) ? null : sides.join("x");
}
