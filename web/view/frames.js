/**
 * The 6 x 6 grid: 20 frames around a centre of 4 x 4. Owns how individuals are shown; hands and keys are elsewhere.
 *
 * @import { Cell, Generation, Individual } from "../types.js"
 */
import { signal } from "../vendor/signals-core.js";
import { pictureUrl } from "../api.js";
import { nameOf, toggleFavourite } from "../breed.js";
import { listenToHands } from "../hands.js";
import { html } from "../html.js";
import { keyOnFrames, PLACES } from "../keys.js";
import { attachCanvas, liveCells } from "../live/live.js";
import { LightDot } from "./light.js";
import { attempts, failed, loaded, pictureFailed, pictureLoaded, ready, tryAgain } from "../pictures.js";
import { breeding, focused, generation, individualIn, lineage, mate, sceneBusy, shown, turning, scene } from "../state.js";
import { globe } from "../turn.js";

/** Side of the large picture on the screen, in device pixels. */
const largePx = signal(0);
/** The larger picture costs rays by its square; beyond this the gain is not seen. */
const LARGE_LIMIT_PX = 1024;

/** @type {ResizeObserver|null} */
let observer = null;

/** Called once with the element, and with null when it goes. @param {HTMLElement|null} element */
function attach(element) {
  if (!element) return;
  listenToHands(element);
  observer?.disconnect();
  observer = new ResizeObserver(([entry]) => {
    const px = (entry.contentRect.width / 6) * 4 * devicePixelRatio;
    largePx.value = Math.min(LARGE_LIMIT_PX, Math.max(64, Math.ceil(px / 64) * 64));
  });
  observer.observe(element);
}

/** @param {Cell} cell @param {Individual} of */
function label(cell, of) {
  const parts = [nameOf(cell), `${of.live_instructions} live instructions`];
  if (of.favourite) parts.push("favourite");
  if (of.twin) parts.push("twin of another");
  if (mate.value?.id === of.id) parts.push("mate");
  return parts.join(", ");
}

/**
 * @param {{of: Individual, cell: Cell}} props
 */
function Picture({ of, cell }) {
  const url = of.thumbnail;
  if (failed.value.has(url)) {
    return html`<button type="button" class="again" tabindex="-1" aria-label=${`Load the picture of ${nameOf(cell)} again`} onClick=${() => tryAgain(url)}>⟳</button>`;
  }
  return html`
    <img
      key=${attempts.value.get(url) ?? 0}
      data-frame=${cell}
      data-generation=${shown.value}
      class=${loaded.value.has(url) ? "" : "waiting"}
      src=${url}
      alt=""
      draggable=${false}
      onLoad=${() => pictureLoaded(url)}
      onError=${() => pictureFailed(url)}
    />
  `;
}

/** The centre at the size it is shown, once the frames have what they need. @param {{of: Individual}} props */
function Large({ of }) {
  const sceneId = lineage.value?.scene;
  const wanted = sceneId && ready.value === shown.value && largePx.value > (lineage.value?.thumbnail_px ?? 0);
  if (!wanted || breeding.value || sceneBusy.value) return null;
  const url = pictureUrl(of.id, sceneId, largePx.value);
  return html`
    <img key=${`${url} ${attempts.value.get(url) ?? 0}`} class=${loaded.value.has(url) ? "large" : "large waiting"} src=${url} alt="" draggable=${false}
      onLoad=${() => pictureLoaded(url)} onError=${() => pictureFailed(url)} />
  `;
}

/** What the hand is doing to the object, until the server has drawn it. */
function Globe() {
  const now = turning.value;
  const of = scene.value;
  if (!now || !of) return null;
  if (now.kind === "scale") return html`<p class="measure">× ${now.scale.toPrecision(3)}</p>`;
  return html`
    <svg class="globe" viewBox="-1.05 -1.05 2.1 2.1" aria-hidden="true">
      <circle r="1" />
      ${globe(now.rotation, of.camera).map((piece) => html`<polyline class=${piece.front ? "front" : "behind"} points=${piece.points} />`)}
    </svg>
  `;
}

/** @param {{cell: Cell}} props */
function Frame({ cell }) {
  const of = individualIn(cell);
  const centre = cell === "centre";
  const [row, column] = centre ? [1, 1] : PLACES[cell];
  const isMate = of !== null && mate.value?.id === of.id;
  const drawnLive = liveCells.value.has(cell);
  const scaled = !drawnLive && centre && scene.value && turning.value?.kind === "scale" ? turning.value.scale / scene.value.scale : 1;
  return html`
    <div
      role="gridcell"
      data-cell=${cell}
      data-testid=${centre ? "centre" : `cell-${cell}`}
      class=${`frame ${centre ? "centre" : ""} ${isMate ? "mated" : ""}`}
      tabindex=${focused.value === cell ? 0 : -1}
      aria-colindex=${column + 1}
      aria-rowspan=${centre ? 4 : undefined}
      aria-colspan=${centre ? 4 : undefined}
      aria-label=${of ? label(cell, of) : `${nameOf(cell)}, empty`}
      onFocus=${() => (focused.value = cell)}
    >
      ${of && html`
        <div class=${drawnLive ? "pictures lit" : "pictures"} style=${{ transform: scaled === 1 ? "" : `scale(${scaled})` }}>
          <${Picture} of=${of} cell=${cell} />
          ${centre && html`<${Large} of=${of} />`}
        </div>
        ${centre && !drawnLive && html`<${Globe} />`}
        ${centre && html`<${LightDot} />`}
        <button type="button" class=${of.favourite ? "star on" : "star"} data-testid="favourite" tabindex="-1" aria-pressed=${of.favourite}
          aria-label=${`Favourite: ${nameOf(cell)}`} title="Favourite (F)" onClick=${() => toggleFavourite(cell)}>${of.favourite ? "★" : "☆"}</button>
        ${isMate && html`<span class="badge" data-testid="mate-badge">mate</span>`}
      `}
    </div>
  `;
}

/** Rows for a screen reader; the eye sees one grid. @type {Cell[][]} */
const ROWS = [0, 1, 2, 3, 4, 5].map((row) => {
  /** @type {Cell[]} */
  const cells = PLACES.flatMap((place, slot) => (place[0] === row ? [slot] : []));
  return row === 1 ? [cells[0], "centre", cells[1]] : cells;
});

export function Frames() {
  return html`
    <div class="frames" role="grid" aria-label="Twenty children around their parent" aria-rowcount="6" aria-colcount="6"
      aria-busy=${breeding.value} ref=${attach} onKeyDown=${keyOnFrames}>
      <canvas class="live" data-testid="live" aria-hidden="true" ref=${attachCanvas}></canvas>
      ${ROWS.map((cells, row) => html`
        <div role="row" class="line" aria-rowindex=${row + 1} key=${row}>
          ${cells.map((cell) => html`<${Frame} key=${cell} cell=${cell} />`)}
        </div>
      `)}
    </div>
  `;
}
