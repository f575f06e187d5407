/**
 * The course of a search: lines of its log and of its events in one order, few enough to be drawn. Pure functions; knows nothing of
 * how they come here.
 *
 * @import { LogLine } from "./types.js"
 */

/** More points than a chart has pixels only cost time. */
const DRAWN = 300;

/**
 * Lines by generation, each once. What came later is better informed, but an event does not take away what the log knew.
 * @param {LogLine[]} known in order
 * @param {LogLine[]} news in any order
 * @returns {LogLine[]}
 */
export function merged(known, news) {
  if (news.length === 0) return known;
  const last = known.at(-1)?.generation ?? 0;
  const follows = news.every((line, at) => line.generation > (news[at - 1]?.generation ?? last));
  if (follows) return [...known, ...news];
  const all = new Map(known.map((line) => [line.generation, line]));
  for (const line of news) all.set(line.generation, { ...all.get(line.generation), ...line });
  return [...all.values()].sort((a, b) => a.generation - b.generation);
}

/**
 * The line that an event of progress tells; none before the first generation.
 * @param {{generation: number, evaluations: number, seconds: number, fitted: number|null, held: number|null}} event
 * @returns {LogLine[]}
 */
export function lineOf({ generation, evaluations, seconds, fitted, held }) {
  return generation > 0 ? [{ generation, evaluations, seconds, fitted, held }] : [];
}

/**
 * Some of many, evenly, with the first and the last.
 * @template T
 * @param {T[]} lines
 * @param {number} [most]
 */
export function thinned(lines, most = DRAWN) {
  if (lines.length <= most) return lines;
  const step = (lines.length - 1) / (most - 1);
  return Array.from({ length: most }, (_, at) => lines[Math.round(at * step)]);
}
