/**
 * What the server found in a target, before anything is searched: its figures, and for pictures what it takes the scene and each pixel
 * for. Owns their words.
 *
 * @import { Target, TargetView } from "../types.js"
 */
import { html } from "../html.js";
import { understood } from "../pair.js";
import { viewUrl } from "../search_api.js";
import { fatesOf, nameOfView, share } from "../search_views.js";
import { kindInWords } from "../search_words.js";
import { signal } from "../vendor/signals-core.js";
import { Pair } from "./pair.js";
import { amount } from "./words.js";

/** Which picture is looked at, of which target. @type {import("../vendor/signals-core.js").Signal<{of: string, view: number}>} */
const looked = signal({ of: "", view: 0 });
/** Pictures that the server could not draw. @type {import("../vendor/signals-core.js").Signal<Set<string>>} */
const lost = signal(new Set());

/** @param {{name: string, value: unknown, title?: string}} props */
const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** @param {string} url */
const lose = (url) => () => {
  lost.value = new Set(lost.value).add(url);
};

/** @param {{url: string, name: string, words: string}} props */
const Small = ({ url, name, words }) => html`
  <figure class="square">
    <div class="paper">${lost.value.has(url) ? html`<p class="small hollow">This picture cannot be drawn.</p>` : html`<img class="exact" src=${url} alt=${words} onError=${lose(url)} />`}</div>
    <figcaption>${name}</figcaption>
  </figure>
`;

/** What became of the pixels, in the colours of the picture of them. @param {{of: TargetView}} props */
const Fates = ({ of }) => html`
  <ul class="fates" aria-label="What became of the pixels" data-testid="understood-fates">
    ${fatesOf(of.pixels).map(({ fate, name, color, words, count }) => html`
      <li key=${fate} title=${words}><span class="dot" style=${{ background: color }}></span><span class="grow">${name}</span><span>${count.toLocaleString("en")}</span><span class="small">${share(count, of.pixels.pixels)}</span></li>
    `)}
  </ul>
`;

/** @param {TargetView} of */
function viewInWords(of) {
  const { mesh, light_deg } = of.scene;
  const parts = [`${of.size_px} × ${of.size_px}`, /^[a-z]+$/.test(mesh) ? mesh : "uploaded object", `light at ${amount(light_deg ?? 0)}°`, of.samples === "adaptive" ? "adaptive rays" : `${of.samples} ${of.samples === 1 ? "ray" : "rays"} a pixel`];
  if (of.gain_solved) parts.push("brightness not known");
  if (of.held_out) parts.push("held out");
  return parts.join(", ");
}

/** One picture beside its scene, its pixels and its mask. @param {{of: Target, views: TargetView[], at: number}} props */
function View({ of, views, at }) {
  const view = views[at];
  const url = (/** @type {"picture"|"scene"|"pixels"|"mask"} */ what) => viewUrl(of.id, at, what);
  /** @param {"picture"|"scene"} what @param {string} name @param {string} words @returns {import("./pair.js").Side} */
  const side = (what, name, words) => ({ name, words, url: lost.value.has(url(what)) ? null : url(what), lost: true });
  return html`
    <div class="view-of" key=${`${of.id} ${at}`} data-testid="understood-view">
      <${Pair} id="understood" upper=${side("picture", "picture", nameOfView(views, at))} lower=${side("scene", "scene", "The scene as understood, of grey clay")} state=${understood} waits=""
        hint="Flip or blend: where object and picture do not cover each other, camera or object is another." />
      <div class="pixels-of">
        <p class="small">${viewInWords(view)}</p>
        <div class="smalls">
          <${Small} url=${url("pixels")} name="pixels" words="What became of each pixel, in the colours of the list below" />
          ${view.pixels.masked > 0 && html`<${Small} url=${url("mask")} name="mask" words="The mask, white where it is looked at" />`}
        </div>
        <${Fates} of=${view} />
      </div>
    </div>
  `;
}

/** @param {{of: Target, views: TargetView[]}} props */
function Views({ of, views }) {
  const at = looked.value.of === of.id ? Math.min(looked.value.view, views.length - 1) : 0;
  return html`
    ${views.length > 1 && html`
      <div class="choice" role="radiogroup" aria-label="Picture" data-testid="understood-views">
        ${views.map((view, number) => html`
          <label key=${number} class=${number === at ? "chip on" : "chip"}>
            <input type="radio" name="understood-view" checked=${number === at} onChange=${() => (looked.value = { of: of.id, view: number })} /><span>${number + 1}${view.held_out ? " held out" : ""}</span>
          </label>
        `)}
      </div>
    `}
    <${View} of=${of} views=${views} at=${at} />
  `;
}

/** How close anything reciprocal can come. @param {Target} of */
const floorInWords = (of) => (of.reciprocal_floor === null
  ? "No pair was measured both ways round, so how close a reciprocal material can come is not known."
  : "The floor is how much it differs from itself with light and eye exchanged: nothing reciprocal comes closer.");

/** The target that was brought into sight last. */
let shown = "";

/** What was understood is to be looked at before anything is started. @param {string} id */
const inSight = (id) => (/** @type {HTMLElement|null} */ element) => {
  if (!element || shown === id) return;
  shown = id;
  element.scrollIntoView({ block: "nearest" });
};

/** @param {{of: Target}} props */
export function Understood({ of }) {
  const views = of.views ?? [];
  return html`
    <div class="understood" data-testid="target-understood" ref=${inSight(of.id)}>
      <h3>As understood</h3>
      ${views.length > 0 && html`<${Views} of=${of} views=${views} />`}
      <dl>
        <${Fact} name="kind" value=${kindInWords(of.kind)} />
        ${views.length > 1 && html`<${Fact} name="pictures" value=${`${views.length}, ${views.filter((view) => view.held_out).length} held out`} />`}
        <${Fact} name="samples" value=${of.samples.toLocaleString("en")} />
        <${Fact} name="fitted to" value=${of.fitted_samples.toLocaleString("en")} title="The search sees these" />
        <${Fact} name="held out" value=${of.held_out_samples.toLocaleString("en")} title="The search never sees these: errors are told by them" />
        ${of.skipped_samples > 0 && html`<${Fact} name="skipped" value=${of.skipped_samples.toLocaleString("en")} title="Negative, or not finite, or below the horizon" />`}
        <${Fact} name="largest f" value=${`${amount(of.largest_f)} per sr`} />
        ${views.length === 0 && html`<${Fact} name="reciprocal floor" value=${of.reciprocal_floor === null ? "not known" : amount(of.reciprocal_floor)}
          title="The measurement differs that much from itself where light and eye change places; nothing reciprocal comes closer" />`}
        ${of.largest_albedo && html`<${Fact} name="reflects at most" value=${`${amount(of.largest_albedo.albedo)} at ${of.largest_albedo.theta_deg}°`}
          title="Of the light from one direction" />`}
      </dl>
      ${of.largest_albedo && of.largest_albedo.albedo > 1.02 && html`<p class="small" data-testid="too-much">That is more light than there is. What is found reflects no more than what comes, and is off there.</p>`}
      <p class="small">${views.length > 0 ? "Pictures show few pairs of directions: look at what is found under another light too." : floorInWords(of)}</p>
    </div>
  `;
}
