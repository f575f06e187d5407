/**
 * Geometry of a search's charts: axes of errors, and selection of points on a front.
 *
 * @import { Axis, Point } from "../page/chart.js"
 * @import { Found, LogLine } from "../model.js"
 */
import { axisTo } from "../page/chart.js";
import { thinLines } from "./log.js";

const STEPS = [1, 2, 5];
/** Number of ticks beyond which only powers of ten are labelled. */
const MANY = 7;

/**
 * Steps 1, 2, 5, 10, ... around some numbers, with one step beyond at either end.
 * @param {number} least
 * @param {number} most
 */
function stepsAround(least, most) {
  const found = [];
  for (
    let power = Math.floor(Math.log10(least)) - 1;
    power <= Math.ceil(Math.log10(most)) + 1;
    power += 1
  ) {
    // Parsed, because a product of powers of ten is not always the nearest number.
    for (const step of STEPS) found.push(Number(`${step}e${power}`));
  }
  const from = found.findLastIndex((one) => one <= least);
  const to = found.findIndex((one) => one >= most);
  return found.slice(from, Math.max(to, from + 1) + 1);
}

/**
 * Logarithmic axis around errors; from 0.1 to 1 if there are none.
 * @param {(number|null|undefined)[]} errors
 * @returns {Axis}
 */
export function axisOfErrors(errors) {
  const known = errors.filter(
    /** @returns {one is number} */ (one) =>
      typeof one === "number" && Number.isFinite(one) && one > 0,
  );
  const steps =
    known.length > 0 ? stepsAround(Math.min(...known), Math.max(...known)) : [0.1, 0.2, 0.5, 1];
  const decades = steps.filter((one) => Number.isInteger(Number(Math.log10(one).toFixed(9))));
  const every = Math.ceil(decades.length / MANY);
  const ticks = steps.length <= MANY ? steps : decades.filter((_, at) => at % every === 0);
  return { low: steps[0], high: /** @type {number} */ (steps.at(-1)), ticks, log: true };
}

/**
 * Both errors over time or generations.
 * @param {LogLine[]} lines
 * @param {"seconds"|"generation"} over
 * @returns {{fitted: Point[], held: Point[], x: Axis, y: Axis}}
 */
export function courseOf(lines, over) {
  const shown = thinLines(lines);
  const y = axisOfErrors(shown.flatMap(({ fitted, held }) => [fitted, held]));
  const x = axisTo(shown.at(-1)?.[over] ?? 0, 5);
  /** @param {"fitted"|"held"} of @returns {Point[]} */
  const points = (of) =>
    shown.map((line) => {
      const error = line[of] ?? 0;
      return [line[over], error > 0 ? error : null];
    });
  return { fitted: points("fitted"), held: points("held"), x, y };
}

/** Sorts results by number of operations. @param {Found[]} front */
export const byOperations = (front) =>
  [...front].sort((a, b) => a.operations - b.operations || a.e_log - b.e_log);

/**
 * Ratio of shortest to longest above which an axis from 0 would squeeze all points into a corner.
 */
const NARROW = 0.4;

/** Axis of numbers of operations. @param {number[]} lengths @returns {Axis} */
export function axisOfLengths(lengths) {
  const [least, most] = [Math.min(...lengths), Math.max(...lengths)];
  if (lengths.length === 0 || least === most || least < NARROW * most)
    return axisTo(Math.max(0, ...lengths), 5);
  const [, step] = axisTo(most - least, 4).ticks;
  const whole = Math.max(1, Math.round(step));
  const from = Math.floor(least / whole);
  const ticks = Array.from(
    { length: Math.ceil(most / whole) - from + 1 },
    (_, at) => (from + at) * whole,
  );
  return { low: ticks[0], high: ticks[ticks.length - 1], ticks };
}

/** Results with a smaller error than every shorter one. @param {Found[]} front by operations */
export function leadersOf(front) {
  let least = Infinity;
  return front.filter(({ e_log }) => {
    const leads = e_log < least;
    least = Math.min(least, e_log);
    return leads;
  });
}

/**
 * Index of the next result in the direction of a key; null for other keys.
 * @param {Found[]} front by operations
 * @param {number} at
 * @param {string} key
 */
export function stepOn(front, at, key) {
  const last = front.length - 1;
  const to = {
    ArrowRight: at + 1,
    ArrowDown: at + 1,
    ArrowLeft: at - 1,
    ArrowUp: at - 1,
    Home: 0,
    End: last,
  }[key];
  return to === undefined ? null : Math.max(0, Math.min(last, to));
}

/**
 * Index of the nearest point within reach; -1 if there is none.
 * @param {[number, number][]} places
 * @param {[number, number]} to
 * @param {number} reach
 */
export function nearestTo(places, [x, y], reach) {
  const distances = places.map(([right, up]) => Math.hypot(right - x, up - y));
  const least = Math.min(reach, ...distances);
  return distances.findIndex((one) => one === least);
}
