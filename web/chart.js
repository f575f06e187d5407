/**
 * The geometry of a line chart: round ticks, places on the paper, paths. Pure functions; knows nothing of what is charted.
 *
 * @typedef {{low: number, high: number, ticks: number[], log?: boolean}} Axis
 * @typedef {{left: number, top: number, width: number, height: number}} Box
 * @typedef {[number, number|null]} Point a value, and nothing where it is no number
 */

/** Steps that people count in. */
const STEPS = [1, 2, 2.5, 5, 10];

/** An axis from 0 with about so many round ticks, that reaches the largest value. @param {number} largest @param {number} about @returns {Axis} */
export function axisTo(largest, about) {
  const most = Number.isFinite(largest) && largest > 0 ? largest : 1;
  const rough = most / about;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = (STEPS.find((one) => one * power >= rough * (1 - 1e-9)) ?? 10) * power;
  const count = Math.ceil(most / step - 1e-9);
  // Sums of tenths are no tenths; twelve digits are.
  const ticks = Array.from({ length: count + 1 }, (_, at) => Number((at * step).toPrecision(12)));
  return { low: 0, high: ticks[count], ticks };
}

/** A line falls by so much at most before it lies on an axis of decades. */
const FALL = 1000;
/** About so many decades have a tick. */
const DECADES = 7;

/** An axis of powers of ten around some lines, without what is 0 and what is far below the rest of its line. @param {Point[][]} lines @returns {Axis} */
export function axisOfDecades(lines) {
  const shown = lines.flatMap((line) => {
    const top = largestOf([line]);
    return line.flatMap(([, y]) => (y !== null && y > top / FALL ? [y] : []));
  });
  const [least, most] = shown.length > 0 ? [Math.min(...shown), Math.max(...shown)] : [1, 1];
  const low = Math.floor(Math.log10(least) + 1e-9);
  const decades = Math.max(1, Math.ceil(Math.log10(most) - low - 1e-9));
  const step = Math.ceil(decades / DECADES);
  const ticks = Array.from({ length: Math.ceil(decades / step) + 1 }, (_, at) => 10 ** (low + at * step));
  return { low: ticks[0], high: ticks[ticks.length - 1], ticks, log: true };
}

/** Lines so far apart that one axis from 0 shows the highest alone. */
const APART = 25;

/** Whether some line would lie on the axis. @param {Point[][]} lines */
export function areFarApart(lines) {
  const tops = lines.map((line) => largestOf([line])).filter((top) => top > 0);
  return tops.length > 1 && Math.max(...tops) > APART * Math.min(...tops);
}

/** The largest value of some lines; 0 where there is none. @param {Point[][]} lines */
export const largestOf = (lines) => lines.flat().reduce((most, [, y]) => (y !== null && Number.isFinite(y) && y > most ? y : most), 0);

/** Where a value lies between two ends of the paper. @param {Axis} axis @param {number} value @param {number} from @param {number} to */
export function placeOn({ low, high, log }, value, from, to) {
  // What lies below an axis of decades, 0 above all, lies on it.
  const share = log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
  return from + share * (to - from);
}

/** A line as an SVG path; it breaks where a value is no number. @param {Point[]} points @param {Axis} x @param {Axis} y @param {Box} box */
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
