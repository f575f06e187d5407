/**
 * The strip of all generations, oldest first, with arcs from each to the one that it was bred from.
 *
 * @import { Outline } from "../../model.js"
 */
import { effect } from "../../vendor/signals-core.js";
import { pin } from "../../compare/ab.js";
import { visit } from "../../lineage/generations.js";
import { modelsInWords, modelsOf } from "../../lineage/layers.js";
import { centreOf, lineageStore } from "../../lineage/store.js";
import { Pin } from "../compare/ab.js";
import { html } from "../html.js";
import { isPlain } from "../keys.js";
import { ServerPicture } from "../picture.js";
import { viewStore } from "../store.js";

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

/** Columns that are drawn beyond each end of the visible part, and steps in which they change. */
const MARGIN = 12;
const GRAIN = 6;

/** Generation and column that was scrolled to; the column changes while a history is read. */
let scrolledTo = { id: /** @type {string|null} */ (null), column: -1 };

/** Pixels from one column to the next. @param {HTMLElement} strip */
const stepOf = (strip) => STEP * (Number(getComputedStyle(strip).getPropertyValue("--scale")) || 1);

/** Draws the columns around the visible part. @param {HTMLElement} strip */
function followScroll(strip) {
  const step = stepOf(strip);
  const from = Math.floor(strip.scrollLeft / step / GRAIN) * GRAIN - MARGIN;
  const to = Math.ceil((strip.scrollLeft + strip.clientWidth) / step / GRAIN) * GRAIN + MARGIN;
  const known = viewStore.stripColumns.peek();
  if (known.from !== from || known.to !== to) viewStore.stripColumns.value = { from, to };
}

/** Observes the size of the strip. @type {ResizeObserver|null} */
let observer = null;

/** Ref of the strip: draws other columns when its size changes. @param {HTMLElement|null} strip */
function observe(strip) {
  if (!strip) return;
  observer?.disconnect();
  observer = new ResizeObserver(() => followScroll(strip));
  observer.observe(strip);
}

/** Scrolls the strip to the shown generation, once for each place. */
function scrollToShown() {
  const strip = /** @type {HTMLElement|null} */ (document.querySelector(".strip"));
  const id = lineageStore.shownId.peek();
  if (!strip) return;
  const column = lineageStore.descent.peek().inOrder.findIndex((one) => one.id === id);
  if (column < 0 || (id === scrolledTo.id && column === scrolledTo.column)) return;
  scrolledTo = { id, column };
  const step = stepOf(strip);
  strip.scrollTo({ left: (column + SIDE / STEP / 2) * step - strip.clientWidth / 2 });
  followScroll(strip);
}

/** Follows the shown generation, once the strip has its length. */
export const watchStrip = () => effect(() => {
  void [lineageStore.shownId.value, lineageStore.descent.value];
  requestAnimationFrame(scrollToShown);
});

/** Scrolls the strip sideways by a vertical wheel. @param {WheelEvent} event */
function scrollSideways(event) {
  const strip = /** @type {HTMLElement} */ (event.currentTarget);
  if (event.deltaX !== 0 || event.ctrlKey || strip.scrollWidth <= strip.clientWidth) return;
  event.preventDefault();
  strip.scrollBy({ left: event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1), behavior: "instant" });
}

/** @param {{of: Outline, column: number, count: number, onPath: boolean}} props */
function Stop({ of, column, count, onPath }) {
  const now = of.id === lineageStore.shownId.value;
  const standing = centreOf(of);
  const picture = standing?.thumbnail;
  const compare = () => standing && pin(standing, `The centre of generation ${of.index}`);
  return html`
    <li style=${{ left: scaled(column * STEP) }} aria-setsize=${count} aria-posinset=${column + 1} onKeyDown=${(/** @type {KeyboardEvent} */ event) => isPlain(event, "b") && compare()}>
      <button type="button" data-generation=${of.id} data-testid=${`history-${of.index}`} class=${onPath ? "stop on" : "stop"}
        aria-label=${`Generation ${of.index}`} aria-current=${now ? "true" : undefined} title=${[`generation ${of.index}`, standing && modelsInWords(modelsOf(standing))].filter(Boolean).join(": ")} onClick=${() => visit(of.id)}>
        ${picture && html`<${ServerPicture} url=${picture} lazy />`}
      </button>
      ${standing && html`<${Pin} name=${`generation ${of.index}`} onClick=${compare} />`}
    </li>
  `;
}

/** The strip; draws only what is near its visible part, because a history may be long. */
export function Strip() {
  const { all, path, every } = lineageStore.strip.value;
  const width = Math.max(0, all.length * STEP - (STEP - SIDE));
  const { from, to } = viewStore.stripColumns.value;
  const first = Math.max(0, from);
  return html`
    <nav class="strip" aria-label="History" data-testid="history" ref=${observe} onWheel=${scrollSideways} onScroll=${(/** @type {Event} */ event) => followScroll(/** @type {HTMLElement} */ (event.currentTarget))}>
      <div class="track" style=${{ width: scaled(width) }}>
        <svg aria-hidden="true" viewBox=${`0 0 ${width} ${SIDE + ARC}`} style=${{ width: scaled(width), height: scaled(SIDE + ARC) }}>
          ${every.filter((link) => link.to >= from && link.from <= to).map((link) => html`<${Link} key=${link.id} ...${link} />`)}
        </svg>
        <ol>${all.slice(first, to + 1).map((of, order) => html`<${Stop} key=${of.id} of=${of} column=${first + order} count=${all.length} onPath=${path.has(of.id)} />`)}</ol>
      </div>
    </nav>
  `;
}
