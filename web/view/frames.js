/**
 * The 6 x 6 grid: 20 frames around a centre of 4 x 4. Owns how individuals are shown; hands and keys are elsewhere.
 *
 * @import { Cell, Generation, Individual } from "../types.js"
 */
import { signal } from "../vendor/signals-core.js";
import { pictureUrl } from "../api.js";
import { nameOf, toggleFavourite } from "../breed.js";
import { flip, flipped, pinCell, pinned, targetSeen } from "../compare.js";
import { listenToHands } from "../hands.js";
import { html } from "../html.js";
import { keyOnFrames, PLACES } from "../keys.js";
import { makeupInWords } from "../layers.js";
import { attachCanvas, isPictured, liveCells, schedule } from "../live/live.js";
import { observePixels } from "../live/stage.js";
import { still } from "../live/stills.js";
import { mark } from "../marks.js";
import { sought } from "../sought.js";
import { Pin } from "./compare.js";
import { LightDot } from "./light.js";
import { InCentre, InCentreFlip } from "./sought.js";
import { attempts, failed, loaded, pictureFailed, pictureLoaded, ready, tryAgain } from "../pictures.js";
import { breeding, clipped, focused, generation, individualIn, lineage, mate, sceneBusy, shown, turning, scene } from "../state.js";
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
  observePixels(observer, element);
}

/** @param {Cell} cell @param {Individual} of */
function label(cell, of) {
  const parts = [nameOf(cell), makeupInWords(of)];
  if (of.favourite) parts.push("favourite");
  if (of.twin) parts.push("twin of another");
  if (failed.value.has(of.thumbnail)) parts.push("its picture could not be loaded");
  if (mate.value?.id === of.id) parts.push("mate");
  if (pinned.value?.id === of.id) parts.push("B");
  if (cell === "centre" && targetSeen.value) parts.push("the target is shown in its place");
  if (cell === "centre" && flipped.value) parts.push("B is shown in its place");
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

/** Where the centre's picture is at the size it is shown, once the frames have what they need. @param {Individual} of */
function largeUrl(of) {
  const sceneId = lineage.value?.scene;
  const wanted = sceneId && ready.value === shown.value && largePx.value > (lineage.value?.thumbnail_px ?? 0);
  return wanted && !breeding.value && !sceneBusy.value ? pictureUrl(of.id, sceneId, largePx.value) : null;
}

/** @param {{url: string}} props */
function Large({ url }) {
  return html`
    <img key=${`${url} ${attempts.value.get(url) ?? 0}`} class=${loaded.value.has(url) ? "large" : "large waiting"} src=${url} alt="" draggable=${false}
      onLoad=${() => pictureLoaded(url)} onError=${() => pictureFailed(url)} />
  `;
}

/** B's pictures in the centre, there before they are looked at. @param {{of: Individual}} props */
function Other({ of }) {
  const sceneId = lineage.value?.scene;
  if (!sceneId) return null;
  const url = pictureUrl(of.id, sceneId, lineage.value?.thumbnail_px ?? 256);
  const large = largeUrl(of);
  const lit = flipped.value ? stillUrl(of, true) : null;
  const best = lit ?? (large && loaded.value.has(large) ? large : url);
  return html`
    <div class=${flipped.value ? "other" : "other unflipped"} data-testid="other">
      <img key=${url} src=${url} alt="" draggable=${false} onLoad=${() => pictureLoaded(url)} />
      ${large && html`<${Large} url=${large} />`}
      ${lit && html`<${Still} key=${`${of.id} ${sceneId}`} url=${lit} />`}
      ${flipped.value && html`<${Marks} url=${best} />`}
    </div>
  `;
}

/**
 * Where the picture of what is not drawn live is with the light where it is; null while its other pictures have it there.
 * @param {Individual} of @param {boolean} centre
 */
function stillUrl(of, centre) {
  const at = still.value;
  const { scene: sceneId, thumbnail_px: px = 256 } = lineage.value ?? {};
  if (!at || !sceneId || ready.value !== shown.value || !isPictured(of)) return null;
  const whole = centre ? Math.max(px, largePx.value) : px;
  return pictureUrl(of.id, sceneId, at.sharp ? whole : centre ? px : px / 2, (scene.value?.light_deg ?? 0) + at.degrees);
}

/** @param {string} url */
function stillLoaded(url) {
  if (still.value?.sharp) pictureLoaded(url);
  schedule();
}

/** The last picture stays to be seen until the next is there. @param {{url: string}} props */
const Still = ({ url }) => html`<img class="still" src=${url} alt="" draggable=${false} onLoad=${() => stillLoaded(url)} onError=${schedule} />`;

/** @param {HTMLCanvasElement|null} element */
const marking = (element) => element && void mark(element, element.dataset.url ?? "");

/** The marks over a picture, made once for each picture and size. @param {{url: string}} props */
function Marks({ url }) {
  if (!clipped.value || !loaded.value.has(url)) return null;
  return html`<canvas class="marks" data-testid="marks" aria-hidden="true" key=${`${url} ${largePx.value}`} data-url=${url} ref=${marking}></canvas>`;
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
  const large = centre && of && largeUrl(of);
  const lit = of && !drawnLive ? stillUrl(of, centre) : null;
  const other = centre ? pinned.value : null;
  const isB = of !== null && pinned.value?.id === of.id;
  const flippedHere = other !== null && flipped.value;
  const away = flippedHere || (centre && targetSeen.value);
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
        <div class=${`pictures ${drawnLive ? "lit" : ""} ${away ? "flipped" : ""}`} style=${{ transform: scaled === 1 ? "" : `scale(${scaled})` }}>
          <${Picture} of=${of} cell=${cell} />
          ${large && html`<${Large} url=${large} />`}
          ${lit && html`<${Still} key=${`${of.id} ${lineage.value?.scene}`} url=${lit} />`}
          <${Marks} url=${lit ?? (large && loaded.value.has(large) ? large : of.thumbnail)} />
          ${other && html`<${Other} of=${other} />`}
          ${centre && sought.value && html`<${InCentre} size=${ready.value === shown.value ? Math.max(256, largePx.value) : 256} />`}
        </div>
        ${centre && !drawnLive && html`<${Globe} />`}
        ${centre && html`<${LightDot} />`}
        <button type="button" class=${of.favourite ? "star on" : "star"} data-testid="favourite" tabindex="-1" aria-pressed=${of.favourite}
          aria-label=${`Favourite: ${nameOf(cell)}`} title="Favourite (F)" onClick=${() => toggleFavourite(cell)}>${of.favourite ? "★" : "☆"}</button>
        <${Pin} name=${nameOf(cell)} on=${isB} does=${() => pinCell(cell, nameOf(cell))} />
        ${other && html`<button type="button" class="flip" data-testid="flip-here" tabindex="-1" aria-pressed=${flippedHere} aria-label="Show B in the place of the centre" title="Flip between A and B (X)"
          onClick=${() => flip(!flipped.value)}><span class=${flippedHere ? "a" : "a on"}></span><span class=${flippedHere ? "b on" : "b"}></span></button>`}
        ${centre && html`<${InCentreFlip} />`}
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
