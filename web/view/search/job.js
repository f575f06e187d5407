/**
 * View of one search: state, actions, charts, front.
 *
 * @import { Found, Job } from "../../model.js"
 */
import { slug } from "../../page/file_name.js";
import { changeState } from "../../search/job.js";
import { searchStore } from "../../search/store.js";
import { searchAgain } from "../../search/target.js";
import {
  budgetInWords, canBe, choiceInWords, counted, duration, errorInWords, hasEnded, kindInWords,
  nameOfTarget, reasonInWords, stateInWords,
} from "../../search/words.js";
import { Archive } from "../archive.js";
import { Fact } from "../control.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";
import { Course, FrontChart } from "./charts.js";
import { FoundView } from "./found.js";

/** @param {{titled: (element: HTMLElement|null) => void}} props */
export const JobTitle = ({ titled }) => html`
  <h2 id="searches-title" class="named" tabindex="-1" ref=${titled}><span class="cut">${searchStore.job.value?.name ?? "Search"}</span></h2>
  ${searchStore.job.value && html`<span class=${`state ${searchStore.job.value.state}`} data-testid="job-state">${stateInWords(searchStore.job.value.state)}</span>`}
`;

/**
 * Focuses the question, because it replaces the button that had the focus.
 * @param {HTMLElement|null} element
 */
const focusQuestion = (element) => element?.focus();

/** @param {{of: Job}} props */
function Actions({ of }) {
  const can = canBe(of);
  if (searchStore.confirmingCancel.value && can.cancelled) {
    return html`
      <div class="row" role="group" aria-label="Cancel the search?">
        <span>Cancel this search? Its results so far are kept.</span>
        <button type="button" data-testid="job-cancel-yes" ref=${focusQuestion} onClick=${() => changeState("cancel")}>Cancel the search</button>
        <button type="button" onClick=${() => (searchStore.confirmingCancel.value = false)}>Keep searching</button>
      </div>
    `;
  }
  return html`
    <div class="row" role="group" aria-label="The search">
      ${of.state === "paused"
        ? html`<button type="button" data-testid="job-resume" disabled=${!can.resumed} onClick=${() => changeState("resume")}>Resume</button>`
        : html`<button type="button" data-testid="job-pause" disabled=${!can.paused} onClick=${() => changeState("pause")}>Pause</button>`}
      <button type="button" data-testid="job-cancel" disabled=${!can.cancelled} onClick=${() => (searchStore.confirmingCancel.value = true)}>Cancel</button>
      ${hasEnded(of) && searchStore.target.value && html`<button type="button" data-testid="job-again" title="A new search for the same target, with options to change" onClick=${() => searchStore.target.value && searchAgain(of, searchStore.target.value)}>Search again …</button>`}
    </div>
  `;
}

/** @param {{of: Job}} props */
const Progress = ({ of }) => html`
  <div class="going">
    <progress max="1" value=${of.state === "succeeded" ? 1 : of.progress} aria-label="Progress"></progress>
    <p class="small" data-testid="job-figures">
      <span>${Math.floor(100 * (of.state === "succeeded" ? 1 : of.progress))} % of ${budgetInWords(of.budget)}</span>
      <span>generation ${of.generation.toLocaleString("en")}</span>
      <span>${counted(of.evaluations, "evaluation")}</span>
      <span>${duration(of.seconds)} searched</span>
    </p>
  </div>
`;

/** @param {{of: Job}} props */
const Failed = ({ of }) => of.state === "failed" && html`
  <div class="trouble" role="alert" data-testid="job-reason"><p><strong>The search failed.</strong> ${sentence(reasonInWords(of.reason))}${searchStore.front.value.length > 0 ? " Its results so far are kept." : ""}</p></div>
`;

/** Reasons of the server have no capital and no full stop. @param {string} words */
const sentence = (words) => words.charAt(0).toUpperCase() + words.slice(1) + (/[.!?]$/.test(words) ? "" : ".");

/** Options with which the search was started. @param {{of: Job}} props */
function About({ of }) {
  const to = searchStore.target.value;
  return html`
    <section class="asked" aria-labelledby="asked-title">
      <h3 id="asked-title">Options</h3>
      <dl>
        ${!to && searchStore.targetRead.value && html`<${Fact} name="target" value="deleted" />`}
        ${to && html`<${Fact} name="target" value=${nameOfTarget(to)} /><${Fact} name="kind" value=${kindInWords(to.kind)} /><${Fact} name="samples" value=${`${to.fitted_samples.toLocaleString("en")} fitted, ${to.held_out_samples.toLocaleString("en")} held out`} />`}
        ${typeof to?.reciprocal_floor === "number" && html`<${Fact} name="reciprocal floor" value=${errorInWords(to.reciprocal_floor)} title="Least error of a reciprocal material on the measurement as it is; where all directions were measured, the errors here are measured on the mean of both orders of light and eye" />`}
        <${Fact} name="strategy" value=${of.strategy} />
        ${of.objective && html`<${Fact} name="objective" value=${of.objective} title="Error that the search minimises" />`}
        <${Fact} name="budget" value=${budgetInWords(of.budget)} />
        <${Fact} name="seed" value=${of.seed} />
        <${Fact} name="threads" value=${of.threads ?? "all"} />
        ${of.islands > 1 && html`<${Fact} name="islands" value=${of.islands} title="Searches side by side that share their best" />`}
        ${of.mirrored && html`<${Fact} name="symmetry" value="mirrored" />`}
        ${of.start.length > 0 && html`<${Fact} name="started from" value=${counted(of.start.length, "individual")} />`}
        <${Fact} name="started" value=${new Date(of.created_ms).toLocaleString()} />
      </dl>
    </section>
  `;
}

