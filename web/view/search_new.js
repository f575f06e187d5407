/**
 * The form of a new search: what is to be matched, as the server understood it, and how. Owns the form's words; what is filled in is
 * search_draft.js's.
 *
 * @import { Target } from "../types.js"
 */
import { html } from "../html.js";
import {
  STRATEGIES, centreAsStart, chooseTarget, draft, fill, misfit, placeholderName, readAs, readTargets, reading, removeTarget, startSearch, starting,
  takeTarget, targets, wrongField,
} from "../search_draft.js";
import { KINDS, counted, duration, kindInWords, nameOfTarget, sizeInWords } from "../search_words.js";
import { fileOver, forget, lineage } from "../state.js";
import { Choice, Switch } from "./control.js";
import { Trouble } from "./trouble.js";
import { amount } from "./words.js";

const ACCEPTED = ".csv,.exr,.binary,.bsdf,.brdf";
const MEASURES = [{ value: "seconds", name: "seconds" }, { value: "generations", name: "generations", title: "The same result on every machine" }];

/** @param {Event} event */
const typed = (event) => /** @type {HTMLInputElement} */ (event.target).value;

/** @param {Event} event */
function fileChosen(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  takeTarget(input.files?.[0]);
  // The same file may be chosen again after it was mended.
  input.value = "";
}

/** Whether the targets were asked for since the form opened. @param {HTMLElement|null} element */
const opened = (element) => element && void readTargets();

function Drop() {
  const { file } = draft.value;
  return html`
    <label class=${fileOver.value ? "well over" : "well"}>
      <input type="file" accept=${ACCEPTED} data-testid="target-file" aria-label="Choose a file of measurements" onChange=${fileChosen} />
      <span>${file ? html`<strong>${file.name}</strong> <span class="small">${sizeInWords(file.size)}</span>` : html`<strong>Drop a file here</strong>, or choose one`}</span>
      <span class="small">${file ? "Drop or choose another to take its place" : "samples .csv, image slice .exr, MERL .binary, RGL .bsdf, goniometer .brdf"}</span>
    </label>
  `;
}

function Kind() {
  const { file, kind } = draft.value;
  if (!file) return null;
  return html`
    <label class="entry">
      <span>read as</span>
      <select data-testid="target-kind" value=${kind} onChange=${(/** @type {Event} */ event) => readAs(/** @type {any} */ (typed(event)))}>
        ${kind === "" && html`<option value="" selected disabled>what is it?</option>`}
        ${KINDS.map(({ value, name }) => html`<option key=${value} value=${value} selected=${value === kind}>${name}</option>`)}
      </select>
      ${kind === "" && html`<span class="small">The name does not tell what the file is.</span>`}
    </label>
  `;
}

/** @param {{name: string, value: unknown, title?: string}} props */
const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** What the server found in the file. @param {{of: Target}} props */
const Understood = ({ of }) => html`
  <div class="understood" data-testid="target-understood" role="status">
    <h3>As understood</h3>
    <dl>
      <${Fact} name="kind" value=${kindInWords(of.kind)} />
      <${Fact} name="samples" value=${of.samples.toLocaleString("en")} />
      <${Fact} name="fitted to" value=${of.fitted_samples.toLocaleString("en")} title="The search sees these" />
      <${Fact} name="held out" value=${of.held_out_samples.toLocaleString("en")} title="The search never sees these: errors are told by them" />
      ${of.skipped_samples > 0 && html`<${Fact} name="skipped" value=${of.skipped_samples.toLocaleString("en")} title="Negative, or not finite, or below the horizon" />`}
      <${Fact} name="largest f" value=${`${amount(of.largest_f)} per sr`} />
      <${Fact} name="reciprocal floor" value=${of.reciprocal_floor === null ? "not known" : amount(of.reciprocal_floor)}
        title="The measurement differs that much from itself where light and eye change places; nothing reciprocal comes closer" />
    </dl>
    <p class="small">${of.reciprocal_floor === null
      ? "No pair was measured both ways round, so how close a reciprocal material can come is not known."
      : "The floor is how much it differs from itself with light and eye exchanged: nothing reciprocal comes closer."}</p>
  </div>
`;

/** One that is here already. @param {Target} of */
const Known = (of) => {
  const on = draft.value.target?.id === of.id;
  return html`
    <li key=${of.id}>
      <button type="button" class=${on ? "grow on" : "grow"} aria-pressed=${on} data-testid=${`target-${of.id}`} onClick=${() => chooseTarget(of)}>
        <span class="cut">${nameOfTarget(of)}</span> <span class="small">${of.kind === "samples" ? "" : `${kindInWords(of.kind)}, `}${counted(of.samples, "sample")}</span>
      </button>
      <button type="button" class="remove" aria-label=${`Remove ${nameOfTarget(of)}`} title="Remove" onClick=${() => removeTarget(of)}>×</button>
    </li>
  `;
};

const What = () => html`
  <section class="what" aria-labelledby="what-title" ref=${opened}>
    <h3 id="what-title">What to match</h3>
    <${Drop} />
    <${Kind} />
    ${reading.value && html`<p class="small" role="status">The server reads it …</p>`}
    <${Trouble} place="target" />
    ${draft.value.target && !reading.value && html`<${Understood} of=${draft.value.target} />`}
    ${targets.value.length > 0 && html`
      <details open=${!draft.value.file && !draft.value.target}>
        <summary>Or one that is here already (${targets.value.length})</summary>
        <ul class="known" aria-label="Targets">${targets.value.map(Known)}</ul>
      </details>
    `}
  </section>
`;

/**
 * A field that is typed into.
 * @param {{id: "name"|"seconds"|"generations"|"seed"|"threads", name: string, placeholder: string, words?: string, number?: boolean}} props
 */
