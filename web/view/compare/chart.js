/**
 * A line chart: labelled axes, one line per material, a legend.
 *
 * @import { Axis, Box, Point } from "../../page/chart.js"
 */
import {
  areFarApart, axisOfDecades, axisTo, largestOf, lineThrough, placeOn,
} from "../../page/chart.js";
import { amount, decade } from "../../page/format.js";
import { Choice } from "../control.js";
import { html } from "../html.js";
import { viewStore } from "../store.js";

export const WIDTH = 420;
export const HEIGHT = 268;
/** The plotting area; labels go around it. @type {Box} */
export const BOX = { left: 62, top: 10, width: 348, height: 212 };
export const BOTTOM = BOX.top + BOX.height;
export const RIGHT = BOX.left + BOX.width;
/** @type {Axis} */
const ANGLE = { low: 0, high: 90, ticks: [0, 15, 30, 45, 60, 75, 90] };
const degrees = (/** @type {number} */ value) => `${value}°`;
const TICKS = 5;
const SCALES = [{ value: "linear", name: "linear" }, { value: "log", name: "log" }];

/** Label of a tick. @param {Axis} axis */
const plainly = ({ log }) => (/** @type {number} */ value) => (log ? decade(value) : amount(value));

/** @typedef {{axis: Axis, name?: string, format?: (value: number) => string}} Side */

/**
 * Grid lines, ticks with their labels, and titles of the axes.
 * @param {{x: Side, y: Side}} props
 */
export const Grid = ({ x, y }) => html`
  <g class="grid" aria-hidden="true">
    ${y.axis.ticks.map((value) => {
      const up = placeOn(y.axis, value, BOTTOM, BOX.top);
      return html`<path key=${`y${value}`} d=${`M${BOX.left} ${up.toFixed(1)}H${RIGHT}`} /><text class="end" x=${BOX.left - 6} y=${up + 4}>${(y.format ?? plainly(y.axis))(value)}</text>`;
    })}
    ${x.axis.ticks.map((value) => {
      const right = placeOn(x.axis, value, BOX.left, RIGHT);
      return html`<path key=${`x${value}`} d=${`M${right.toFixed(1)} ${BOTTOM}v4`} /><text x=${right} y=${BOTTOM + 17}>${(x.format ?? plainly(x.axis))(value)}</text>`;
    })}
    <text class="title" x=${BOX.left + BOX.width / 2} y=${HEIGHT - 6}>${x.name}</text>
    ${y.name && html`<text class="title" transform=${`translate(11 ${BOX.top + BOX.height / 2}) rotate(-90)`}>${y.name}</text>`}
  </g>
`;

/** Legend of the lines. @param {{names: string[]}} props */
export const Legend = ({ names }) => html`
  <figcaption class="legend">
    ${names.map((name, order) => html`<span key=${order} class=${`curve-${order}`}><svg viewBox="0 0 26 4" aria-hidden="true"><path class="curve" d="M0 2H26" /></svg> <span>${name}</span></span>`)}
  </figcaption>
`;

/**
 * @param {{id: string, title: string, words: string, axis: string, names: string[], lines:
 *   Point[][]}} props
 */
export function Chart({ id, title, words, axis, names, lines }) {
  const scale = viewStore.chartScales.value[id] ?? (areFarApart(lines) ? "log" : "linear");
  const y = scale === "log" ? axisOfDecades(lines) : axisTo(largestOf(lines), TICKS);
  const at = (/** @type {Point|undefined} */ point) => (point ? `${amount(point[1], 2)} at ${point[0]}°` : "nothing");
  const ends = names.map((name, order) => `${name}: ${at(lines[order][0])}, ${at(lines[order].at(-1))}`);
  return html`
    <figure class="chart" data-testid=${id}>
      <h3>${title}</h3>
      <p class="small">${words}</p>
      <svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label=${`${title}, by angle of incidence. ${ends.join("; ")}.`}>
        <${Grid} x=${{ axis: ANGLE, name: "angle of incidence", format: degrees }} y=${{ axis: y, name: axis }} />
        ${lines.map((points, order) => html`<path key=${order} class=${`curve curve-${order}`} d=${lineThrough(points, ANGLE, y, BOX)} />`)}
      </svg>
      <${Legend} names=${names} />
      <${Choice} id=${`${id}-scale`} name=${`Scale: ${title}`} value=${scale} options=${SCALES} onInput=${(/** @type {string} */ to) => (viewStore.chartScales.value = { ...viewStore.chartScales.value, [id]: to })} />
    </figure>
  `;
}