/** @param {Found} of */
const pick = (of) => (searchStore.pickedId.value = of.individual);

/** @type {string|undefined} */
let scrolledTo;

/** Scrolls to the chosen row, once. @param {HTMLElement|null} row */
function scrollToOnce(row) {
  if (!row || row.dataset.find === scrolledTo) return;
  scrolledTo = row.dataset.find;
  // Scrolls the table only, so that what was clicked stays under the pointer.
  const around = /** @type {HTMLElement|null} */ (row.closest(".scroller"));
  if (!around) return;
  const head = 28;
  if (row.offsetTop - head < around.scrollTop) around.scrollTop = row.offsetTop - head;
  else if (row.offsetTop + row.offsetHeight > around.scrollTop + around.clientHeight) around.scrollTop = row.offsetTop + row.offsetHeight - around.clientHeight;
}

/** @param {{of: Found[]}} props */
const Table = ({ of }) => html`
  <div class="scroller" role="region" tabindex="0" aria-label="Front as a table">
    <table class="finds" data-testid="front-table">
      <thead><tr><th scope="col" title="E log on samples that are not fitted">held out</th><th scope="col" title="E log on training and validation samples">fitted</th><th scope="col">operations</th><th scope="col">free parameters</th></tr></thead>
      <tbody>
        ${of.map((one) => {
          const on = one.individual === searchStore.chosenResult.value?.individual;
          return html`
            <tr key=${one.individual} ref=${on ? scrollToOnce : undefined} data-find=${one.individual} class=${on ? "on" : ""} onClick=${() => pick(one)}>
              <td>${one === of[0] && html`<span class="tag">best</span> `}<button type="button" aria-pressed=${on} aria-label=${`Choose the result of error ${errorInWords(one.e_log)}${one === of[0] ? ", the best" : ""}`} onClick=${() => pick(one)}>${errorInWords(one.e_log)}</button></td>
              <td>${errorInWords(one.e_log_fitted)}</td><td>${one.operations.toLocaleString("en")}</td><td>${one.numbers.toLocaleString("en")}</td>
            </tr>
          `;
        })}
      </tbody>
    </table>
  </div>
`;

/** Text in place of a front. @param {Job} of */
function frontPlaceholder(of) {
  if (!hasEnded(of)) return "When the search ends, shorter results appear here, each with its error.";
  if (searchStore.front.value.length === 0) return resultPlaceholder(of);
  return of.state === "succeeded" ? "No shorter result was worth keeping." : "A cancelled search keeps only its best result.";
}

/** @param {{of: Job}} props */
function Front({ of }) {
  const count = searchStore.front.value.length;
  return html`
    <figure class="chart" data-testid="search-front">
      <h3 title="Held out: samples that are not fitted">E log, held out, against length</h3>
      ${searchStore.front.value.length > 1
        ? html`<${FrontChart} of=${searchStore.front.value} chosen=${searchStore.chosenResult.value} onPick=${pick} /><${Table} of=${searchStore.front.value} />
          <p class="small" data-testid="front-choice">${choiceInWords(searchStore.front.value)}</p>`
        : html`<p class="small hollow">${frontPlaceholder(of)}</p>`}
      ${hasEnded(of) && count > 0 && html`<${Archive} flat id="front-export" title=${count > 1 ? `Export all ${count}` : "Export as ZIP"} members=${{ job: of.id }} count=${count} what=${count > 1 ? `all ${count}` : "it"} name=${`${slug(of.name)}-front.zip`} place="job" />`}
    </figure>
  `;
}

/** Text while there is no result. @param {Job} of */
function resultPlaceholder(of) {
  if (of.state === "queued") return "Waiting for a worker.";
  if (hasEnded(of)) return "The search ended without a result.";
  return of.state === "paused" ? "Paused, without a result so far." : "Waiting for the first generation …";
}

export function JobView() {
  const of = searchStore.job.value;
  if (!of) return html`<div class="beside"><${ProblemBox} place="job" /><p class="small" role="status">Loading …</p></div>`;
  return html`
    <div class="beside of-job">
      <div class="standing"><${Progress} of=${of} /><${Actions} of=${of} /></div>
      <${ProblemBox} place="job" />
      <${Failed} of=${of} />
      <div class=${searchStore.isPaired.value || (searchStore.target.value?.views ?? []).length > 0 ? "looked paired" : "looked"}>
        <${FoundView} of=${of} placeholder=${resultPlaceholder(of)} />
        <div class="charted">
          <div class="course"><${Course} lines=${searchStore.logLines.value} placeholder=${resultPlaceholder(of)} /><${About} of=${of} /></div>
          <${Front} of=${of} />
        </div>
      </div>
      <div class="unseen" role="status" aria-live="polite" data-testid="job-told">${searchStore.jobAnnouncement.value}</div>
    </div>
  `;
}
