/** Colours of a painting in the left pane: from a picture by button or drop, shown as swatches. */
import {
  PICTURES, clearPainting, shareInWords, usePainting,
} from "../../lineage/painting.js";
import { lineageStore } from "../../lineage/store.js";
import { sceneStore } from "../../scene/store.js";
import { stopUpload } from "../../scene/upload.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";
import { UploadProgress } from "../upload.js";

/** @param {Event} event */
function readFile(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  const [file] = input.files ?? [];
  if (file) void usePainting(file);
  // The same file may be chosen again.
  input.value = "";
}

/** @param {{code: string, name: string}} props */
const Swatch = ({ code, name }) => html`<span class="swatch" role="img" aria-label=${`${name} ${code}`} title=${`${name} ${code}`} style=${{ background: code }}></span>`;

export function Painting() {
  const regions = lineageStore.knobs.value.painting?.regions ?? [];
  return html`
    <div class="painting" role="group" aria-labelledby="painting-title" data-takes="painting" data-testid="painting">
      <p class="small" id="painting-title">Colours of a painting</p>
      ${regions.length > 0 && html`
        <ul class="regions" data-testid="painting-regions">
          ${regions.map((region, at) => html`
            <li key=${at} title=${shareInWords(region)}>
              <${Swatch} code=${region.dark} name="dark" /><${Swatch} code=${region.middle} name="middle" /><${Swatch} code=${region.bright} name="bright" />
              <span class="small">${shareInWords(region)}</span>
            </li>
          `)}
        </ul>
      `}
      <div class="row">
        <label class="button">
          <input type="file" accept=${PICTURES} data-testid="painting-file" aria-label="Open or drop a painting" onChange=${readFile} />
          <span>Open or drop a painting</span>
        </label>
        ${regions.length > 0 && html`<button type="button" data-testid="painting-clear" onClick=${clearPainting}>Clear the colours</button>`}
      </div>
      <${UploadProgress} id="painting-sending" now=${sceneStore.uploads.value.get("painting")} stop=${() => stopUpload("painting")} />
      <${ProblemBox} place="painting" />
      <p class="small">${regions.length > 0 ? "Children take the colours of one region, or the dark of one and the bright of another." : "A PNG or JPEG: the next brood is painted in its colours."}</p>
    </div>
  `;
}
