/**
 * Dialog of searches: the list, the form of a new one, or the view of one.
 *
 * @import { Job } from "../../model.js"
 */
import { lineageStore } from "../../lineage/store.js";
import * as route from "../../page/route.js";
import { closeSearches, loadMore, openSearches } from "../../search/searches.js";
import { ALL, NEW, searchStore } from "../../search/store.js";
import {
  budgetInWords, duration, errorInWords, hasEnded, stateInWords,
} from "../../search/words.js";
import { modal, shut } from "../dialog.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";
import { JobTitle, JobView } from "./job.js";
import { NewSearch } from "./new.js";

const opened = modal();

/**
 * Focuses the title when the view changes; the first view leaves the focus where the dialog puts
 * it.
 * @param {HTMLElement|null} title
 */
const titled = (title) => {
  if (title?.closest("dialog")?.open) title.focus();
};

/** Progress in words. @param {Job} of */
function progressInWords(of) {
  if (of.state === "queued") return "";
  if (hasEnded(of)) return duration(of.seconds);
  return `${Math.floor(100 * of.progress)} % of ${budgetInWords(of.budget)}`;
}

/** Time of day for today, else the date. @param {number} ms */
function when(ms) {
  const at = new Date(ms);
  const today = at.toDateString() === new Date().toDateString();
  return today ? at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" }) : at.toLocaleDateString();
}

/** @param {Job} of */
function Row(of) {
  const error = of.best?.e_log ?? of.held;
  return html`
    <li key=${of.id}>
      <a class="job" data-testid=${`job-${of.id}`} href=${route.format(lineageStore.lineage.value?.id ?? null, lineageStore.shownId.value, of.id)}>
        <span class="cover">${of.best?.thumbnail && html`<${ServerPicture} url=${of.best.thumbnail} lazy />`}</span>
        <span class="who"><span class="cut">${of.name}</span><span class="small">${of.strategy}</span></span>
        <span class=${`state ${of.state}`}>${stateInWords(of.state)}</span>
        <span class="far">${hasEnded(of) ? "" : html`<progress max="1" value=${of.progress} aria-hidden="true"></progress>`}<span class="small">${progressInWords(of)}</span></span>
        <span class="error">${error === null || error === undefined ? "" : html`<span class="small">error</span> ${errorInWords(error)}`}</span>
        <time class="small" datetime=${new Date(of.created_ms).toISOString()}>${when(of.created_ms)}</time>
      </a>
    </li>
  `;
}

const Empty = () => html`
  <div class="empty">
    <p>A search breeds by machine: from a measured material or pictures of one, it finds materials with the same reflectance, from the most accurate to the shortest.</p>
    <p class="small">Drop a file of measurements or a picture here, or start a new search. Its results can be bred by eye like any material.</p>
    <button type="button" class="primary" onClick=${() => openSearches(NEW)}>New search</button>
  </div>
`;

function List() {
  const known = searchStore.jobs.value;
  return html`
    <div class="beside">
      <${ProblemBox} place="searches" />
      ${known === null && html`<p class="small" role="status">Loading …</p>`}
      ${known?.length === 0 && html`<${Empty} />`}
      ${known !== null && known.length > 0 && html`<ul class="jobs" aria-label="Searches">${known.map(Row)}</ul>`}
      ${searchStore.nextCursor.value !== null && html`<button type="button" class="start" onClick=${loadMore}>Show earlier searches</button>`}
    </div>
  `;
}

/** Button back to the list. */
const Back = () => html`<button type="button" data-testid="searches-all" aria-label="All searches" onClick=${() => openSearches(ALL)}><span aria-hidden="true">‹</span><span class="word" aria-hidden="true"> All searches</span></button>`;

export function Searches() {
  const at = searchStore.openView.value;
  if (at === null) return null;
  return html`
    <dialog class="inspector searches" data-testid="searches-dialog" ref=${opened} aria-labelledby="searches-title" onClose=${closeSearches}>
      <div class="row title">
        ${at !== ALL && html`<${Back} />`}
        ${at === ALL || at === NEW ? html`<h2 key=${at} id="searches-title" tabindex="-1" ref=${titled}>${at === ALL ? "Searches" : "New search"}</h2>` : html`<${JobTitle} key=${at} titled=${titled} />`}
        <span class="grow"></span>
        ${at === ALL && html`<button type="button" class="primary" data-testid="search-new" onClick=${() => openSearches(NEW)}>New search</button>`}
        <button type="button" data-testid="searches-close" onClick=${shut}>Close</button>
      </div>
      ${at === ALL ? html`<${List} />` : at === NEW ? html`<${NewSearch} />` : html`<${JobView} key=${at} />`}
    </dialog>
  `;
}
