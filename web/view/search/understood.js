/**
 * What the server read in a target, before a search is started: figures, and for pictures their
 * scene and the status of each pixel.
 *
 * @import { Target, TargetView } from "../../model.js"
 */
import { amount } from "../../page/format.js";
import { sizeInWords } from "../../page/size.js";
import { measuredUrl, viewUrl } from "../../search/routes.js";
import { searchStore } from "../../search/store.js";
import { nameOfView, pixelStatuses, share } from "../../search/views.js";
import { kindInWords } from "../../search/words.js";
import { Pair } from "../compare/pair.js";
import { Fact } from "../control.js";
import { html } from "../html.js";
import { viewStore } from "../store.js";

/** @param {string} url */
const markFailed = (url) => () => {
  viewStore.failedTargetPictures.value = new Set(viewStore.failedTargetPictures.value).add(url);
};

/** @param {{url: string, name: string, words: string, smooth?: boolean}} props */
const Small = ({ url, name, words, smooth = false }) => html`
  <figure class="square">
    <div class="paper">${viewStore.failedTargetPictures.value.has(url) ? html`<p class="small hollow">This picture cannot be drawn.</p>` : html`<img class=${smooth ? "" : "exact"} src=${url} alt=${words} onError=${markFailed(url)} />`}</div>
    <figcaption>${name}</figcaption>
  </figure>
`;

/** Legend of the picture of pixel statuses. @param {{of: TargetView}} props */
const PixelStatuses = ({ of }) => html`
  <ul class="pixel-statuses" aria-label="Status of the pixels" data-testid="pixel-statuses">
    ${pixelStatuses(of.pixels).map(({ status, name, color, words, count }) => html`
      <li key=${status} title=${words}><span class="dot" style=${{ background: color }}></span><span class="grow">${name}</span><span>${count.toLocaleString("en")}</span><span class="small">${share(count, of.pixels.pixels)}</span></li>
    `)}
  </ul>
`;

/** @param {TargetView} of */
function viewInWords(of) {
  const { mesh, light_deg } = of.scene;
  const parts = [`${sizeInWords(of.size_px)}`, /^[a-z]+$/.test(mesh) ? mesh : "uploaded object", `light at ${amount(light_deg ?? 0)}°`, of.samples === "adaptive" ? "adaptive rays" : `${of.samples} ${of.samples === 1 ? "ray" : "rays"} a pixel`];
  if (of.gain_solved) parts.push("brightness unknown");
  if (of.held_out) parts.push("held out");
  const clipped = ["red", "green", "blue"].flatMap((name, at) => of.clipped_from?.[at] == null ? [] : [`${name} ${of.clipped_from[at]}`]);
  if (clipped.length > 0) parts.push(`clipped from code ${clipped.join(", ")}`);
  return parts.join(", ");
}

/**
 * A picture beside its scene, its pixels and its mask.
 * @param {{of: Target, views: TargetView[], at: number}} props
 */
function View({ of, views, at }) {
  const view = views[at];
  const url = (/** @type {"picture"|"scene"|"pixels"|"mask"} */ what) => viewUrl(of.id, at, what);
  /**
   * @param {"picture"|"scene"} what
   * @param {string} name
   * @param {string} words
   * @returns {import("../compare/pair.js").Side}
   */
  const side = (what, name, words) => ({ name, words, url: viewStore.failedTargetPictures.value.has(url(what)) ? null : url(what), lost: true });
  return html`
    <div class="view-of" key=${`${of.id} ${at}`} data-testid="understood-view">
      <${Pair} id="understood" upper=${side("picture", "picture", nameOfView(views, at))} lower=${side("scene", "scene", "The scene as the server understood it, in grey")} state=${searchStore.understoodPair} placeholder=""
        hint="Flip or blend: where object and picture do not cover each other, the camera or object does not match." />
      <div class="pixels-of">
        <p class="small">${viewInWords(view)}</p>
        <div class="smalls">
          <${Small} url=${url("pixels")} name="pixels" words="Status of each pixel, in the colours of the list below" />
          ${view.pixels.masked > 0 && html`<${Small} url=${url("mask")} name="mask" words="The mask, white where the picture is used" />`}
        </div>
        <${PixelStatuses} of=${view} />
      </div>
    </div>
  `;
}

