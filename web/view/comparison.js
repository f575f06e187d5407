/**
 * Materials side by side: the choice, pictures, differences, curves, numbers. Owns the dialog and its words; what is chosen and
 * found is comparison.js's.
 *
 * @import { Compared, Comparison as Found, Vec3 } from "../types.js"
 * @import { Choice } from "../comparison.js"
 */
import {
  FEWEST, MOST, chosen, closeComparison, compareChosen, compared, comparing, favourites, isChosen, isCurrent, offering, ofPreset, onStage,
  putFirst, toggle, waiting,
} from "../comparison.js";
import { html } from "../html.js";
import { colorOf, modelsInWords } from "../layers.js";
import { presets } from "../presets.js";
import { Chart } from "./chart.js";
import { modal, shut } from "./dialog.js";
import { Trouble } from "./trouble.js";
import { amount } from "./words.js";

const opened = modal();

/** One that can be chosen. @param {Choice} of */
function Tile(of) {
  const on = isChosen(of);
  return html`
    <li key=${of.key}>
      <button type="button" class="tile" aria-pressed=${on} aria-label=${of.name} title=${of.name} data-testid=${`compare-${of.key}`} disabled=${!on && chosen.value.length >= MOST} onClick=${() => toggle(of)}>
        <img src=${of.picture} alt="" loading="lazy" />
      </button>
    </li>
  `;
}

/** @param {{title: string, of: Choice[]}} props */
const Group = ({ title, of }) => of.length > 0 && html`<h3>${title}</h3><ul class="gallery" aria-label=${title}>${of.map(Tile)}</ul>`;

/** What is chosen, each to be left out again. */
const Tray = () => html`
  <ol class="tray" aria-label="Chosen">
    ${chosen.value.map((of, order) => html`
      <li key=${of.key}>
        <img src=${of.picture} alt="" /><span>${of.name}</span>
        ${chosen.value.length > 1 && html`<button type="button" aria-pressed=${order === 0} aria-label=${`1st: ${of.name}`} title="Hold the others against it, at its exposure" onClick=${() => putFirst(of)}>1st</button>`}
        <button type="button" aria-label=${`Leave out ${of.name}`} title="Leave out" onClick=${() => toggle(of)}>×</button>
      </li>
    `)}
  </ol>
`;

const Chooser = () => html`
  <section class="chooser" aria-label="What is compared">
    <${Tray} />
    <div class="row">
      <button type="button" data-testid="compare-now" disabled=${chosen.value.length < FEWEST || waiting.value || isCurrent.value} onClick=${compareChosen}>
        ${waiting.value ? "Comparing …" : isCurrent.value ? "Compared" : `Compare ${chosen.value.length < FEWEST ? "" : chosen.value.length}`}
      </button>
      <span class="small">${FEWEST} to ${MOST}; the others are held against the first, at its exposure.</span>
    </div>
    <details open=${offering.value} data-testid="compare-choices" onToggle=${(/** @type {Event} */ event) => (offering.value = /** @type {HTMLDetailsElement} */ (event.target).open)}>
      <summary>Choose from this brood, favourites and presets</summary>
      <${Group} title="This brood" of=${onStage()} />
      <${Group} title="Favourites" of=${favourites()} />
      <${Group} title="Presets" of=${presets.value.map(ofPreset)} />
    </details>
  </section>
`;

/** A row of the table. @param {{name: string, title?: string, of: Compared[], cell: (one: Compared, order: number) => unknown, kind?: string}} props */
const Row = ({ name, title, of, cell, kind }) => html`
  <tr class=${kind}><th scope="row" title=${title}>${name}</th>${of.map((one, order) => html`<td key=${order}>${cell(one, order)}</td>`)}</tr>
`;

/** A colour whose largest channel is 1, and its numbers; black where there is none. @param {Vec3} rgb */
function Patch(rgb) {
  if (rgb.every((channel) => channel === 0)) return "none";
  const color = colorOf({ name: "specular", value: rgb });
  return html`<span class="swatch" style=${{ background: color ?? "none" }}></span>${rgb.map((channel) => channel.toFixed(2)).join(" ")}`;
}

/** A number with as many digits as all of its row; none where there is none. @param {number|null|undefined} value @param {number} [digits] */
const number = (value, digits = 3) => (typeof value === "number" ? (Math.abs(value) < 1e4 ? value.toFixed(digits) : amount(value)) : "–");

