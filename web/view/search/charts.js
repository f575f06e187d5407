/**
 * Charts of a search: errors over time, and the front of error against length.
 *
 * @import { Found, LogLine } from "../../model.js"
 */
import { lineThrough, placeOn } from "../../page/chart.js";
import {
  axisOfErrors, axisOfLengths, byOperations, courseOf, leadersOf, nearestTo, stepOn,
} from "../../search/chart.js";
import { counted, duration, errorInWords } from "../../search/words.js";
import { BOTTOM, BOX, Grid, HEIGHT, Legend, RIGHT, WIDTH } from "../compare/chart.js";
import { Choice } from "../control.js";
import { html } from "../html.js";
import { viewStore } from "../store.js";

const OVERS = [{ value: "seconds", name: "seconds" }, { value: "generation", name: "generations" }];

/**
 * Errors over time or generations.
 * @param {{lines: LogLine[], placeholder: string}} props `placeholder`: text before the first line
 */
export function Course({ lines, placeholder }) {
  const { fitted, held, x, y } = courseOf(lines, viewStore.errorAxis.value);
  const last = lines.at(-1);
  const words = last
    ? `Errors over ${viewStore.errorAxis.value === "seconds" ? "time" : "generations"}: after ${counted(last.generation, "generation")} and ${duration(last.seconds)} the training error is ${errorInWords(last.fitted)}, the validation error ${errorInWords(last.held)}.`
    : placeholder;
  return html`
    <figure class="chart" data-testid="search-course">
      <div class="row"><h3 class="grow" title="Training: samples on which fits minimise the error. Validation: samples by which the search chooses between fits.">E log of the best</h3><${Choice} id="search-over" name="Error over" value=${viewStore.errorAxis.value} options=${OVERS} onInput=${(/** @type {any} */ to) => (viewStore.errorAxis.value = to)} /></div>
      ${lines.length === 0
        ? html`<p class="small hollow">${placeholder}</p>`
        : html`<svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label=${words}>
            <${Grid} x=${{ axis: x, name: viewStore.errorAxis.value === "seconds" ? "seconds searched" : "generations" }} y=${{ axis: y, format: errorInWords }} />
            ${[fitted, held].map((points, order) => html`<path key=${order} class=${`curve curve-${order}`} d=${lineThrough(points, x, y, BOX)} />`)}
            ${lines.length === 1 && [fitted, held].map(([[at, value]], order) => value !== null && html`<circle key=${`only${order}`} class=${`only curve-${order}`} r="2.5" cx=${placeOn(x, at, BOX.left, RIGHT)} cy=${placeOn(y, value, BOTTOM, BOX.top)} />`)}
          </svg>
          <${Legend} names=${[`training ${errorInWords(last?.fitted)}`, `validation ${errorInWords(last?.held)}`]} />`}
    </figure>
  `;
}

/** @param {Found[]} front @param {(of: Found) => void} onPick */
const onKey = (front, onPick) => (/** @type {KeyboardEvent} */ event) => {
  const element = /** @type {SVGElement} */ (event.target);
  const to = stepOn(front, Number(element.dataset.at ?? -1), event.key);
  if (to === null || element.dataset.at === undefined) return;
  event.preventDefault();
  onPick(front[to]);
  const next = element.parentElement?.querySelector(`[data-at="${to}"]`);
  if (next instanceof SVGElement) next.focus();
};

/** Distance from a point within which a click selects it. */
const REACH = 22;

/**
 * Position of a click in the coordinates of the chart.
 * @param {MouseEvent} event
 * @returns {[number, number]}
 */
function onPaper(event) {
  const { left, top, width } = /** @type {SVGElement} */ (event.currentTarget).getBoundingClientRect();
  const scale = WIDTH / width;
  return [(event.clientX - left) * scale, (event.clientY - top) * scale];
}

/**
 * Error against length; each point is a result that can be chosen.
 * @param {{of: Found[], chosen: Found|null, onPick: (of: Found) => void}} props
 */
export function FrontChart({ of, chosen, onPick }) {
  const front = byOperations(of);
  const x = axisOfLengths(front.map(({ operations }) => operations));
  const y = axisOfErrors(front.map(({ e_log }) => e_log));
  const best = of[0];
  const places = front.map(({ operations, e_log }) => /** @type {[number, number]} */ ([placeOn(x, operations, BOX.left, RIGHT), placeOn(y, e_log, BOTTOM, BOX.top)]));
  const line = lineThrough(leadersOf(front).map(({ operations, e_log }) => [operations, e_log]), x, y, BOX);
  const onClick = (/** @type {MouseEvent} */ event) => {
    const at = nearestTo(places, onPaper(event), REACH);
    if (at >= 0) onPick(front[at]);
  };
  return html`
    <svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} class="front" role="radiogroup" aria-label="Front: error against operations" onKeyDown=${onKey(front, onPick)} onClick=${onClick}>
      <${Grid} x=${{ axis: x, name: "operations a sample" }} y=${{ axis: y, format: errorInWords }} />
      <path class="steps" d=${line} aria-hidden="true" />
      ${front.map((one, at) => {
        const on = one.individual === chosen?.individual;
        const [right, up] = places[at];
        return html`
          <g key=${one.individual} class=${on ? "point on" : "point"} role="radio" aria-checked=${on} tabindex=${on ? 0 : -1} data-at=${at} data-testid=${`front-${at}`}
            aria-label=${`Error ${errorInWords(one.e_log)}, ${counted(one.operations, "operation")}${one === best ? ", the best" : ""}`}>
            <circle class="reach" cx=${right} cy=${up} r="10" /><circle class="seen" cx=${right} cy=${up} r=${on ? 6 : 4} />
          </g>`;
      })}
    </svg>
  `;
}
