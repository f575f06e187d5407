/** Pixels of a picture for measuring in it: linear light, and shrinking. Pure functions. */

/**
 * @typedef {{width: number, height: number, data: ArrayLike<number>}} Codes Codes of sRGB: red,
 *   green, blue and alpha of each pixel, from the top left.
 *
 * @typedef {{width: number, height: number, values: Float32Array, clipped: Uint8Array}} Grey
 *   Luminance in linear light; `clipped` is 1 where a channel is at its largest code.
 */

/** Code from which a channel may be clipped; compression blurs the largest. */
const CLIPPED = 252;

const LINEAR = Float32Array.from({ length: 256 }, (_, code) => {
  const value = code / 255;
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
});

/** Pictures that were converted before. @type {WeakMap<Codes, Grey>} */
const known = new WeakMap();

/** @param {Codes} of @returns {Grey} */
export function greyOf(of) {
  const before = known.get(of);
  if (before) return before;
  const { width, height, data } = of;
  const values = new Float32Array(width * height);
  const clipped = new Uint8Array(width * height);
  for (let at = 0; at < values.length; at += 1) {
    const [r, g, b] = [data[4 * at], data[4 * at + 1], data[4 * at + 2]];
    values[at] = 0.2126 * LINEAR[r] + 0.7152 * LINEAR[g] + 0.0722 * LINEAR[b];
    clipped[at] = Math.max(r, g, b) >= CLIPPED ? 1 : 0;
  }
  const grey = { width, height, values, clipped };
  known.set(of, grey);
  return grey;
}

/**
 * A picture whose pixels are means of squares of `step` pixels; what is left over at the right and
 * at the bottom is cut off.
 * @param {Codes} of
 * @param {number} step
 * @returns {Codes}
 */
export function shrunk({ width, height, data }, step) {
  const [across, down] = [Math.floor(width / step), Math.floor(height / step)];
  const means = new Float32Array(4 * across * down);
  for (let y = 0; y < down * step; y += 1) {
    for (let x = 0; x < across * step; x += 1) {
      const from = 4 * (y * width + x);
      const to = 4 * (Math.floor(y / step) * across + Math.floor(x / step));
      for (let channel = 0; channel < 4; channel += 1) means[to + channel] += data[from + channel];
    }
  }
  return { width: across, height: down, data: means.map((sum) => Math.round(sum / step ** 2)) };
}