/** @param {{of: Found, names: string[]}} props */
function Table({ of: { materials, exposure_ev, other_light_deg }, names }) {
  const side = (/** @type {string} */ src, /** @type {string} */ alt) => html`<img src=${src} width="256" height="256" alt=${alt} />`;
  const shared = { of: materials };
  return html`
    <div class="scroller" role="region" tabindex="0" aria-label="Pictures and numbers" data-testid="compared">
      <table class="compared">
        <thead><tr><td></td>${names.map((name, order) => html`<th key=${order} scope="col"><span class=${`curve-${order} dot`} aria-hidden="true"></span>${name}${materials[order].layers.length > 0 && html`<span class="small">${modelsInWords(materials[order].layers)}</span>`}</th>`)}</tr></thead>
        <tbody>
          <${Row} ...${shared} name=${`at ${exposure_ev.toFixed(2)} EV`} title="One exposure for all, that of the first: what is darker looks so" cell=${(/** @type {Compared} */ one, /** @type {number} */ order) => side(one.picture, names[order])} />
          <${Row} ...${shared} name="under another light" title=${`The light ${other_light_deg}° further around`} cell=${(/** @type {Compared} */ one, /** @type {number} */ order) => side(one.other_light, `${names[order]} under another light`)} />
          <${Row} ...${shared} name="difference from the first" title="Absolute, of linear values as exposed" cell=${(/** @type {Compared} */ one, /** @type {number} */ order) => (one.difference ? side(one.difference.picture, `Difference of ${names[order]} from ${names[0]}`) : html`<span class="small">the others are held against this</span>`)} />
          <${Row} ...${shared} kind="first" name="RMSE" title="Root mean square of the difference" cell=${(/** @type {Compared} */ one) => number(one.difference?.rmse, 4)} />
          <${Row} ...${shared} name="mean FLIP" title="How different the pictures look, 0 to 1" cell=${(/** @type {Compared} */ one) => number(one.difference?.flip, 4)} />
          <${Row} ...${shared} name="Fresnel rise" title="The mirror direction at 80° over that at the normal; 1 where nothing changes" cell=${(/** @type {Compared} */ { phenomena }) => number(phenomena.fresnel_rise, 2)} />
          <${Row} ...${shared} name="largest albedo" title="Of any channel and angle: above 1 more light is given back than came" cell=${(/** @type {Compared} */ { phenomena }) => number(phenomena.largest_albedo)} />
          <${Row} ...${shared} name="energy kept over roughness" title="The albedo at 30° as highlights go from narrow to wide, least over largest; for models with such a parameter" cell=${(/** @type {Compared} */ { phenomena }) => number(phenomena.energy_kept)} />
          <${Row} ...${shared} name="colour of the highlight" title="What the highlight adds at 45°, largest channel 1" cell=${(/** @type {Compared} */ { phenomena }) => Patch(phenomena.highlight)} />
          <${Row} ...${shared} name="colour of the body" title="At 45°, away from the mirror direction, largest channel 1" cell=${(/** @type {Compared} */ { phenomena }) => Patch(phenomena.body)} />
          <${Row} ...${shared} name="exposures around the light" title="Least and largest automatic exposure, in EV, as the light goes around" cell=${(/** @type {Compared} */ { phenomena: { exposures_ev: [low, high] } }) => `${number(low, 2)} to ${number(high, 2)}`} />
        </tbody>
      </table>
    </div>
  `;
}

/** @param {{of: Found, names: string[]}} props */
const Charts = ({ of: { materials }, names }) => html`
  <div class="charts">
    <${Chart} id="chart-albedo" title="How much is reflected" words="The share of light from one direction that is sent back in all, as luminance." axis="directional albedo" names=${names}
      lines=${materials.map(({ curves }) => curves.map(({ theta_deg, luminance }) => [theta_deg, luminance]))} />
    <${Chart} id="chart-mirror" title="How the mirror direction brightens" words="f cos θᵢ cos θₒ towards the mirror direction, over the same at the normal: the Fresnel rise." axis="over that at the normal" names=${names}
      lines=${materials.map(({ curves }) => curves.map(({ theta_deg, mirror }) => [theta_deg, mirror]))} />
  </div>
`;

export function Comparison() {
  if (!comparing.value) return null;
  const names = compared.value?.of.map(({ name }) => name) ?? [];
  return html`
    <dialog class="inspector comparison" data-testid="comparison" ref=${opened} aria-labelledby="comparison-title" onClose=${closeComparison}>
      <div class="row title">
        <h2 id="comparison-title">Comparison</h2>
        <span class="grow"></span>
        <button type="button" data-testid="comparison-close" onClick=${shut}>Close</button>
      </div>
      <div class="beside">
        <${Chooser} />
        <${Trouble} place="comparison" />
        ${waiting.value && !compared.value && html`<p class="small" role="status">The server renders and measures them …</p>`}
        ${compared.value && html`<${Table} of=${compared.value.found} names=${names} /><${Charts} of=${compared.value.found} names=${names} />`}
      </div>
    </dialog>
  `;
}
