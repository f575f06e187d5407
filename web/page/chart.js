/**
 * Geometry of a line chart: round ticks, positions on the paper, paths. Pure functions, independent
 * of what is charted.
 *
 * @typedef {{low: number, high: number, ticks: number[], log?: boolean}} Axis
 *
 * @typedef {{left: number, top: number, width: number, height: number}} Box
 *
 * @typedef {[number, number|null]} Point x and y; y is null where it is missing
 */

/** Mantissas of round steps. */
const STEPS = [1, 2, 2.5, 5, 10];

/**
 * Axis from 0 beyond the largest value with round ticks.
 * @param {number} largest
 * @param {number} about approximate number of ticks
 * @returns {Axis}
 */
export function axisTo(largest, about) {
  const most = Number.isFinite(largest) && largest > 0 ? largest : 1;
  const rough = most / about;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = (STEPS.find((one) => one * power >= rough * (1 - 1e-9)) ?? 10) * power;
  const count = Math.ceil(most / step - 1e-9);
  // Rounded to twelve digits, because multiples of a tenth are not exact.
  const ticks = Array.from({ length: count + 1 }, (_, at) => Number((at * step).toPrecision(12)));
  return { low: 0, high: ticks[count], ticks };
}

/** An axis of decades leaves out values below the largest of their line divided by this. */
const FALL = 1000;
/** Approximate number of ticks on an axis of decades. */
const DECADES = 7;

/**
 * Axis of powers of ten around lines, without zeros and values far below the rest of their line.
 * @param {Point[][]} lines
 * @returns {Axis}
 */
export function axisOfDecades(lines) {
  const shown = lines.flatMap((line) => {
    const top = largestOf([line]);
    return line.flatMap(([, y]) => (y !== null && y > top / FALL ? [y] : []));
  });
  const [least, most] = shown.length > 0 ? [Math.min(...shown), Math.max(...shown)] : [1, 1];
  const low = Math.floor(Math.log10(least) + 1e-9);
  const decades = Math.max(1, Math.ceil(Math.log10(most) - low - 1e-9));
  const step = Math.ceil(decades / DECADES);
  const ticks = Array.from(
    { length: Math.ceil(decades / step) + 1 },
    (_, at) => 10 ** (low + at * step),
  );
  return { low: ticks[0], high: ticks[ticks.length - 1], ticks, log: true };
}

/** Ratio of two lines' maxima beyond which a linear axis would hide one of them. */
const APART = 25;

/** True if a linear axis would hide some line. @param {Point[][]} lines */
export function areFarApart(lines) {
  const tops = lines.map((line) => largestOf([line])).filter((top) => top > 0);
  return tops.length > 1 && Math.max(...tops) > APART * Math.min(...tops);
}

/** Largest value of some lines; 0 if there is none. @param {Point[][]} lines */
export const largestOf = (lines) =>
  lines
    .flat()
    .reduce((most, [, y]) => (y !== null && Number.isFinite(y) && y > most ? y : most), 0);

/**
 * Position of a value between two ends.
 * @param {Axis} axis
 * @param {number} value
 * @param {number} from
 * @param {number} to
 */
export function placeOn({ low, high, log }, value, from, to) {
  // Values below a logarithmic axis, such as 0, are placed at its low end.
  const share = log
    ? Math.log(Math.max(value, low) / low) / Math.log(high / low)
    : (value - low) / (high - low);
  return from + share * (to - from);
}

/**
 * SVG path of a line, interrupted where values are missing.
 * @param {Point[]} points
 * @param {Axis} x
 * @param {Axis} y
 * @param {Box} box
 */
export function lineThrough(points, x, y, box) {
  let path = "";
  let open = false;
  for (const [at, value] of points) {
    const known = value !== null && Number.isFinite(value);
    if (known) {
      const right = placeOn(x, at, box.left, box.left + box.width);
      const up = placeOn(y, value, box.top + box.height, box.top);
      path += `${open ? "L" : "M"}${right.toFixed(1)} ${up.toFixed(1)}`;
    }
    open = known;
  }
  return path;
}
