/** Form of a new search: target and options. */
import { lineageStore } from "../../lineage/store.js";
import { clearProblems } from "../../page/problem.js";
import {
  OBJECTIVES, STRATEGIES, hasIslands, hasObjective, centreAsStart, dialectMismatch, placeholderName, startSearch, updateDraft,
} from "../../search/draft.js";
import { searchStore } from "../../search/store.js";
import { counted, duration, nameOfTarget } from "../../search/words.js";
import { Choice, Switch, typed } from "../control.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";
import { What } from "./target.js";

const MEASURES = [
  { value: "seconds", name: "seconds", words: "search time without pauses" },
  { value: "generations", name: "generations", words: "the same result on every machine" },
  { value: "evaluations", name: "evaluations", words: "materials compared with the samples; the same result on every machine" },
];

/**
 * A text field.
 * @param {{id: "name"|"seconds"|"generations"|"seed"|"threads"|"islands", name: string,
 *   placeholder: string, words?: string, number?: boolean}} props
 */
function Field({ id, name, placeholder, words, number = true }) {
  const wrong = searchStore.wrongField.value === id;
  return html`
    <label class="entry">
      <span>${name}</span>
      <input type="text" inputmode=${number ? "decimal" : "text"} data-testid=${`search-${id}`} class=${number ? "short" : ""} value=${searchStore.draft.value[id]} placeholder=${placeholder}
        maxlength="200" autocomplete="off" aria-invalid=${wrong} aria-describedby=${wrong ? "search-wrong" : undefined} onInput=${(/** @type {Event} */ event) => updateDraft({ [id]: typed(event) })} />
      ${words && html`<span class="small">${words}</span>`}
    </label>
  `;
}

function Budget() {
  const { measure } = searchStore.draft.value;
  return html`
    <div class="entry" role="group" aria-label="Budget">
      <span>budget</span>
      <input type="text" inputmode="decimal" class="short" data-testid="search-budget" aria-label=${`Budget in ${measure}`} value=${searchStore.draft.value[measure]} autocomplete="off"
        aria-invalid=${searchStore.wrongField.value === measure} onInput=${(/** @type {Event} */ event) => updateDraft({ [measure]: typed(event) })} />
      <${Choice} id="search-measure" name="Budget in" value=${measure} options=${MEASURES} onInput=${(/** @type {any} */ to) => updateDraft({ measure: to })} />
      <span class="small">${MEASURES.find(({ value }) => value === measure)?.words}</span>
    </div>
  `;
}

const Strategy = () => html`
  <label class="entry">
    <span>strategy</span>
    <select data-testid="search-strategy" value=${searchStore.draft.value.strategy} aria-invalid=${searchStore.wrongField.value === "strategy"} onChange=${(/** @type {Event} */ event) => updateDraft({ strategy: typed(event) })}>
      <option value="" selected=${searchStore.draft.value.strategy === ""}>the server's choice</option>
      ${STRATEGIES.map((name) => html`<option key=${name} value=${name} selected=${searchStore.draft.value.strategy === name}>${name}</option>`)}
    </select>
  </label>
`;

const Objective = () => html`
  <label class="entry" title="The error that fits of lobes minimise">
    <span>objective</span>
    <select data-testid="search-objective" value=${searchStore.draft.value.objective} aria-invalid=${searchStore.wrongField.value === "objective"} onChange=${(/** @type {Event} */ event) => updateDraft({ objective: typed(event) })}>
      <option value="" selected=${searchStore.draft.value.objective === ""}>the strategy's own</option>
      ${OBJECTIVES.map(({ name, words }) => html`<option key=${name} value=${name} selected=${searchStore.draft.value.objective === name}>${name}: ${words}</option>`)}
    </select>
  </label>
`;

