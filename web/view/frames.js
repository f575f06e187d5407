/**
 * The 6 x 6 grid: 20 frames around a centre of 4 x 4.
 *
 * @import { Cell, Generation, Individual } from "../model.js"
 */
import { pictureUrl } from "../api/routes.js";
import { flip, pinCell } from "../compare/ab.js";
import { compareStore } from "../compare/store.js";
import { nameOf, toggleFavourite } from "../lineage/breed.js";
import { individualIn } from "../lineage/individuals.js";
import { makeupInWords } from "../lineage/layers.js";
import { pictureFailed, pictureLoaded, retryPicture } from "../lineage/pictures.js";
import { lineageStore } from "../lineage/store.js";
import { observePixels } from "../live/canvas.js";
import { attachCanvas, isServerDrawn, schedule } from "../live/loop.js";
import { liveStore } from "../live/store.js";
import { pictureSource } from "../page/distance.js";
import { pageStore } from "../page/store.js";
import { globe } from "../scene/rotation.js";
import { sceneStore } from "../scene/store.js";
import { searchStore } from "../search/store.js";
import { Pin } from "./compare/ab.js";
import { listenToGestures } from "./gestures.js";
import { html } from "./html.js";
import { PLACES, keyOnFrames } from "./keys.js";
import { LightDot } from "./light.js";
import { mark } from "./marks.js";
import { ServerPicture } from "./picture.js";
import { TargetFlip, TargetInCentre } from "./search/active_target.js";
import { viewStore } from "./store.js";

/**
 * Largest side of the large picture. Its cost grows with the square, and more is hardly visible.
 */
const LARGE_LIMIT_PX = 1024;

/** Observes the grid, for the size of the large picture. @type {ResizeObserver|null} */
let observer = null;

/** Ref of the grid. @param {HTMLElement|null} element */
function attach(element) {
  if (!element) return;
  listenToGestures(element);
  observer?.disconnect();
  observer = new ResizeObserver(([entry]) => {
    const px = (entry.contentRect.width / 6) * 4 * devicePixelRatio;
    viewStore.centre_px.value = Math.min(LARGE_LIMIT_PX, Math.max(64, Math.ceil(px / 64) * 64));
  });
  observePixels(observer, element);
}

/** Name of a frame for screen readers. @param {Cell} cell @param {Individual} of */
function label(cell, of) {
  const parts = [nameOf(cell), makeupInWords(of)];
  if (of.favourite) parts.push("favourite");
  if (of.twin) parts.push("identical to another");
  if (lineageStore.failedPictures.value.has(of.thumbnail)) parts.push(lineageStore.refusedPictures.value.get(of.thumbnail) ?? "its picture could not be loaded");
  if (lineageStore.mate.value?.id === of.id) parts.push("mate");
  if (compareStore.pinned.value?.id === of.id) parts.push("B");
  if (cell === "centre" && lineageStore.draft.value?.of.id === of.id) parts.push("edited, not stored");
  if (cell === "centre" && compareStore.targetInCentre.value) parts.push("the target is shown in its place");
  if (cell === "centre" && compareStore.flipped.value) parts.push("B is shown in its place");
  return parts.join(", ");
}

/**
 * Thumbnail of an individual; a button that requests it again if it failed.
 * @param {{of: Individual, cell: Cell}} props
 */
function Picture({ of, cell }) {
  const url = of.thumbnail;
  if (lineageStore.failedPictures.value.has(url)) {
    const reason = lineageStore.refusedPictures.value.get(url);
    return html`
      ${reason && html`<p class="refused" data-testid="refused" title=${reason}>${reason}</p>`}
      <button type="button" class=${reason ? "again refused" : "again"} tabindex="-1" title="Load the picture again" aria-label=${`Load the picture of ${nameOf(cell)} again`} onClick=${() => retryPicture(url)}>⟳</button>
    `;
  }
  return html`
    <img
      key=${lineageStore.pictureRetries.value.get(url) ?? 0}
      data-frame=${cell}
      data-generation=${lineageStore.shownId.value}
      class=${lineageStore.loadedPictures.value.has(url) ? "" : "waiting"}
      fetchpriority=${cell === "centre" ? "high" : undefined}
      src=${pictureSource(url)}
      alt=""
      draggable=${false}
      onLoad=${() => pictureLoaded(url)}
      onError=${() => pictureFailed(url)}
    />
  `;
}

/**
 * Address of the centre's large picture, once the frames have theirs; null before.
 * @param {Individual} of
 */
