/**
 * The comparison dialog: choice, pictures, differences, curves, numbers.
 *
 * @import { Compared, Comparison as Found } from "../../model.js"
 * @import { Choice } from "../../compare/comparison.js"
 */
import {
  FEWEST, MOST, closeComparison, compareChosen, favouriteChoices, isChosen, presetChoice,
  setReference, shownChoices, toggle,
} from "../../compare/comparison.js";
import { compareStore } from "../../compare/store.js";
import { colorOf, modelsInWords } from "../../lineage/layers.js";
import { lineageStore } from "../../lineage/store.js";
import { amount } from "../../page/format.js";
import { DialogTitle, modal } from "../dialog.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";
import { Chart } from "./chart.js";

const opened = modal();

/** A material that can be chosen. @param {Choice} of */
function Tile(of) {
  const on = isChosen(of);
  return html`
    <li key=${of.key}>
      <button type="button" class="tile" aria-pressed=${on} aria-label=${of.name} title=${of.name} data-testid=${`compare-${of.key}`} disabled=${!on && compareStore.chosen.value.length >= MOST} onClick=${() => toggle(of)}>
        <${ServerPicture} url=${of.picture} lazy />
      </button>
    </li>
  `;
}

/** @param {{title: string, of: Choice[]}} props */
const Group = ({ title, of }) => of.length > 0 && html`<h3>${title}</h3><ul class="gallery" aria-label=${title}>${of.map(Tile)}</ul>`;

/** The chosen materials. */
const Tray = () => html`
  <ol class="tray" aria-label="Chosen">
    ${compareStore.chosen.value.map((of, order) => html`
      <li key=${of.key}>
        <${ServerPicture} url=${of.picture} /><span>${of.name}</span>
        ${compareStore.chosen.value.length > 1 && html`<button type="button" aria-pressed=${order === 0} aria-label=${`Use as reference: ${of.name}`} title="Compare the others with it, at its exposure" onClick=${() => setReference(of)}>${order === 0 ? "reference" : "Use as reference"}</button>`}
        <button type="button" aria-label=${`Leave out ${of.name}`} title="Leave out" onClick=${() => toggle(of)}>×</button>
      </li>
    `)}
  </ol>
`;

const Chooser = () => html`
  <section class="chooser" aria-label="Materials to compare">
    <${Tray} />
    <div class="row">
      <button type="button" data-testid="compare-now" disabled=${compareStore.chosen.value.length < FEWEST || compareStore.comparing.value || compareStore.resultIsCurrent.value} onClick=${compareChosen}>
        ${compareStore.comparing.value ? "Comparing …" : compareStore.resultIsCurrent.value ? "Up to date" : `Compare ${compareStore.chosen.value.length < FEWEST ? "" : compareStore.chosen.value.length}`}
      </button>
      <span class="small">${FEWEST} to ${MOST}; the first is the reference, and sets the exposure.</span>
    </div>
    <details open=${compareStore.choicesOpen.value} data-testid="compare-choices" onToggle=${(/** @type {Event} */ event) => (compareStore.choicesOpen.value = /** @type {HTMLDetailsElement} */ (event.target).open)}>
      <summary>Choose from this brood, favourites and presets</summary>
      <${Group} title="This brood" of=${shownChoices()} />
      <${Group} title="Favourites" of=${favouriteChoices()} />
      <${Group} title="Presets" of=${lineageStore.presets.value.map(presetChoice)} />
    </details>
  </section>
`;

/**
 * A row of the table.
 * @param {{name: string, title?: string, of: Compared[], cell: (one: Compared, order: number) =>
 *   unknown, kind?: string}} props
 */
const Row = ({ name, title, of, cell, kind }) => html`
  <tr class=${kind}><th scope="row" title=${title}>${name}</th>${of.map((one, order) => html`<td key=${order}>${cell(one, order)}</td>`)}</tr>
`;

/** A colour scaled to a largest channel of 1, with its numbers. @param {number[]} rgb */
function Patch(rgb) {
  if (rgb.every((channel) => channel === 0)) return "none";
  const color = colorOf({ name: "specular", value: rgb });
  return html`<span class="swatch" style=${{ background: color ?? "none" }}></span>${rgb.map((channel) => channel.toFixed(2)).join(" ")}`;
}

/**
 * A number with as many digits as the rest of its row; a dash for none.
 * @param {number|null|undefined} value
 * @param {number} [digits]
 */
const number = (value, digits = 3) => (typeof value === "number" ? (Math.abs(value) < 1e4 ? value.toFixed(digits) : amount(value)) : "–");

