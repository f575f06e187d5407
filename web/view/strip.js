/**
 * The strip of all generations, oldest first, with arcs from each to where it was bred from. Owns the drawing; the order is
 * history.js's. Nothing in the strip ever goes away.
 *
 * @import { Generation } from "../types.js"
 */
import { pin } from "../compare.js";
import { html } from "../html.js";
import { ancestry, links } from "../history.js";
import { isPlain } from "../keys.js";
import { modelsInWords, modelsOf } from "../layers.js";
import { visit } from "../lineage.js";
import { descent, largeOf, shown } from "../state.js";
import { Pin } from "./compare.js";

/** Distance of two pictures, their side, and the height of the arcs below, in CSS pixels: as in stage.css. */
const STEP = 72;
const SIDE = 52;
const ARC = 18;

/** That many pixels, larger on a larger screen. @param {number} px */
const times = (px) => `calc(${px}px * var(--scale))`;

/** @param {{from: number, to: number, onPath: boolean}} link */
function Link({ from, to, onPath }) {
  const x = (/** @type {number} */ column) => column * STEP + SIDE / 2;
  const low = SIDE + ARC * Math.min(1, 0.4 + (to - from) / 12);
  const path = to === from + 1
    ? `M ${x(from) + SIDE / 2} ${SIDE / 2} H ${x(to) - SIDE / 2}`
    : `M ${x(from)} ${SIDE} C ${x(from)} ${low}, ${x(to)} ${low}, ${x(to)} ${SIDE}`;
  return html`<path class=${onPath ? "on" : ""} d=${path} />`;
}

/** @type {string|null} */
let scrolledTo = null;

/** Brings the shown generation into sight, once. @param {HTMLElement|null} element */
function seen(element) {
  const id = element?.dataset.generation ?? null;
  if (!element || id === scrolledTo) return;
  scrolledTo = id;
  const strip = element.closest(".strip");
  if (!strip) return;
  const [stop, whole] = [element.getBoundingClientRect(), strip.getBoundingClientRect()];
  strip.scrollBy({ left: stop.left + stop.width / 2 - (whole.left + whole.width / 2) });
}

/** A wheel that turns up and down goes along the strip, which has no other way to go. @param {WheelEvent} event */
function along(event) {
  const strip = /** @type {HTMLElement} */ (event.currentTarget);
  if (event.deltaX !== 0 || event.ctrlKey || strip.scrollWidth <= strip.clientWidth) return;
  event.preventDefault();
  strip.scrollBy({ left: event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1), behavior: "instant" });
}

/** @param {{of: Generation, column: number, onPath: boolean}} props */
function Stop({ of, column, onPath }) {
  const now = of.id === shown.value;
  const standing = largeOf(of);
  const picture = standing?.thumbnail;
  const compare = () => standing && pin(standing, `The centre of generation ${of.index}`);
  return html`
    <li style=${{ left: times(column * STEP) }} onKeyDown=${(/** @type {KeyboardEvent} */ event) => isPlain(event, "b") && compare()}>
      <button type="button" ref=${now ? seen : undefined} data-generation=${of.id} data-testid=${`history-${of.index}`} class=${onPath ? "stop on" : "stop"}
        aria-label=${`Generation ${of.index}`} aria-current=${now ? "true" : undefined} title=${[`generation ${of.index}`, standing && modelsInWords(modelsOf(standing))].filter(Boolean).join(": ")} onClick=${() => visit(of.id)}>
        ${picture && html`<img src=${picture} alt="" loading="lazy" draggable=${false} />`}
      </button>
      ${standing && html`<${Pin} name=${`generation ${of.index}`} does=${compare} />`}
    </li>
  `;
}

/** What was drawn last: a long strip is not drawn again while only pictures arrive. @type {{of: unknown, now: unknown, view: unknown}} */
let last = { of: null, now: null, view: null };

export function Strip() {
  const of = descent.value;
  const now = shown.value;
  if (last.of !== of || last.now !== now) last = { of, now, view: draw(of, now) };
  return last.view;
}

/** @param {import("../history.js").Descent} descent @param {string|null} now */
function draw(descent, now) {
  const all = descent.inOrder;
  const path = ancestry(descent.parents, now);
  const width = Math.max(0, all.length * STEP - (STEP - SIDE));
  return html`
    <nav class="strip" aria-label="History" data-testid="history" onWheel=${along}>
      <div class="track" style=${{ width: times(width) }}>
        <svg aria-hidden="true" viewBox=${`0 0 ${width} ${SIDE + ARC}`} style=${{ width: times(width), height: times(SIDE + ARC) }}>
          ${links(descent, path).map((link) => html`<${Link} key=${link.id} ...${link} />`)}
        </svg>
        <ol>${all.map((of, column) => html`<${Stop} key=${of.id} of=${of} column=${column} onPath=${path.has(of.id)} />`)}</ol>
      </div>
    </nav>
  `;
}
