/** The target beside the centre, and in its place. */
import { flipHandlers } from "../../compare/flip_key.js";
import { compareStore } from "../../compare/store.js";
import { pictureLoaded } from "../../lineage/pictures.js";
import { lineageStore } from "../../lineage/store.js";
import { sceneStore } from "../../scene/store.js";
import {
  centreLikeTargetUrl, centreUrl, flipKeyTarget, targetPictureUrl, useTargetScene,
} from "../../search/active_target.js";
import { searchStore } from "../../search/store.js";
import { nameOfView } from "../../search/views.js";
import { nameOfTarget } from "../../search/words.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";

const SIDE_PX = 256;

/** The target in the centre, loaded before it is shown. @param {{size: number}} props */
export function TargetInCentre({ size }) {
  const url = centreUrl(size);
  if (!url) return null;
  return html`
    <div class=${compareStore.targetInCentre.value ? "other" : "other unflipped"} data-testid="target-in-centre">
      <img key=${searchStore.activeTarget.value?.id} class="still by-height" src=${url} alt="" draggable=${false} onLoad=${() => pictureLoaded(url)} />
    </div>
  `;
}

/**
 * Button that shows the target in the centre. CSS draws its letter, because screen readers take the
 * name of a frame from its text.
 */
export function TargetFlip() {
  if (!searchStore.activeTarget.value) return null;
  const on = compareStore.targetInCentre.value;
  return html`
    <button type="button" class=${on ? "aim on" : "aim"} data-testid="target-here" tabindex="-1" aria-pressed=${on} aria-label="Show the target in place of the centre"
      title="The target in place of the centre: tap to flip, hold to glance (T)" ...${flipHandlers(flipKeyTarget)}></button>
  `;
}

/** @param {{url: string|null, alt: string, name: string, seen: boolean}} props */
const Side = ({ url, alt, name, seen }) => html`
  <figure class=${seen ? "side on" : "side"}>
    ${url && html`<${ServerPicture} url=${url} side=${SIDE_PX} alt=${alt} />`}
    <figcaption>${name}</figcaption>
  </figure>
`;

/** @param {Event} event */
const valueOf = (event) => /** @type {HTMLSelectElement} */ (event.target).value;

/** Choice among several targets and pictures. */
function Which() {
  const of = searchStore.activeTarget.value;
  const views = of?.views ?? [];
  return html`
    ${searchStore.lineageTargets.value.length > 1 && html`
      <select data-testid="target-which" aria-label="Target" value=${of?.id} onChange=${(/** @type {Event} */ event) => (searchStore.chosenTarget.value = { id: valueOf(event), view: 0 })}>
        ${searchStore.lineageTargets.value.map((one) => html`<option key=${one.id} value=${one.id} selected=${one.id === of?.id}>${nameOfTarget(one)}</option>`)}
      </select>
    `}
    ${views.length > 1 && html`
      <select data-testid="target-view" aria-label="Picture of the target" value=${searchStore.activeView.value}
        onChange=${(/** @type {Event} */ event) => (searchStore.chosenTarget.value = { id: of?.id ?? null, view: Number(valueOf(event)) })}>
        ${views.map((_, at) => html`<option key=${at} value=${at} selected=${at === searchStore.activeView.value}>${nameOfView(views, at)}</option>`)}
      </select>
    `}
  `;
}

/** Section of the right pane. */
export function TargetSection() {
  const of = searchStore.activeTarget.value;
  const centre = lineageStore.centre.value;
  if (!of || !centre) return null;
  return html`
    <section aria-labelledby="active-target-title" data-testid="active-target">
      <h2 id="active-target-title">Target</h2>
      <p class="cut" title=${nameOfTarget(of)}>${nameOfTarget(of)}</p>
      <div class="sides" data-testid="active-target-sides">
        <${Side} url=${centreLikeTargetUrl(centre.id, SIDE_PX)} alt="The centre, rendered like the target" name="centre" seen=${!compareStore.targetInCentre.value} />
        <${Side} url=${targetPictureUrl(SIDE_PX, null)} alt="The target" name="target" seen=${compareStore.targetInCentre.value} />
      </div>
      <${Which} />
      <div class="row">
        <button type="button" data-testid="target-flip" aria-pressed=${compareStore.targetInCentre.value} title="The target in place of the centre (T)" ...${flipHandlers(flipKeyTarget)}>Target in the centre</button>
      </div>
      <p class="small">Tap or T to flip, hold to glance.</p>
      ${searchStore.otherScene.value && html`
        <p class="small">The target's picture has another scene than this lineage, so the two do not match in the centre.</p>
        <button type="button" class="start" data-testid="target-scene" disabled=${sceneStore.busy.value} onClick=${useTargetScene}>Breed in the picture's scene</button>
      `}
      <${ProblemBox} place="activeTarget" />
    </section>
  `;
}