function largeUrl(of) {
  const sceneId = lineageStore.lineage.value?.scene;
  const wanted = sceneId && lineageStore.readyId.value === lineageStore.shownId.value && viewStore.centre_px.value > (lineageStore.lineage.value?.thumbnail_px ?? 0);
  return wanted && !lineageStore.breeding.value && !sceneStore.busy.value ? pictureUrl(of.id, sceneId, viewStore.centre_px.value) : null;
}

/** Large picture over the centre's thumbnail. @param {{url: string}} props */
const Large = ({ url }) => html`<${ServerPicture} url=${url} name=${lineageStore.loadedPictures.value.has(url) ? "large" : "large waiting"} />`;

/** B's pictures in the centre, loaded before they are shown. @param {{of: Individual}} props */
function Other({ of }) {
  const sceneId = lineageStore.lineage.value?.scene;
  if (!sceneId) return null;
  const url = pictureUrl(of.id, sceneId, lineageStore.lineage.value?.thumbnail_px ?? 256);
  const large = largeUrl(of);
  const lit = compareStore.flipped.value ? stillUrl(of, true) : null;
  const best = lit ?? (large && lineageStore.loadedPictures.value.has(large) ? large : url);
  return html`
    <div class=${compareStore.flipped.value ? "other" : "other unflipped"} data-testid="other">
      <${ServerPicture} url=${url} />
      ${large && html`<${Large} url=${large} />`}
      ${lit && html`<${Still} key=${`${of.id} ${sceneId}`} url=${lit} />`}
      ${compareStore.flipped.value && html`<${Marks} url=${best} />`}
    </div>
  `;
}

/**
 * Address of the picture under the moving light, of an individual that is not drawn live; null
 * while the light is at its place in the scene.
 * @param {Individual} of
 * @param {boolean} centre
 */
function stillUrl(of, centre) {
  const at = liveStore.still.value;
  const px = lineageStore.lineage.value?.thumbnail_px ?? 256;
  if (!at?.scene || at.generation !== lineageStore.shownId.value || !isServerDrawn(of)) return null;
  const whole = centre ? Math.max(px, viewStore.centre_px.value) : px;
  return pictureUrl(of.id, at.scene, at.sharp ? whole : centre ? px : px / 2, at.degrees);
}

/** Lets the light move on to its next step. @param {string} url */
function stillLoaded(url) {
  if (liveStore.still.value?.sharp) pictureLoaded(url);
  schedule();
}

/** A picture that stays visible until the next has loaded. @param {{url: string}} props */
const Still = ({ url }) => html`<img class="still" src=${url} alt="" draggable=${false} onLoad=${() => stillLoaded(url)} onError=${schedule} />`;

/** Ref that draws the marks. @param {HTMLCanvasElement|null} element */
const marking = (element) => element && void mark(element, element.dataset.url ?? "");

/**
 * Marks of burnt-out and black pixels over a picture, drawn once for each picture and size.
 * @param {{url: string}} props
 */
function Marks({ url }) {
  if (!pageStore.clippingShown.value || !lineageStore.loadedPictures.value.has(url)) return null;
  return html`<canvas class="marks" data-testid="marks" aria-hidden="true" key=${`${url} ${viewStore.centre_px.value}`} data-url=${url} ref=${marking}></canvas>`;
}

/** Rotation or scale while the object is dragged, until it is rendered. */
function Globe() {
  const now = sceneStore.draggedPose.value;
  const of = sceneStore.scene.value;
  if (!now || !of) return null;
  if (now.kind === "scale") return html`<p class="measure">× ${now.scale.toPrecision(3)}</p>`;
  return html`
    <svg class="globe" viewBox="-1.05 -1.05 2.1 2.1" aria-hidden="true">
      <circle r="1" />
      ${globe(now.rotation, of.camera).map((piece) => html`<polyline class=${piece.front ? "front" : "behind"} points=${piece.points} />`)}
    </svg>
  `;
}

/**
 * A frame. Its pictures lie over each other, in this order: thumbnail, large picture, picture under
 * the moving light, marks, B, target. If the frame is drawn live they are hidden.
 * @param {{cell: Cell}} props
 */
