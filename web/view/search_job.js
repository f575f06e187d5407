/**
 * One search: how it stands, its deeds, its course, its front. Owns the arrangement and the words of the state; the chosen find draws
 * itself.
 *
 * @import { Found, Job } from "../types.js"
 */
import { html } from "../html.js";
import { change, chosen, ending, front, isTargetKnown, job, lines, picked, target, told } from "../search_job.js";
import { searchAgain } from "../search_target.js";
import { isPaired } from "../search_picture.js";
import { budgetInWords, canBe, counted, duration, errorInWords, hasEnded, kindInWords, nameOfTarget, reasonInWords, stateInWords } from "../search_words.js";
import { Course, FrontChart } from "./search_charts.js";
import { FoundView } from "./search_found.js";
import { Trouble } from "./trouble.js";

/** @param {{titled: (element: HTMLElement|null) => void}} props */
export const JobTitle = ({ titled }) => html`
  <h2 id="searches-title" class="named" tabindex="-1" ref=${titled}><span class="cut">${job.value?.name ?? "Search"}</span></h2>
  ${job.value && html`<span class=${`state ${job.value.state}`} data-testid="job-state">${stateInWords(job.value.state)}</span>`}
`;

/** The question takes the focus of the button that it takes the place of. @param {HTMLElement|null} element */
const taken = (element) => element?.focus();