/** @param {{of: Target, views: TargetView[]}} props */
function Views({ of, views }) {
  const at = viewStore.understoodView.value.of === of.id ? Math.min(viewStore.understoodView.value.view, views.length - 1) : 0;
  return html`
    ${views.length > 1 && html`
      <div class="choice" role="radiogroup" aria-label="Picture" data-testid="understood-views">
        ${views.map((view, number) => html`
          <label key=${number} class=${number === at ? "chip on" : "chip"}>
            <input type="radio" name="understood-view" checked=${number === at} onChange=${() => (viewStore.understoodView.value = { of: of.id, view: number })} /><span>${number + 1}${view.held_out ? " held out" : ""}</span>
          </label>
        `)}
      </div>
    `}
    <${View} of=${of} views=${views} at=${at} />
  `;
}

/** Side of the pictures of a measured target. */
const MEASURED_PX = 256;
/** Lights under which a measured target is shown, in degrees on the light circle. */
const LIGHTS = [
  { degrees: 0, name: "light beside the eye" },
  { degrees: 100, name: "light from behind" },
];

/** Pictures of a measured material. @param {{of: Target}} props */
const Measured = ({ of }) => html`
  <div class="smalls measured" data-testid="understood-measured">
    ${LIGHTS.map(({ degrees, name }) => html`<${Small} key=${degrees} url=${measuredUrl(of.id, MEASURED_PX, degrees)} name=${name} words=${`The measured material on a sphere, ${name}`} smooth=${true} />`)}
  </div>
`;

/** Explanation of the reciprocal floor. @param {Target} of */
const floorInWords = (of) => (typeof of.reciprocal_floor !== "number"
  ? "No pair of directions was measured both ways, so the error that a reciprocal material can reach is unknown."
  : "The reciprocal floor is the least error of a reciprocal material on the measurement as it is. Where all directions were measured, results are compared with the mean of both orders of light and eye, and their error can be lower.");

/** Id of the target that was scrolled to last. */
let shown = "";

/**
 * Scrolls to the result, which should be checked before the search is started.
 * @param {string} id
 */
const scrollToOnce = (id) => (/** @type {HTMLElement|null} */ element) => {
  if (!element || shown === id) return;
  shown = id;
  element.scrollIntoView({ block: "nearest" });
};

/** @param {{of: Target}} props */
export function Understood({ of }) {
  const views = of.views ?? [];
  return html`
    <div class="understood" data-testid="target-understood" ref=${scrollToOnce(of.id)}>
      <h3>As the server understood it</h3>
      ${views.length > 0 ? html`<${Views} of=${of} views=${views} />` : html`<${Measured} of=${of} />`}
      <dl>
        <${Fact} name="kind" value=${kindInWords(of.kind)} />
        ${views.length > 1 && html`<${Fact} name="pictures" value=${`${views.length}, ${views.filter((view) => view.held_out).length} held out`} />`}
        <${Fact} name="samples" value=${of.samples.toLocaleString("en")} />
        <${Fact} name="fitted to" value=${of.fitted_samples.toLocaleString("en")} title="Samples that the search uses" />
        <${Fact} name="held out" value=${of.held_out_samples.toLocaleString("en")} title="Samples that are not fitted; errors are measured on them" />
        ${of.skipped_samples > 0 && html`<${Fact} name="skipped" value=${of.skipped_samples.toLocaleString("en")} title="Negative, or not finite, or below the horizon" />`}
        <${Fact} name="largest f" value=${`${amount(of.largest_f)} per sr`} />
        ${views.length === 0 && html`<${Fact} name="reciprocal floor" value=${typeof of.reciprocal_floor === "number" ? amount(of.reciprocal_floor) : "unknown"}
          title="Least error of a reciprocal material on the measurement as it is: pairs of directions that were measured in both orders differ" />`}
        ${of.largest_albedo && html`<${Fact} name="largest albedo" value=${`${amount(of.largest_albedo.albedo)} at ${of.largest_albedo.theta_deg}°`}
          title="Largest share of the light from one direction that is reflected" />`}
      </dl>
      ${of.largest_albedo && of.largest_albedo.albedo > 1.02 && html`<p class="small" data-testid="too-much">The target reflects more light than it receives. Results are energy-conserving and differ from it there.</p>`}
      <p class="small">${views.length > 0 ? "Pictures cover few pairs of directions: check the results under another light too." : floorInWords(of)}</p>
    </div>
  `;
}
