/**
 * A search's two charts: how its errors fell, and the front of error against length. Owns their look; the geometry is
 * search_chart.js's and chart.js's.
 *
 * @import { Found, LogLine } from "../types.js"
 */
import { lineThrough, placeOn } from "../chart.js";
import { html } from "../html.js";
import { axisOfErrors, axisOfLengths, byOperations, courseOf, leadersOf, nearestTo, stepOn } from "../search_chart.js";
import { counted, duration, errorInWords } from "../search_words.js";
import { signal } from "../vendor/signals-core.js";
import { BOTTOM, BOX, Grid, HEIGHT, Legend, RIGHT, WIDTH } from "./chart.js";
import { Choice } from "./control.js";

const OVERS = [{ value: "seconds", name: "seconds" }, { value: "generation", name: "generations" }];

/** @type {import("../vendor/signals-core.js").Signal<"seconds"|"generation">} */
const over = signal("seconds");

/** How the errors fell. @param {{lines: LogLine[], waits: string}} props `waits`: what is said before there is a line */
export function Course({ lines, waits }) {
  const { fitted, held, x, y } = courseOf(lines, over.value);
  const last = lines.at(-1);
  const words = last
    ? `Errors over ${over.value === "seconds" ? "time" : "generations"}: after ${counted(last.generation, "generation")} and ${duration(last.seconds)} ${errorInWords(last.fitted)} fitted, ${errorInWords(last.held)} held back.`
    : waits;
  return html`
    <figure class="chart" data-testid="search-course">
      <div class="row"><h3 class="grow">E log of the best</h3><${Choice} id="search-over" name="Error over" value=${over.value} options=${OVERS} turns=${(/** @type {any} */ to) => (over.value = to)} /></div>
      ${lines.length === 0
        ? html`<p class="small hollow">${waits}</p>`
        : html`<svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label=${words}>
            <${Grid} x=${{ axis: x, name: over.value === "seconds" ? "seconds searched" : "generations" }} y=${{ axis: y, says: errorInWords }} />
            ${[fitted, held].map((points, order) => html`<path key=${order} class=${`curve curve-${order}`} d=${lineThrough(points, x, y, BOX)} />`)}
            ${lines.length === 1 && [fitted, held].map(([[at, value]], order) => value !== null && html`<circle key=${`only${order}`} class=${`only curve-${order}`} r="2.5" cx=${placeOn(x, at, BOX.left, RIGHT)} cy=${placeOn(y, value, BOTTOM, BOX.top)} />`)}
          </svg>
          <${Legend} names=${[`fitted ${errorInWords(last?.fitted)}`, `held back ${errorInWords(last?.held)}`]} />`}
    </figure>
  `;
}

/** @param {Found[]} front @param {(of: Found) => void} picks */
const onKey = (front, picks) => (/** @type {KeyboardEvent} */ event) => {
  const element = /** @type {SVGElement} */ (event.target);
  const to = stepOn(front, Number(element.dataset.at ?? -1), event.key);
  if (to === null || element.dataset.at === undefined) return;
  event.preventDefault();
  picks(front[to]);
  const next = element.parentElement?.querySelector(`[data-at="${to}"]`);
  if (next instanceof SVGElement) next.focus();
};

/** So far from a point a click still means it. */
const REACH = 22;

/** Where a click is on the paper of a chart. @param {MouseEvent} event @returns {[number, number]} */
function onPaper(event) {
  const { left, top, width } = /** @type {SVGElement} */ (event.currentTarget).getBoundingClientRect();
  const scale = WIDTH / width;
  return [(event.clientX - left) * scale, (event.clientY - top) * scale];
}

/**
 * Error against length: each point is a find that can be chosen.
 * @param {{of: Found[], chosen: Found|null, picks: (of: Found) => void}} props
 */
export function FrontChart({ of, chosen, picks }) {
  const front = byOperations(of);
  const x = axisOfLengths(front.map(({ operations }) => operations));
  const y = axisOfErrors(front.map(({ e_log }) => e_log));
  const best = of[0];
  const places = front.map(({ operations, e_log }) => /** @type {[number, number]} */ ([placeOn(x, operations, BOX.left, RIGHT), placeOn(y, e_log, BOTTOM, BOX.top)]));
  const line = lineThrough(leadersOf(front).map(({ operations, e_log }) => [operations, e_log]), x, y, BOX);
  const onClick = (/** @type {MouseEvent} */ event) => {
    const at = nearestTo(places, onPaper(event), REACH);
    if (at >= 0) picks(front[at]);
  };
  return html`
    <svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} class="front" role="radiogroup" aria-label="Front: error against operations" onKeyDown=${onKey(front, picks)} onClick=${onClick}>
      <${Grid} x=${{ axis: x, name: "operations a sample" }} y=${{ axis: y, says: errorInWords }} />
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
