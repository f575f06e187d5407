/**
 * Download of several materials as one ZIP file, with a choice of formats. Many tables are made by
 * a job.
 *
 * @import { ExportAnswer, Place } from "../model.js"
 * @import { Members } from "../export/archive.js"
 */
import { archivePath, archiveProblem, isLarge, setFormat } from "../export/archive.js";
import {
  cancelExport, followExport, forgetExport, isMaking, jobFor, startExport,
} from "../export/job.js";
import { exportStore } from "../export/store.js";
import { listFormats } from "../lineage/formats.js";
import { lineageStore } from "../lineage/store.js";
import { bytesInWords } from "../page/format.js";
import { SIDE_PX } from "../page/size.js";
import { Switch, typed } from "./control.js";
import { Download } from "./download.js";
import { html } from "./html.js";
import { viewStore } from "./store.js";

/** Formats that are not source code: name and label. */
const PLAIN = [["brood", ".brood"], ["png", "PNG"], ["exr", "EXR, linear"]];

/** @param {{name: string, label: string, id: string}} props */
const FormatSwitch = ({ name, label, id }) => html`
  <${Switch} id=${`${id}-${name}`} name=${label} on=${exportStore.formats.value.includes(name)} onInput=${(/** @type {boolean} */ on) => setFormat(name, on)} />
`;

/** Reasons of the server have no capital and no full stop. @param {ExportAnswer} of */
const whyFailed = ({ reason }) => (reason === "worker_lost" ? "its workers died repeatedly" : (reason ?? "no reason is known"));

/**
 * A job: its progress, then the download.
 * @param {{of: ExportAnswer, members: Members, name: string, place: Place, id: string}} props
 */
function Job({ of, members, name, place, id }) {
  const forget = html`<button type="button" data-testid=${`${id}-forget`} onClick=${() => forgetExport(members)}>Choose again</button>`;
  if (isMaking(of)) return html`
    <div class="download" data-testid=${`${id}-job`}>
      <progress max="1" value=${of.progress} aria-label=${`Making ${name}`}></progress>
      <span class="small">${of.state === "queued" ? "Waiting for a worker …" : `${of.made} of ${of.files} files made, ${bytesInWords(of.bytes)}`}</span>
      <button type="button" data-testid=${`${id}-cancel`} onClick=${() => cancelExport(of, place)}>Cancel</button>
    </div>
    <p class="small">The server continues if you leave the page.</p>
  `;
  if (of.state === "succeeded") return html`
    <p class="small" role="status" data-testid=${`${id}-ready`}>${of.files} files are ready, ${bytesInWords(of.bytes)}, until ${new Date(of.expires_ms ?? 0).toLocaleString()}.</p>
    <div class="row"><${Download} button id=${`${id}-save`} text="Save as ZIP" name=${name} place=${place} path=${() => of.archive ?? ""} /> ${forget}</div>
  `;
  return html`
    <p class="small" role="alert">${of.state === "cancelled" ? "The export was cancelled." : `The export failed: ${whyFailed(of)}.`}</p>
    <div class="row">${forget}</div>
  `;
}

/**
 * @param {{members: Members, count: number, name: string, place: Place, id: string,
 *   what: string}} props
 */
function Choice({ members, count, name, place, id, what }) {
  const formats = exportStore.formats.value;
  const side = exportStore.side.value;
  const content = { formats, side, limited: viewStore.limitedExports.value };
  const wrong = count === 0 ? "Choose favourites by their boxes." : archiveProblem(count, formats, side);
  const text = `Save ${what} as ZIP`;
  return html`
    <div class="chips" role="group" aria-label="Formats">
      ${PLAIN.map(([one, label]) => html`<${FormatSwitch} key=${one} id=${id} name=${one} label=${label} />`)}
      ${lineageStore.exportFormats.value.map((one) => html`<${FormatSwitch} key=${one.name} id=${id} name=${one.name} label=${one.label} />`)}
    </div>
    <label class="row side-px" title="In the light of their lineage"><span>Pictures of</span> <input type="number" class="short" min=${SIDE_PX.min} max=${SIDE_PX.max} step="1" data-testid=${`${id}-side`} value=${side} onInput=${(/** @type {Event} */ event) => (exportStore.side.value = typed(event))} /> <span>pixels</span></label>
    ${wrong
      ? html`<p class="small" role="status">${wrong}</p>`
      : isLarge(count, formats, lineageStore.exportFormats.value)
        ? html`<p class="small">Tables have up to 52 MB each, so the server makes the file first.</p>
          <button type="button" class="primary" data-testid=${`${id}-start`} disabled=${exportStore.starting.value} onClick=${() => startExport(members, content, place)}>Make ${what}</button>`
        : html`<${Download} button id=${`${id}-save`} text=${text} name=${name} place=${place} path=${() => archivePath(members, content)} />`}
  `;
}

/**
 * Menu with the formats of a file. `id`: beginning of test ids; `what`: the materials in words;
 * `name`: of the file; `flat`: opens between its neighbours, not over them.
 * @param {{members: Members, count: number, name: string, place: Place, id: string, what: string,
 *   title: string, flat?: boolean}} props
 */
export function Archive({ title, flat = false, ...props }) {
  const { members, place, id } = props;
  const job = jobFor(members);
  /** @param {Event} event */
  const opened = (event) => {
    if (!(/** @type {HTMLDetailsElement} */ (event.currentTarget).open)) return;
    listFormats(place);
    followExport(members, place);
  };
  return html`
    <details class=${flat ? "archive flat" : "archive"} data-testid=${id} onToggle=${opened}>
      <summary class="button">${title}</summary>
      <div class="sheet">
        ${job ? html`<${Job} of=${job} ...${props} />` : html`<${Choice} ...${props} />`}
      </div>
    </details>
  `;
}
