/**
 * What is to be matched: files, their kind, their way to the server, and targets that are there already. Owns the words of that half
 * of the form; the deeds are search_target.js's.
 *
 * @import { Target } from "../types.js"
 */
import { html } from "../html.js";
import { draft } from "../search_draft.js";
import { aside, chooseTarget, readAs, readFile, readTargets, removeTarget, sending, stopSending, takeTargets, takeUpAgain, targets } from "../search_target.js";
import { KINDS, counted, kindInWords, nameOfTarget, sizeInWords } from "../search_words.js";
import { fileOver } from "../state.js";
import { Understood } from "./search_understood.js";
import { PICTURES, Pictures, chosenIn, isPlaced } from "./search_views.js";
import { Trouble } from "./trouble.js";

const ACCEPTED = `.csv,.binary,.bsdf,.brdf,.json,${PICTURES}`;

/** @param {Event} event */
const fileChosen = (event) => void takeTargets(chosenIn(event));

/** Whether the targets were asked for since the form opened. @param {HTMLElement|null} element */
const opened = (element) => element && void readTargets();

/** What a file here would do. */
function next() {
  const { file, kind } = draft.value;
  if (!file) return "samples .csv, image slice .exr, MERL .binary, RGL .bsdf, goniometer .brdf; or pictures .png .jpg .hdr .exr of a scene that is known";
  return kind === "image" ? "Drop or choose more pictures of the same material, or the scene's .json" : "Drop or choose another to take its place";
}

function Drop() {
  const { file, kind, views } = draft.value;
  const several = kind === "image" && views.length > 1;
  return html`
    <label class=${`well ${fileOver.value ? "over" : ""} ${file ? "taken" : ""}`}>
      <input type="file" multiple accept=${ACCEPTED} data-testid="target-file" aria-label="Choose a file of measurements, or pictures of a known scene" onChange=${fileChosen} />
      <span>${several ? html`<strong>${views.length} pictures</strong>` : file ? html`<strong>${file.name}</strong> <span class="small">${sizeInWords(file.size)}</span>` : html`<strong>Drop a file here</strong>, or choose one`}</span>
      <span class="small">${next()}</span>
    </label>
  `;
}

function Kind() {
  const { file, kind, views } = draft.value;
  if (!file || (kind === "image" && views.length > 1)) return null;
  return html`
    <label class="entry">
      <span>read as</span>
      <select data-testid="target-kind" value=${kind} onChange=${(/** @type {Event} */ event) => readAs(/** @type {any} */ (/** @type {HTMLSelectElement} */ (event.target).value))}>
        ${kind === "" && html`<option value="" selected disabled>what is it?</option>`}
        ${KINDS.map(({ value, name }) => html`<option key=${value} value=${value} selected=${value === kind}>${name}</option>`)}
      </select>
      ${kind === "" && html`<span class="small">The name does not tell what the file is.</span>`}
    </label>
  `;
}

/** How far the upload is, and a way to stop it. */
function Sending() {
  const now = sending.value;
  if (!now) return null;
  const sent = now.sent >= now.whole;
  return html`
    <div class="sending" data-testid="target-sending">
      <progress max="1" value=${sent ? undefined : now.sent / now.whole} aria-label=${sent ? "The server reads it" : "Upload"}></progress>
      <span class="small">${sent ? "The server reads it …" : `${sizeInWords(now.sent)} of ${sizeInWords(now.whole)} sent`}</span>
      <button type="button" data-testid="target-stop" onClick=${stopSending}>Cancel</button>
    </div>
  `;
}

/** What it is and how much of it there is. @param {Target} of */
function amountOf(of) {
  const samples = counted(of.samples, "sample");
  if (of.kind === "image") return `${counted(of.views?.length ?? 1, "picture")}, ${samples}`;
  return of.kind === "samples" ? samples : `${kindInWords(of.kind)}, ${samples}`;
}

/** One that is here already. @param {Target} of */
const Known = (of) => {
  const on = draft.value.target?.id === of.id;
  return html`
    <li key=${of.id}>
      <button type="button" class=${on ? "grow on" : "grow"} aria-pressed=${on} data-testid=${`target-${of.id}`} onClick=${() => chooseTarget(of)}>
        <span class="cut">${nameOfTarget(of)}</span> <span class="small">${amountOf(of)}</span>
      </button>
      <button type="button" class="remove" aria-label=${`Remove ${nameOfTarget(of)}`} title="Remove" onClick=${() => removeTarget(of)}>×</button>
    </li>
  `;
};

/** What a screen reader is told of the upload. */
function told() {
  if (sending.value) return "It is sent to the server.";
  const { target } = draft.value;
  return target ? `${nameOfTarget(target)} is understood: ${counted(target.samples, "sample")}.` : "";
}

export function What() {
  const { file, kind, target } = draft.value;
  const before = aside.value;
  return html`
    <section class="what" aria-labelledby="what-title" ref=${opened}>
      <h3 id="what-title">What to match</h3>
      <${Drop} />
      ${before && !file && html`<button type="button" class="start" data-testid="target-back" onClick=${takeUpAgain}>Back to ${before.views.length > 1 && before.kind === "image" ? `the ${before.views.length} pictures` : before.file?.name}</button>`}
      <${Kind} />
      ${file && kind === "image" && html`<${Pictures} />`}
      ${file && kind !== "image" && kind !== "" && !target && !sending.value && html`<button type="button" class="start" data-testid="target-again" onClick=${readFile}>Read it</button>`}
      <${Sending} />
      ${!isPlaced() && html`<${Trouble} place="target" />`}
      <div class="unseen" role="status">${told()}</div>
      ${target && !sending.value && html`<${Understood} of=${target} />`}
      ${targets.value.length > 0 && html`
        <details open=${!file && !target}>
          <summary>Or one that is here already (${targets.value.length})</summary>
          <ul class="known" aria-label="Targets">${targets.value.map(Known)}</ul>
        </details>
      `}
    </section>
  `;
}