/** Lineage of the results, and the individual to start from. */
function Where() {
  const { into, start, strategy } = searchStore.draft.value;
  const open = lineageStore.lineage.value;
  const isBred = start && (strategy === "" || strategy === "gp");
  const centre = centreAsStart();
  const unfit = open ? dialectMismatch(open.dialect) : "";
  const places = [{ value: "own", name: "a new lineage" }, { value: "open", name: open?.name ?? "the open lineage", title: "The lineage that is open" }];
  return html`
    <div class="entry" role="group" aria-label="Save results in">
      <span>save results in</span>
      <${Choice} id="search-into" name="Save results in" value=${into} options=${open ? places : places.slice(0, 1)} onInput=${(/** @type {any} */ to) => updateDraft({ into: to })} />
      ${into === "open" && unfit && !isBred && html`<span class="small warning">The server may refuse “${open?.name}”: ${unfit}.</span>`}
    </div>
    <div class="entry" role="group" aria-label="Start from">
      <span>start from</span>
      ${start
        ? html`<span class="begin"><${ServerPicture} url=${start.of.thumbnail} /><span>${start.name}</span><button type="button" data-testid="search-start-clear" aria-label="Start from scratch" title="Start from scratch" onClick=${() => updateDraft({ start: null })}>×</button></span>
            ${unfit && html`<span class=${isBred ? "small" : "small warning"}>${isBred ? "Searched by genetic programming, in the same dialect" : `The server may refuse it: ${unfit}`}.</span>`}`
        : html`<span class="begin"><span>scratch</span>${centre && html`<button type="button" data-testid="search-start-centre" onClick=${() => updateDraft({ start: centre })}>Take the centre</button>`}</span>`}
    </div>
  `;
}

const How = () => html`
  <section class="how" aria-labelledby="how-title">
    <h3 id="how-title">How to search</h3>
    <${Budget} />
    <${Strategy} />
    ${hasObjective(searchStore.draft.value.strategy) && html`<${Objective} />`}
    <${Field} id="seed" name="seed" placeholder="1" words="the same seed gives the same results" />
    <${Field} id="threads" name="threads" placeholder="all" words="affects speed only" />
    ${hasIslands(searchStore.draft.value.strategy) && html`<${Field} id="islands" name="islands" placeholder="1" words="searches side by side, on other workers too, that share their best" />`}
    <div class="entry"><span>symmetry</span>
      <${Switch} id="search-mirrored" name="mirrored" on=${searchStore.draft.value.mirrored} title="The material is its own mirror image, so the fit treats left and right alike" onInput=${(/** @type {boolean} */ on) => updateDraft({ mirrored: on })} />
      <span class="small">the material is its own mirror image</span>
    </div>
    <${Where} />
    <${Field} id="name" name="name" placeholder=${placeholderName()} number=${false} />
  </section>
`;

/** The search in a sentence. */
function summary() {
  const { target, measure, strategy, into } = searchStore.draft.value;
  if (!target) return "Nothing is searched until you start.";
  const most = Number(searchStore.draft.value[measure]) || 0;
  const budget = measure === "seconds" ? duration(most) : counted(most, measure.slice(0, -1));
  return `Searches ${budget} for “${nameOfTarget(target)}”${strategy ? ` by ${strategy}` : ""}, into ${into === "open" ? `“${lineageStore.lineage.value?.name}”` : "a new lineage"}.`;
}

/** @param {Event} event */
function submit(event) {
  event.preventDefault();
  clearProblems("search");
  void startSearch();
}

export const NewSearch = () => html`
  <form class="asking" onSubmit=${submit} novalidate>
    <div class="beside"><div class="two"><${What} /><${How} /></div></div>
    <div class="foot">
      <div id="search-wrong"><${ProblemBox} place="search" /></div>
      <div class="row">
        <span class="small grow" data-testid="search-summary">${summary()}</span>
        <button type="submit" class="primary" data-testid="search-start" disabled=${!searchStore.draft.value.target || searchStore.upload.value !== null || searchStore.starting.value}>${searchStore.starting.value ? "Starting …" : "Start the search"}</button>
      </div>
    </div>
  </form>
`;
