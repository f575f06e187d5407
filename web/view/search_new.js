/**
 * The form of a new search: what is to be matched, and how. Owns the words of how; what is matched is search_target.js's, what is
 * filled in the draft's.
 */
import { html } from "../html.js";
import { STRATEGIES, centreAsStart, draft, fill, misfit, placeholderName, startSearch, starting, wrongField } from "../search_draft.js";
import { sending } from "../search_target.js";
import { counted, duration, nameOfTarget } from "../search_words.js";
import { forget, lineage } from "../state.js";
import { Choice, Switch } from "./control.js";
import { What } from "./search_target.js";
import { Trouble } from "./trouble.js";

const MEASURES = [
  { value: "seconds", name: "seconds", words: "time searched; pauses do not count" },
  { value: "generations", name: "generations", words: "the same result on every machine" },
  { value: "evaluations", name: "evaluations", words: "materials held against samples; the same result on every machine" },
];

/** @param {Event} event */
const typed = (event) => /** @type {HTMLInputElement} */ (event.target).value;

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
      <span class="small">${MEASURES.find(({ value }) => value === measure)?.words}</span>
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
  const { target, measure, strategy, into } = draft.value;
  if (!target) return "Nothing is searched before you start it.";
  const most = Number(draft.value[measure]) || 0;
  const budget = measure === "seconds" ? duration(most) : counted(most, measure.slice(0, -1));
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
        <button type="submit" class="primary" data-testid="search-start" disabled=${!draft.value.target || sending.value !== null || starting.value}>${starting.value ? "Starting …" : "Start the search"}</button>
      </div>
    </div>
  </form>
`;
