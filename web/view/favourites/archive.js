/**
 * Download of the chosen favourites as one ZIP file, with a choice of formats.
 *
 * @import { Favourite } from "../../model.js"
 */
import { archivePath, archiveProblem, setFormat } from "../../favourites/chosen.js";
import { lineageName } from "../../favourites/list.js";
import { favouritesStore } from "../../favourites/store.js";
import { listFormats } from "../../lineage/formats.js";
import { lineageStore } from "../../lineage/store.js";
import { slug } from "../../page/file_name.js";
import { SIDE_PX } from "../../page/size.js";
import { Switch, typed } from "../control.js";
import { Download } from "../download.js";
import { html } from "../html.js";
import { viewStore } from "../store.js";

/** Formats that are not source code: name and label. */
const PLAIN = [["brood", ".brood"], ["png", "PNG"], ["exr", "EXR, linear"]];

/** @param {{name: string, label: string}} props */
const FormatSwitch = ({ name, label }) => html`
  <${Switch} id=${`archive-${name}`} name=${label} on=${favouritesStore.formats.value.includes(name)} onInput=${(/** @type {boolean} */ on) => setFormat(name, on)} />
`;

/** Name of the file: of the lineage if all are from one. @param {Favourite[]} of */
function archiveName(of) {
  const names = new Set(of.map(lineageName));
  return `${names.size === 1 ? slug([...names][0]) : "favourites"}-${of.length}.zip`;
}

/** @param {{of: Favourite[]}} props */
export function Archive({ of }) {
  const formats = favouritesStore.formats.value;
  const side = favouritesStore.side.value;
  const wrong = of.length === 0 ? "Choose favourites by their boxes." : archiveProblem(of.length, formats, side);
  return html`
    <details class="archive" data-testid="archive" onToggle=${(/** @type {Event} */ event) => /** @type {HTMLDetailsElement} */ (event.currentTarget).open && listFormats("favourites")}>
      <summary class="button">Save as ZIP</summary>
      <div class="sheet">
        <div class="chips" role="group" aria-label="Formats">
          ${PLAIN.map(([name, label]) => html`<${FormatSwitch} key=${name} name=${name} label=${label} />`)}
          ${lineageStore.exportFormats.value.map(({ name, label }) => html`<${FormatSwitch} key=${name} name=${name} label=${label} />`)}
        </div>
        <label class="row side-px" title="In the light of their lineage"><span>Pictures of</span> <input type="number" class="short" min=${SIDE_PX.min} max=${SIDE_PX.max} step="1" data-testid="archive-side" value=${side} onInput=${(/** @type {Event} */ event) => (favouritesStore.side.value = typed(event))} /> <span>pixels</span></label>
        ${wrong
          ? html`<p class="small" role="status">${wrong}</p>`
          : html`<${Download} button id="archive-save" text=${`Save ${of.length} as ZIP`} name=${archiveName(of)} place="favourites" path=${() => archivePath(of.map(({ id }) => id), formats, side, viewStore.limitedExports.value)} />`}
      </div>
    </details>
  `;
}