function Frame({ cell }) {
  const of = individualIn(cell);
  const centre = cell === "centre";
  const [row, column] = centre ? [1, 1] : PLACES[cell];
  const isMate = of !== null && lineageStore.mate.value?.id === of.id;
  const drawnLive = liveStore.liveCells.value.has(cell);
  const large = centre && of && largeUrl(of);
  const lit = of && !drawnLive ? stillUrl(of, centre) : null;
  const other = centre ? compareStore.pinned.value : null;
  const edited = centre && of !== null && lineageStore.draft.value?.of.id === of.id;
  const isB = of !== null && compareStore.pinned.value?.id === of.id;
  const flippedHere = other !== null && compareStore.flipped.value;
  const away = flippedHere || (centre && compareStore.targetInCentre.value);
  const scaled = !drawnLive && centre && sceneStore.scene.value && sceneStore.draggedPose.value?.kind === "scale" ? sceneStore.draggedPose.value.scale / sceneStore.scene.value.scale : 1;
  return html`
    <div
      role="gridcell"
      data-cell=${cell}
      data-testid=${centre ? "centre" : `cell-${cell}`}
      class=${`frame ${centre ? "centre" : ""} ${isMate ? "mated" : ""}`}
      tabindex=${pageStore.focusedCell.value === cell ? 0 : -1}
      aria-colindex=${column + 1}
      aria-rowspan=${centre ? 4 : undefined}
      aria-colspan=${centre ? 4 : undefined}
      aria-label=${of ? label(cell, of) : `${nameOf(cell)}, empty`}
      onFocus=${() => (pageStore.focusedCell.value = cell)}
    >
      ${of && html`
        <div class=${`pictures ${drawnLive ? "lit" : ""} ${away ? "flipped" : ""}`} style=${{ transform: scaled === 1 ? "" : `scale(${scaled})` }}>
          <${Picture} of=${of} cell=${cell} />
          ${large && html`<${Large} url=${large} />`}
          ${lit && html`<${Still} key=${of.id} url=${lit} />`}
          ${edited && liveStore.draftPicture.value && html`<img class="still" data-testid="draft-picture" src=${liveStore.draftPicture.value} alt="" draggable=${false} />`}
          <${Marks} url=${lit ?? (large && lineageStore.loadedPictures.value.has(large) ? large : of.thumbnail)} />
          ${other && html`<${Other} of=${other} />`}
          ${centre && searchStore.activeTarget.value && html`<${TargetInCentre} size=${lineageStore.readyId.value === lineageStore.shownId.value ? Math.max(256, viewStore.centre_px.value) : 256} />`}
        </div>
        ${centre && !drawnLive && html`<${Globe} />`}
        ${centre && html`<${LightDot} />`}
        <button type="button" class=${of.favourite ? "star on" : "star"} data-testid="favourite" tabindex="-1" aria-pressed=${of.favourite}
          aria-label=${`Favourite: ${nameOf(cell)}`} title="Favourite (F)" onClick=${() => toggleFavourite(cell)}>${of.favourite ? "★" : "☆"}</button>
        <${Pin} name=${nameOf(cell)} on=${isB} onClick=${() => pinCell(cell, nameOf(cell))} />
        ${other && html`<button type="button" class="flip" data-testid="flip-here" tabindex="-1" aria-pressed=${flippedHere} aria-label="Show B in place of the centre" title="Flip between A and B (X)"
          onClick=${() => flip(!compareStore.flipped.value)}><span class=${flippedHere ? "a" : "a on"}></span><span class=${flippedHere ? "b on" : "b"}></span></button>`}
        ${centre && html`<${TargetFlip} />`}
        ${isMate && html`<span class="badge" data-testid="mate-badge">mate</span>`}
        ${edited && html`<span class="badge edited" data-testid="edit-badge" title="The picture shows parameters that are not stored">edited</span>`}
      `}
    </div>
  `;
}

/**
 * Rows of the grid for screen readers. The picture shows the centre across four of them.
 * @type {Cell[][]}
 */
const ROWS = [0, 1, 2, 3, 4, 5].map((row) => {
  /** @type {Cell[]} */
  const cells = PLACES.flatMap((place, slot) => (place[0] === row ? [slot] : []));
  return row === 1 ? [cells[0], "centre", cells[1]] : cells;
});

export function Frames() {
  return html`
    <div class="frames" id="frames" role="grid" aria-label="Twenty children around their parent" aria-rowcount="6" aria-colcount="6"
      aria-busy=${lineageStore.breeding.value} ref=${attach} onKeyDown=${keyOnFrames}>
      <canvas class="live" data-testid="live" aria-hidden="true" ref=${attachCanvas}></canvas>
      ${ROWS.map((cells, row) => html`
        <div role="row" class="line" aria-rowindex=${row + 1} key=${row}>
          ${cells.map((cell) => html`<${Frame} key=${cell} cell=${cell} />`)}
        </div>
      `)}
    </div>
  `;
}
