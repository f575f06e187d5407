/**
 * A line chart: labelled axes, one line for each material, a legend. Owns its look; the geometry is chart.js's.
 *
 * @import { Axis, Box, Point } from "../chart.js"
 */
import { areFarApart, axisOfDecades, axisTo, largestOf, lineThrough, placeOn } from "../chart.js";
import { html } from "../html.js";
import { signal } from "../vendor/signals-core.js";
import { Choice } from "./control.js";
import { amount, decade } from "./words.js";

export const WIDTH = 420;
export const HEIGHT = 268;
/** What is around it is for labels. @type {Box} */
export const BOX = { left: 62, top: 10, width: 348, height: 212 };
export const BOTTOM = BOX.top + BOX.height;
export const RIGHT = BOX.left + BOX.width;
/** @type {Axis} */
const ANGLE = { low: 0, high: 90, ticks: [0, 15, 30, 45, 60, 75, 90] };
const degrees = (/** @type {number} */ value) => `${value}°`;
const TICKS = 5;
const SCALES = [{ value: "linear", name: "linear" }, { value: "log", name: "log" }];

/** The scale that a person chose for a chart. @type {import("../vendor/signals-core.js").Signal<Record<string, string>>} */
const scales = signal({});

/** How a value stands beside its tick. @param {Axis} axis */
const plainly = ({ log }) => (/** @type {number} */ value) => (log ? decade(value) : amount(value));

/** @typedef {{axis: Axis, name?: string, says?: (value: number) => string}} Side */

/** Ticks, their numbers, and what they are of. @param {{x: Side, y: Side}} props */
export const Grid = ({ x, y }) => html`
  <g class="grid" aria-hidden="true">
    ${y.axis.ticks.map((value) => {
      const up = placeOn(y.axis, value, BOTTOM, BOX.top);
      return html`<path key=${`y${value}`} d=${`M${BOX.left} ${up.toFixed(1)}H${RIGHT}`} /><text class="end" x=${BOX.left - 6} y=${up + 4}>${(y.says ?? plainly(y.axis))(value)}</text>`;
    })}
    ${x.axis.ticks.map((value) => {
      const right = placeOn(x.axis, value, BOX.left, RIGHT);
      return html`<path key=${`x${value}`} d=${`M${right.toFixed(1)} ${BOTTOM}v4`} /><text x=${right} y=${BOTTOM + 17}>${(x.says ?? plainly(x.axis))(value)}</text>`;
    })}
    <text class="title" x=${BOX.left + BOX.width / 2} y=${HEIGHT - 6}>${x.name}</text>
    ${y.name && html`<text class="title" transform=${`translate(11 ${BOX.top + BOX.height / 2}) rotate(-90)`}>${y.name}</text>`}
  </g>
`;

/** Which line is whose. @param {{names: string[]}} props */
export const Legend = ({ names }) => html`
  <figcaption class="legend">
    ${names.map((name, order) => html`<span key=${order} class=${`curve-${order}`}><svg viewBox="0 0 26 4" aria-hidden="true"><path class="curve" d="M0 2H26" /></svg> <span>${name}</span></span>`)}
  </figcaption>
`;

/** @param {{id: string, title: string, words: string, axis: string, names: string[], lines: Point[][]}} props */
export function Chart({ id, title, words, axis, names, lines }) {
  const scale = scales.value[id] ?? (areFarApart(lines) ? "log" : "linear");
  const y = scale === "log" ? axisOfDecades(lines) : axisTo(largestOf(lines), TICKS);
  const at = (/** @type {Point|undefined} */ point) => (point ? `${amount(point[1], 2)} at ${point[0]}°` : "nothing");
  const told = names.map((name, order) => `${name}: ${at(lines[order][0])}, ${at(lines[order].at(-1))}`);
  return html`
    <figure class="chart" data-testid=${id}>
      <h3>${title}</h3>
      <p class="small">${words}</p>
      <svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label=${`${title}, by angle of incidence. ${told.join("; ")}.`}>
        <${Grid} x=${{ axis: ANGLE, name: "angle of incidence", says: degrees }} y=${{ axis: y, name: axis }} />
        ${lines.map((points, order) => html`<path key=${order} class=${`curve curve-${order}`} d=${lineThrough(points, ANGLE, y, BOX)} />`)}
      </svg>
      <${Legend} names=${names} />
      <${Choice} id=${`${id}-scale`} name=${`Scale: ${title}`} value=${scale} options=${SCALES} turns=${(/** @type {string} */ to) => (scales.value = { ...scales.value, [id]: to })} />
    </figure>
  `;
}
