/**
 * The find that is chosen: its picture under its own light or another, its figures, and what can be done with it. Owns their words.
 *
 * @import { Found, Job } from "../types.js"
 */
import { pin } from "../compare.js";
import { html } from "../html.js";
import { openInspector } from "../inspector.js";
import { breedFound, chosen, front, individuals, openLineageOf, showFound } from "../search_job.js";
import { heldLight, isComing, light, picture } from "../search_picture.js";
import { errorInWords, hasEnded } from "../search_words.js";
import { closeSearches } from "../searches.js";
import { Slider } from "./control.js";
import { Exports, listFormats } from "./exports.js";
import { Trouble } from "./trouble.js";

/** @param {{name: string, value: unknown, title?: string}} props */
const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** @param {Found} of */
const nameOf = (of) => (of === front.value[0] ? "the best" : `a find of ${of.operations} operations`);

/** Puts the light back where its lineage has it. */
function restLight() {
  light.value = null;
  heldLight.value = null;
}

/** The light goes around, to angles that nobody looked at. */
function Light() {
  const at = heldLight.value ?? light.value;
  /** @param {number} to */
  const rest = (to) => {
    light.value = to;
    heldLight.value = null;
  };
  return html`
    <div class="held-light">
      <${Slider} id="found-light" name="another light" value=${at ?? 0} min=${0} max=${355} step=${5} dim=${at === null} shown=${at === null ? "its own" : `${at}°`}
        title="How it looks under a light that stands elsewhere" turns=${(/** @type {number} */ to) => (heldLight.value = to)} rests=${rest} />
      <button type="button" data-testid="found-light-rest" disabled=${at === null} aria-label="Back to its own light" title="Back to its own light" onClick=${restLight}>↺</button>
    </div>
  `;
}

/** @param {{of: Found|null, waits: string}} props */
function Picture({ of, waits }) {
  const there = picture.value;
  return html`
    <div class=${isComing.value && there ? "best coming" : "best"} aria-busy=${isComing.value} data-testid="found-picture">
      ${of && there
        ? html`<img src=${there.url} width="384" height="384" alt=${`${nameOf(of)}${light.value === null ? "" : ` under a light at ${light.value}°`}`} />`
        : html`<p class="small hollow">${of ? "Its picture is drawn …" : waits}</p>`}
    </div>
  `;
}

/** @param {{of: Found}} props */
const Figures = ({ of }) => html`
  <dl>
    <${Fact} name="error, held out" value=${errorInWords(of.e_log)} title="E log: root mean square of the differences of log(1 + f cos), on samples that the search never saw" />
    <${Fact} name="error, fitted" value=${errorInWords(of.e_log_fitted)} title="The same on the samples it was fitted to" />
    <${Fact} name="E cube root" value=${errorInWords(of.e_cbrt)} title="The same kind of error of cube roots" />
    <${Fact} name="relative L2" value=${errorInWords(of.relative_l2)} />
    <${Fact} name="operations" value=${of.operations.toLocaleString("en")} title="Scalar operations a sample, under the energy limit" />
    <${Fact} name="numbers" value=${of.numbers.toLocaleString("en")} title="Numbers that were fitted" />
    <${Fact} name="divisor" value=${Number(of.divisor.toPrecision(4))} title="By what the energy limit divides; 1 where it has nothing to do" />
    <${Fact} name="found in" value=${`generation ${of.generation}`} />
  </dl>
`;

/** @param {{of: Found, within: Job}} props */
function Deeds({ of, within }) {
  const one = individuals.value.get(of.individual);
  const name = nameOf(of);
  const inspect = () => one && openInspector(one, `${name} of ${within.name}`);
  const toB = () => {
    if (!one) return;
    pin(one, name);
    closeSearches();
  };
  if (one) listFormats("found");
  return html`
    <div class="deeds-of">
      <button type="button" class="primary" data-testid="found-breed" title="Twenty children around it, in its lineage" onClick=${() => breedFound(of)}>Breed from it</button>
      <button type="button" data-testid="found-show" title="Where it was born" onClick=${() => showFound(of)}>Show in lineage</button>
      <button type="button" data-testid="found-inspect" disabled=${!one} onClick=${inspect}>Inspect</button>
      <button type="button" data-testid="found-pin" disabled=${!one} title="Beside what is bred, as B" onClick=${toB}>Pin as B</button>
    </div>
    ${one && html`<${Exports} of=${one} place="found" />`}
  `;
}

/** @param {{of: Job, waits: string}} props */
export function FoundView({ of: within, waits }) {
  const of = chosen.value;
  return html`
    <section class="found-one" aria-labelledby="found-title">
      <h3 id="found-title">${of && front.value.length > 1 && of !== front.value[0] ? "Chosen from the front" : hasEnded(within) ? "The best" : "Best so far"}</h3>
      <${Picture} of=${of} waits=${waits} />
      ${of && html`<${Light} /><${Figures} of=${of} /><${Deeds} of=${of} within=${within} />`}
      <${Trouble} place="found" />
      <button type="button" class="link" data-testid="job-lineage" title="All that was found on the way, in order" onClick=${() => openLineageOf(within)}>Open its lineage</button>
    </section>
  `;
}

