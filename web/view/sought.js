/**
 * The target beside the centre and in its place while breeding by eye. Owns its words; which target is meant is sought.js's.
 */
import { targetSeen } from "../compare.js";
import { holdable } from "../flip_key.js";
import { html } from "../html.js";
import { pictureLoaded } from "../pictures.js";
import { besideSoughtUrl, centreUrl, chosenSought, keyOfTarget, otherScene, sought, soughtHere, soughtView, takeItsScene, targetPictureUrl } from "../sought.js";
import { nameOfView } from "../search_views.js";
import { nameOfTarget } from "../search_words.js";
import { large, sceneBusy } from "../state.js";
import { Trouble } from "./trouble.js";

const SIDE_PX = 256;

/** The target in the centre, there before it is looked at. @param {{size: number}} props */
export function InCentre({ size }) {
  const url = centreUrl(size);
  if (!url) return null;
  return html`
    <div class=${targetSeen.value ? "other" : "other unflipped"} data-testid="target-in-centre">
      <img key=${sought.value?.id} class="still" src=${url} alt="" draggable=${false} onLoad=${() => pictureLoaded(url)} />
    </div>
  `;
}

/** Flips the centre by hand; the words of its letter are drawn by the style, for a frame's name is in words. */
export function InCentreFlip() {
  if (!sought.value) return null;
  const on = targetSeen.value;
  return html`
    <button type="button" class=${on ? "aim on" : "aim"} data-testid="target-here" tabindex="-1" aria-pressed=${on} aria-label="Show the target in the place of the centre"
      title="The target in the place of the centre: tap to flip, hold to glance (T)" ...${holdable(keyOfTarget)}></button>
  `;
}

/** @param {{url: string|null, alt: string, name: string, seen: boolean}} props */
const Side = ({ url, alt, name, seen }) => html`
  <figure class=${seen ? "side on" : "side"}>
    ${url && html`<img src=${url} width=${SIDE_PX} height=${SIDE_PX} alt=${alt} />`}
    <figcaption>${name}</figcaption>
  </figure>
`;

/** @param {Event} event */
const valueOf = (event) => /** @type {HTMLSelectElement} */ (event.target).value;

/** Which of several is meant. */
function Which() {
  const of = sought.value;
  const views = of?.views ?? [];
  return html`
    ${soughtHere.value.length > 1 && html`
      <select data-testid="target-which" aria-label="Target" value=${of?.id} onChange=${(/** @type {Event} */ event) => (chosenSought.value = { id: valueOf(event), view: 0 })}>
        ${soughtHere.value.map((one) => html`<option key=${one.id} value=${one.id} selected=${one.id === of?.id}>${nameOfTarget(one)}</option>`)}
      </select>
    `}
    ${views.length > 1 && html`
      <select data-testid="target-view" aria-label="Picture of the target" value=${soughtView.value}
        onChange=${(/** @type {Event} */ event) => (chosenSought.value = { id: of?.id ?? null, view: Number(valueOf(event)) })}>
        ${views.map((_, at) => html`<option key=${at} value=${at} selected=${at === soughtView.value}>${nameOfView(views, at)}</option>`)}
      </select>
    `}
  `;
}

/** In the right pane. */
export function SoughtSection() {
  const of = sought.value;
  const centre = large.value;
  if (!of || !centre) return null;
  return html`
    <section aria-labelledby="sought-title" data-testid="sought-section">
      <h2 id="sought-title">Target</h2>
      <p class="cut" title=${nameOfTarget(of)}>${nameOfTarget(of)}</p>
      <div class="sides" data-testid="sought-sides">
        <${Side} url=${besideSoughtUrl(centre.id, SIDE_PX)} alt="The centre, drawn as the target is" name="centre" seen=${!targetSeen.value} />
        <${Side} url=${targetPictureUrl(SIDE_PX, null)} alt="The target" name="target" seen=${targetSeen.value} />
      </div>
      <${Which} />
      <div class="row">
        <button type="button" data-testid="target-flip" aria-pressed=${targetSeen.value} title="The target in the place of the centre (T)" ...${holdable(keyOfTarget)}>Target in the centre</button>
      </div>
      <p class="small">Tap or T to flip, hold to glance.</p>
      ${otherScene.value && html`
        <p class="small">Its picture shows another scene than this lineage's, so that the two do not cover each other in the centre.</p>
        <button type="button" class="start" data-testid="target-scene" disabled=${sceneBusy.value} onClick=${takeItsScene}>Breed in the picture's scene</button>
      `}
      <${Trouble} place="sought" />
    </section>
  `;
}