/** @param {{of: Found, names: string[]}} props */
function Table({ of: { materials, exposure_ev, other_light_deg }, names }) {
  const side = (/** @type {string} */ src, /** @type {string} */ alt) => html`<${ServerPicture} url=${src} side=${256} alt=${alt} />`;
  const shared = { of: materials };
  return html`
    <div class="scroller" role="region" tabindex="0" aria-label="Pictures and figures" data-testid="compared">
      <table class="compared">
        <thead><tr><td></td>${names.map((name, order) => html`<th key=${order} scope="col"><span class=${`curve-${order} dot`} aria-hidden="true"></span>${name}${materials[order].layers.length > 0 && html`<span class="small">${modelsInWords(materials[order].layers)}</span>`}</th>`)}</tr></thead>
        <tbody>
          <${Row} ...${shared} name=${`at ${exposure_ev.toFixed(2)} EV`} title="One exposure for all, that of the reference" cell=${(/** @type {Compared} */ one, /** @type {number} */ order) => side(one.picture, names[order])} />
          <${Row} ...${shared} name="under another light" title=${`The light ${other_light_deg}° further on its circle`} cell=${(/** @type {Compared} */ one, /** @type {number} */ order) => side(one.other_light, `${names[order]} under another light`)} />
          <${Row} ...${shared} name="difference from the reference" title="Absolute difference of exposed linear values" cell=${(/** @type {Compared} */ one, /** @type {number} */ order) => (one.difference ? side(one.difference.picture, `Difference of ${names[order]} from ${names[0]}`) : html`<span class="small">reference</span>`)} />
          <${Row} ...${shared} kind="first" name="RMSE" title="Root mean square of the difference" cell=${(/** @type {Compared} */ one) => number(one.difference?.rmse, 4)} />
          <${Row} ...${shared} name="mean FLIP" title="How different the pictures look, 0 to 1" cell=${(/** @type {Compared} */ one) => number(one.difference?.flip, 4)} />
          <${Row} ...${shared} name="Fresnel rise" title="f in the mirror direction at 80°, relative to the normal; 1 for no rise" cell=${(/** @type {Compared} */ { phenomena }) => number(phenomena.fresnel_rise, 2)} />
          <${Row} ...${shared} name="largest albedo" title="Over all channels and angles; above 1 the material reflects more light than it receives" cell=${(/** @type {Compared} */ { phenomena }) => number(phenomena.largest_albedo)} />
          <${Row} ...${shared} name="energy kept over roughness" title="Least over largest albedo at 30° as the roughness varies; for models with a roughness" cell=${(/** @type {Compared} */ { phenomena }) => number(phenomena.energy_kept)} />
          <${Row} ...${shared} name="colour of the highlight" title="Colour added by the highlight at 45°, scaled to a largest channel of 1" cell=${(/** @type {Compared} */ { phenomena }) => Patch(phenomena.highlight)} />
          <${Row} ...${shared} name="colour of the body" title="Colour at 45° away from the mirror direction, scaled to a largest channel of 1" cell=${(/** @type {Compared} */ { phenomena }) => Patch(phenomena.body)} />
          <${Row} ...${shared} name="exposure range as the light circles" title="Least and largest automatic exposure in EV" cell=${(/** @type {Compared} */ { phenomena: { exposures_ev: [low, high] } }) => `${number(low, 2)} to ${number(high, 2)}`} />
        </tbody>
      </table>
    </div>
  `;
}

/** @param {{of: Found, names: string[]}} props */
const Charts = ({ of: { materials }, names }) => html`
  <div class="charts">
    <${Chart} id="chart-albedo" title="Directional albedo" words="Share of the light from one direction that is reflected, as luminance." axis="directional albedo" names=${names}
      lines=${materials.map(({ curves }) => curves.map(({ theta_deg, luminance }) => [theta_deg, luminance]))} />
    <${Chart} id="chart-mirror" title="Fresnel rise" words="f cos θᵢ cos θₒ in the mirror direction, relative to its value at the normal." axis="relative to the normal" names=${names}
      lines=${materials.map(({ curves }) => curves.map(({ theta_deg, mirror }) => [theta_deg, mirror]))} />
  </div>
`;

export function Comparison() {
  if (!compareStore.comparisonOpen.value) return null;
  const names = compareStore.result.value?.of.map(({ name }) => name) ?? [];
  return html`
    <dialog class="inspector comparison" data-testid="comparison" ref=${opened} aria-labelledby="comparison-title" onClose=${closeComparison}>
      <${DialogTitle} name="comparison" title="Comparison" labelId="comparison-title" />
      <div class="beside">
        <${Chooser} />
        <${ProblemBox} place="comparison" />
        ${compareStore.comparing.value && !compareStore.result.value && html`<p class="small" role="status">The server is rendering and measuring …</p>`}
        ${compareStore.result.value && html`<${Table} of=${compareStore.result.value.found} names=${names} /><${Charts} of=${compareStore.result.value.found} names=${names} />`}
      </div>
    </dialog>
  `;
}