/** @param {{of: Job}} props */
function Deeds({ of }) {
  const can = canBe(of);
  if (ending.value && can.cancelled) {
    return html`
      <div class="row" role="group" aria-label="Cancel the search?">
        <span>End it for good? What it found stays.</span>
        <button type="button" data-testid="job-cancel-yes" ref=${taken} onClick=${() => change("cancel")}>End it</button>
        <button type="button" onClick=${() => (ending.value = false)}>Let it go on</button>
      </div>
    `;
  }
  return html`
    <div class="row" role="group" aria-label="The search">
      ${of.state === "paused"
        ? html`<button type="button" data-testid="job-resume" disabled=${!can.resumed} onClick=${() => change("resume")}>Resume</button>`
        : html`<button type="button" data-testid="job-pause" disabled=${!can.paused} onClick=${() => change("pause")}>Pause</button>`}
      <button type="button" data-testid="job-cancel" disabled=${!can.cancelled} onClick=${() => (ending.value = true)}>Cancel</button>
      ${hasEnded(of) && target.value && html`<button type="button" data-testid="job-again" title="A new search for the same, to be changed before it begins" onClick=${() => target.value && searchAgain(of, target.value)}>Search again …</button>`}
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
  <div class="trouble" role="alert" data-testid="job-reason"><p><strong>The search failed.</strong> ${sentence(reasonInWords(of.reason))}${front.value.length > 0 ? " What it had found is there." : ""}</p></div>
`;

/** A reason of the server is no sentence. @param {string} words */
const sentence = (words) => words.charAt(0).toUpperCase() + words.slice(1) + (/[.!?]$/.test(words) ? "" : ".");

/** @param {{name: string, value: unknown, title?: string}} props */
const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** How it was asked for. @param {{of: Job}} props */
function About({ of }) {
  const to = target.value;
  return html`
    <section class="asked" aria-labelledby="asked-title">
      <h3 id="asked-title">As asked for</h3>
      <dl>
        ${!to && isTargetKnown.value && html`<${Fact} name="target" value="not on the server any more" />`}
        ${to && html`<${Fact} name="target" value=${nameOfTarget(to)} /><${Fact} name="kind" value=${kindInWords(to.kind)} /><${Fact} name="samples" value=${`${to.fitted_samples.toLocaleString("en")} fitted, ${to.held_out_samples.toLocaleString("en")} held out`} />`}
        ${to && to.reciprocal_floor !== null && html`<${Fact} name="reciprocal floor" value=${errorInWords(to.reciprocal_floor)} title="Nothing reciprocal comes closer than this" />`}
        <${Fact} name="strategy" value=${of.strategy} />
        <${Fact} name="budget" value=${budgetInWords(of.budget)} />
        <${Fact} name="seed" value=${of.seed} />
        <${Fact} name="threads" value=${of.threads ?? "all"} />
        ${of.mirrored && html`<${Fact} name="symmetry" value="mirrored" />`}
        ${of.start.length > 0 && html`<${Fact} name="started from" value=${counted(of.start.length, "individual")} />`}
        <${Fact} name="begun" value=${new Date(of.created_ms).toLocaleString()} />
      </dl>
    </section>
  `;
}

/** @param {Found} of */
const pick = (of) => (picked.value = of.individual);

/** @type {string|undefined} */
let scrolledTo;

/** Brings the chosen row into sight, once. @param {HTMLElement|null} row */
function inSight(row) {
  if (!row || row.dataset.find === scrolledTo) return;
  scrolledTo = row.dataset.find;
  // The table alone is scrolled: what was clicked stays under the hand.
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
      <thead><tr><th scope="col">error</th><th scope="col">fitted</th><th scope="col">operations</th><th scope="col">numbers</th></tr></thead>
      <tbody>
        ${of.map((one) => {
          const on = one.individual === chosen.value?.individual;
          return html`
            <tr key=${one.individual} ref=${on ? inSight : undefined} data-find=${one.individual} class=${on ? "on" : ""} onClick=${() => pick(one)}>
              <td><button type="button" aria-pressed=${on} aria-label=${`Choose the one of error ${errorInWords(one.e_log)}`} onClick=${() => pick(one)}>${errorInWords(one.e_log)}</button></td>
              <td>${errorInWords(one.e_log_fitted)}</td><td>${one.operations.toLocaleString("en")}</td><td>${one.numbers.toLocaleString("en")}</td>
            </tr>
          `;
        })}
      </tbody>
    </table>
  </div>
`;

/** Why there is no front to choose from. @param {Job} of */
function alone(of) {
  if (!hasEnded(of)) return "When the search ends, shorter ones stand here too, each with its error.";
  if (front.value.length === 0) return waiting(of);
  return of.state === "succeeded" ? "Nothing shorter was worth keeping." : "A search that was ended keeps its best alone.";
}

/** @param {{of: Job}} props */
function Front({ of }) {
  return html`
    <figure class="chart" data-testid="search-front">
      <h3>E log held out, against length</h3>
      ${front.value.length > 1
        ? html`<${FrontChart} of=${front.value} chosen=${chosen.value} picks=${pick} /><${Table} of=${front.value} />`
        : html`<p class="small hollow">${alone(of)}</p>`}
    </figure>
  `;
}

/** What is said where there is nothing yet. @param {Job} of */
function waiting(of) {
  if (of.state === "queued") return "It waits for a worker.";
  if (hasEnded(of)) return "It ended before it found anything.";
  return of.state === "paused" ? "It is paused, and has found nothing yet." : "The first generation is on its way …";
}

export function JobView() {
  const of = job.value;
  if (!of) return html`<div class="beside"><${Trouble} place="job" /><p class="small" role="status">The server is asked …</p></div>`;
  return html`
    <div class="beside of-job">
      <div class="standing"><${Progress} of=${of} /><${Deeds} of=${of} /></div>
      <${Trouble} place="job" />
      <${Failed} of=${of} />
      <div class=${isPaired.value || (target.value?.views ?? []).length > 0 ? "looked paired" : "looked"}>
        <${FoundView} of=${of} waits=${waiting(of)} />
        <div class="charted">
          <div class="course"><${Course} lines=${lines.value} waits=${waiting(of)} /><${About} of=${of} /></div>
          <${Front} of=${of} />
        </div>
      </div>
      <div class="unseen" role="status" aria-live="polite" data-testid="job-told">${told.value}</div>
    </div>
  `;
}