function Field({ id, name, placeholder, words, number = true }) {
  const wrong = wrongField.value === id;
  return html`
    <label class="entry">
      <span>${name}</span>
      <input type="text" inputmode=${number ? "decimal" : "text"} data-testid=${`search-${id}`} class=${number ? "short" : ""} value=${draft.value[id]} placeholder=${placeholder}
        maxlength="200" autocomplete="off" aria-invalid=${wrong} aria-describedby=${wrong ? "search-wrong" : undefined} onInput=${(/** @type {Event} */ event) => fill({ [id]: typed(event) })} />
      ${words && html`<span class="small">${words}</span>`}
    </label>
  `;
}

function Budget() {
  const { measure } = draft.value;
  return html`
    <div class="entry" role="group" aria-label="Budget">
      <span>budget</span>
      <input type="text" inputmode="decimal" class="short" data-testid="search-budget" aria-label=${`Budget in ${measure}`} value=${draft.value[measure]} autocomplete="off"
        aria-invalid=${wrongField.value === measure} onInput=${(/** @type {Event} */ event) => fill({ [measure]: typed(event) })} />
      <${Choice} id="search-measure" name="Budget in" value=${measure} options=${MEASURES} turns=${(/** @type {any} */ to) => fill({ measure: to })} />
      <span class="small">${measure === "seconds" ? "time searched; pauses do not count" : "the same result on every machine"}</span>
    </div>
  `;
}

const Strategy = () => html`
  <label class="entry">
    <span>strategy</span>
    <select data-testid="search-strategy" value=${draft.value.strategy} aria-invalid=${wrongField.value === "strategy"} onChange=${(/** @type {Event} */ event) => fill({ strategy: typed(event) })}>
      <option value="" selected=${draft.value.strategy === ""}>the server's choice</option>
      ${STRATEGIES.map((name) => html`<option key=${name} value=${name} selected=${draft.value.strategy === name}>${name}</option>`)}
    </select>
  </label>
`;

/** Where finds are born, and what the search starts from. */
function Where() {
  const { into, start, strategy } = draft.value;
  const open = lineage.value;
  const isBred = start && (strategy === "" || strategy === "gp");
  const centre = centreAsStart();
  const unfit = open ? misfit(open.dialect) : "";
  const places = [{ value: "own", name: "a new lineage" }, { value: "open", name: open?.name ?? "the open lineage", title: "The lineage that is open" }];
  return html`
    <div class="entry" role="group" aria-label="Finds are born in">
      <span>finds go into</span>
      <${Choice} id="search-into" name="Finds are born in" value=${into} options=${open ? places : places.slice(0, 1)} turns=${(/** @type {any} */ to) => fill({ into: to })} />
      ${into === "open" && unfit && !isBred && html`<span class="small warning">The server may refuse “${open?.name}”: ${unfit}.</span>`}
    </div>
    <div class="entry" role="group" aria-label="Starts from">
      <span>starts from</span>
      ${start
        ? html`<span class="begin"><img src=${start.of.thumbnail} alt="" /><span>${start.name}</span><button type="button" data-testid="search-start-clear" aria-label="Start from nothing" title="Start from nothing" onClick=${() => fill({ start: null })}>×</button></span>
            ${unfit && html`<span class=${isBred ? "small" : "small warning"}>${isBred ? "Searched by genetic programs, which stay what it is" : `The server may refuse it: ${unfit}`}.</span>`}`
        : html`<span class="begin"><span>nothing</span>${centre && html`<button type="button" data-testid="search-start-centre" onClick=${() => fill({ start: centre })}>Take the centre</button>`}</span>`}
    </div>
  `;
}

const How = () => html`
  <section class="how" aria-labelledby="how-title">
    <h3 id="how-title">How to search</h3>
    <${Budget} />
    <${Strategy} />
    <${Field} id="seed" name="seed" placeholder="1" words="the same seed, the same finds" />
    <${Field} id="threads" name="threads" placeholder="all" words="they change no result, only the time" />
    <div class="entry"><span>symmetry</span>
      <${Switch} id="search-mirrored" name="mirrored" on=${draft.value.mirrored} title="The material is its own mirror image: the fit need not tell left from right" turns=${(/** @type {boolean} */ on) => fill({ mirrored: on })} />
      <span class="small">the material is its own mirror image</span>
    </div>
    <${Where} />
    <${Field} id="name" name="name" placeholder=${placeholderName()} number=${false} />
  </section>
`;

/** What will happen, in a sentence. */
function summary() {
  const { target, measure, seconds, generations, strategy, into } = draft.value;
  if (!target) return "Nothing is searched before you start it.";
  const budget = measure === "seconds" ? duration(Number(seconds) || 0) : counted(Number(generations) || 0, "generation");
  return `Searches ${budget} for “${nameOfTarget(target)}”${strategy ? ` by ${strategy}` : ""}, into ${into === "open" ? `“${lineage.value?.name}”` : "a new lineage"}.`;
}

/** @param {Event} event */
function submit(event) {
  event.preventDefault();
  forget("search");
  void startSearch();
}

export const NewSearch = () => html`
  <form class="asking" onSubmit=${submit} novalidate>
    <div class="beside"><div class="two"><${What} /><${How} /></div></div>
    <div class="foot">
      <div id="search-wrong"><${Trouble} place="search" /></div>
      <div class="row">
        <span class="small grow" data-testid="search-summary">${summary()}</span>
        <button type="submit" class="primary" data-testid="search-start" disabled=${!draft.value.target || reading.value || starting.value}>${starting.value ? "Starting …" : "Start the search"}</button>
      </div>
    </div>
  </form>
`;
