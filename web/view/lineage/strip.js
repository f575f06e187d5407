/**
 * The strip of all generations, oldest first, with arcs from each to the one that it was bred from.
 *
 * @import { Generation } from "../../model.js"
 */
import { pin } from "../../compare/ab.js";
import { visit } from "../../lineage/generations.js";
import { ancestry, links } from "../../lineage/history.js";
import { modelsInWords, modelsOf } from "../../lineage/layers.js";
import { centreOf, lineageStore } from "../../lineage/store.js";
import { Pin } from "../compare/ab.js";
import { html } from "../html.js";
import { isPlain } from "../keys.js";

/** Distance of two pictures, their side, and height of the arcs in CSS pixels, as in stage.css. */
const STEP = 72;
const SIDE = 52;
const ARC = 18;

/** Scales pixels with the screen. @param {number} px */
const scaled = (px) => `calc(${px}px * var(--scale))`;

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

/** Scrolls to the shown generation, once. @param {HTMLElement|null} element */
function scrollToOnce(element) {
  const id = element?.dataset.generation ?? null;
  if (!element || id === scrolledTo) return;
  scrolledTo = id;
  const strip = element.closest(".strip");
  if (!strip) return;
  const [stop, whole] = [element.getBoundingClientRect(), strip.getBoundingClientRect()];
  strip.scrollBy({ left: stop.left + stop.width / 2 - (whole.left + whole.width / 2) });
}

/** Scrolls the strip sideways by a vertical wheel. @param {WheelEvent} event */
function scrollSideways(event) {
  const strip = /** @type {HTMLElement} */ (event.currentTarget);
  if (event.deltaX !== 0 || event.ctrlKey || strip.scrollWidth <= strip.clientWidth) return;
  event.preventDefault();
  strip.scrollBy({ left: event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1), behavior: "instant" });
}

/** @param {{of: Generation, column: number, onPath: boolean}} props */
function Stop({ of, column, onPath }) {
  const now = of.id === lineageStore.shownId.value;
  const standing = centreOf(of);
  const picture = standing?.thumbnail;
  const compare = () => standing && pin(standing, `The centre of generation ${of.index}`);
  return html`
    <li style=${{ left: scaled(column * STEP) }} onKeyDown=${(/** @type {KeyboardEvent} */ event) => isPlain(event, "b") && compare()}>
      <button type="button" ref=${now ? scrollToOnce : undefined} data-generation=${of.id} data-testid=${`history-${of.index}`} class=${onPath ? "stop on" : "stop"}
        aria-label=${`Generation ${of.index}`} aria-current=${now ? "true" : undefined} title=${[`generation ${of.index}`, standing && modelsInWords(modelsOf(standing))].filter(Boolean).join(": ")} onClick=${() => visit(of.id)}>
        ${picture && html`<img src=${picture} alt="" loading="lazy" draggable=${false} />`}
      </button>
      ${standing && html`<${Pin} name=${`generation ${of.index}`} onClick=${compare} />`}
    </li>
  `;
}

export function Strip() {
  const descent = lineageStore.descent.value;
  const all = descent.inOrder;
  const path = ancestry(descent.parents, lineageStore.shownId.value);
  const width = Math.max(0, all.length * STEP - (STEP - SIDE));
  return html`
    <nav class="strip" aria-label="History" data-testid="history" onWheel=${scrollSideways}>
      <div class="track" style=${{ width: scaled(width) }}>
        <svg aria-hidden="true" viewBox=${`0 0 ${width} ${SIDE + ARC}`} style=${{ width: scaled(width), height: scaled(SIDE + ARC) }}>
          ${links(descent, path).map((link) => html`<${Link} key=${link.id} ...${link} />`)}
        </svg>
        <ol>${all.map((of, column) => html`<${Stop} key=${of.id} of=${of} column=${column} onPath=${path.has(of.id)} />`)}</ol>
      </div>
    </nav>
  `;
}
