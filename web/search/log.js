/**
 * Log of a search: lines of the log and of events in one order, thinned for charts.
 *
 * @import { LogLine } from "../model.js"
 */

/** Largest number of points of a chart; more would not be visible. */
const DRAWN = 300;

/**
 * Merges lines by generation, field by field: an event replaces only the fields that it has.
 * @param {LogLine[]} known in order
 * @param {LogLine[]} news in any order
 * @returns {LogLine[]}
 */
export function mergeLines(known, news) {
  if (news.length === 0) return known;
  const last = known.at(-1)?.generation ?? 0;
  const follows = news.every((line, at) => line.generation > (news[at - 1]?.generation ?? last));
  if (follows) return [...known, ...news];
  const all = new Map(known.map((line) => [line.generation, line]));
  for (const line of news) all.set(line.generation, { ...all.get(line.generation), ...line });
  return [...all.values()].sort((a, b) => a.generation - b.generation);
}

/**
 * Line of a progress event; none before the first generation.
 * @param {{generation: number, evaluations: number, seconds: number, fitted: number|null, held:
 *   number|null}} event
 * @returns {LogLine[]}
 */
export function progressLine({ generation, evaluations, seconds, fitted, held }) {
  return generation > 0 ? [{ generation, evaluations, seconds, fitted, held }] : [];
}

/**
 * Thins a list evenly, keeping its first and last item.
 * @template T
 * @param {T[]} lines
 * @param {number} [most]
 */
export function thinLines(lines, most = DRAWN) {
  if (lines.length <= most) return lines;
  const step = (lines.length - 1) / (most - 1);
  return Array.from({ length: most }, (_, at) => lines[Math.round(at * step)]);
}
