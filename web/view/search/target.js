/**
 * Target part of the form: files, their kind, their upload, and targets that the server has.
 *
 * @import { Target } from "../../model.js"
 */
import { bytesInWords } from "../../page/format.js";
import { pageStore } from "../../page/store.js";
import { searchStore } from "../../search/store.js";
import {
  addTargetFiles, chooseTarget, readAs, readFile, readTargets, removeTarget, restoreSetAside,
  stopSending,
} from "../../search/target.js";
import { KINDS, counted, kindInWords, nameOfTarget } from "../../search/words.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";
import { UploadProgress } from "../upload.js";
import { Understood } from "./understood.js";
import { PICTURES, Pictures, filesChosen, isShownAtField } from "./views.js";

const ACCEPTED = `.csv,.binary,.bsdf,.brdf,.json,${PICTURES}`;

/** @param {Event} event */
const fileChosen = (event) => void addTargetFiles(filesChosen(event));

/** Reads the list of targets when the form opens. @param {HTMLElement|null} element */
const opened = (element) => element && void readTargets();

/** Hint for the next file. */
function next() {
  const { file, kind } = searchStore.draft.value;
  if (!file) return "samples .csv, image slice .exr, MERL .binary, RGL .bsdf, goniometer .brdf; or photographs and pictures of known scenes .png .jpg .hdr .exr";
  return kind === "image" ? "Drop or choose more pictures of the same material, or the scene's .json" : "Drop or choose another to replace it";
}

function Drop() {
  const { file, kind, views } = searchStore.draft.value;
  const several = kind === "image" && views.length > 1;
  return html`
    <label class=${`well ${pageStore.fileDragged.value ? "over" : ""} ${file ? "taken" : ""}`}>
      <input type="file" multiple accept=${ACCEPTED} data-testid="target-file" aria-label="Choose a file of measurements, or pictures of a known scene" onChange=${fileChosen} />
      <span>${several ? html`<strong>${views.length} pictures</strong>` : file ? html`<strong>${file.name}</strong> <span class="small">${bytesInWords(file.size)}</span>` : html`<strong>Drop a file here</strong>, or choose one`}</span>
      <span class="small">${next()}</span>
    </label>
  `;
}

function Kind() {
  const { file, kind, views } = searchStore.draft.value;
  if (!file || (kind === "image" && views.length > 1)) return null;
  return html`
    <label class="entry">
      <span>read as</span>
      <select data-testid="target-kind" value=${kind} onChange=${(/** @type {Event} */ event) => readAs(/** @type {any} */ (/** @type {HTMLSelectElement} */ (event.target).value))}>
        ${kind === "" && html`<option value="" selected disabled>choose a kind</option>`}
        ${KINDS.map(({ value, name }) => html`<option key=${value} value=${value} selected=${value === kind}>${name}</option>`)}
      </select>
      ${kind === "" && html`<span class="small">The file's name does not show its kind.</span>`}
    </label>
  `;
}

/** Kind and size of a target in words. @param {Target} of */
function amountOf(of) {
  const samples = counted(of.samples, "sample");
  if (of.kind === "image") return `${counted(of.views?.length ?? 1, "picture")}, ${samples}`;
  return of.kind === "samples" ? samples : `${kindInWords(of.kind)}, ${samples}`;
}

/** A target that the server has. @param {Target} of */
const Known = (of) => {
  const on = searchStore.draft.value.target?.id === of.id;
  return html`
    <li key=${of.id}>
      <button type="button" class=${on ? "grow on" : "grow"} aria-pressed=${on} data-testid=${`target-${of.id}`} onClick=${() => chooseTarget(of)}>
        <span class="cut">${nameOfTarget(of)}</span> <span class="small">${amountOf(of)}</span>
      </button>
      <button type="button" class="remove" aria-label=${`Remove ${nameOfTarget(of)}`} title="Remove" onClick=${() => removeTarget(of)}>×</button>
    </li>
  `;
};

/** Text for screen readers about the upload. */
function uploadStatus() {
  if (searchStore.upload.value) return "Uploading to the server.";
  const { target } = searchStore.draft.value;
  return target ? `${nameOfTarget(target)} was read: ${counted(target.samples, "sample")}.` : "";
}

export function What() {
  const { file, kind, target } = searchStore.draft.value;
  const before = searchStore.setAside.value;
  return html`
    <section class="what" aria-labelledby="what-title" ref=${opened}>
      <h3 id="what-title">What to match</h3>
      <${Drop} />
      ${before && !file && html`<button type="button" class="start" data-testid="target-back" onClick=${restoreSetAside}>Back to ${before.views.length > 1 && before.kind === "image" ? `the ${before.views.length} pictures` : before.file?.name}</button>`}
      <${Kind} />
      ${file && kind === "image" && html`<${Pictures} />`}
      ${file && kind !== "image" && kind !== "" && !target && !searchStore.upload.value && html`<button type="button" class="start" data-testid="target-again" onClick=${readFile}>Read it</button>`}
      <${UploadProgress} id="target-sending" now=${searchStore.upload.value} stop=${stopSending} />
      ${!isShownAtField() && html`<${ProblemBox} place="target" />`}
      <div class="unseen" role="status">${uploadStatus()}</div>
      ${target && !searchStore.upload.value && html`<${Understood} of=${target} />`}
      ${searchStore.targets.value.length > 0 && html`
        <details open=${!file && !target}>
          <summary>Or choose a target of the server (${searchStore.targets.value.length})</summary>
          <ul class="known" aria-label="Targets">${searchStore.targets.value.map(Known)}</ul>
        </details>
      `}
    </section>
  `;
}
