/**
 * What an individual can be taken away as: its genome, source code, pictures. Owns the list's words; what is written is the server's.
 *
 * @import { ExportFormat, Generation, Individual, Place } from "../types.js"
 */
import * as api from "../api.js";
import { html } from "../html.js";
import { guarded } from "../lineage.js";
import { scene } from "../state.js";
import { signal } from "../vendor/signals-core.js";
import { Switch } from "./control.js";

/** @type {import("../vendor/signals-core.js").Signal<ExportFormat[]>} */
const formats = signal([]);

/** Asks once for the languages that source code is written in. @param {Place} place */
export function listFormats(place) {
  if (formats.peek().length > 0) return;
  void guarded(place, async () => {
    formats.value = await api.listExports();
  });
}

/** Has the browser save the genome's text. @param {Individual} of @param {Place} place */
const saveText = (of, place) => guarded(place, async () => {
  const text = await api.getGenomeText(of.hash);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = `${of.hash.slice(0, 12)}.brood`;
  link.click();
  // Not every browser has begun to read it by now.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
});

/** Whether functions are exported under the energy limit: other renderers count on it. */
const limitedExports = signal(true);

/** @param {{of: Individual}} props */
const SourceCode = ({ of }) => html`
  ${formats.value.map((format) => html`
    <li key=${format.name}><a download href=${`/v1/individuals/${of.id}/exports/${format.name}?energy_limit=${limitedExports.value}`} data-testid=${`export-${format.name}`}>${format.label}</a></li>
  `)}
  <li><${Switch} id="export-limited" name="functions reflect no more than they receive" on=${limitedExports.value} title="The energy limit: functions are divided by their largest albedo where that is above 1. Off: as bright as on the screen." turns=${(/** @type {boolean} */ on) => (limitedExports.value = on)} /></li>
`;

/** @param {{within: Generation}} props */
const OfBrood = ({ within }) => html`
  <li><a download=${`${within.id}.png`} href=${`/v1/generations/${within.id}/sheet.png`} data-testid="export-sheet">PNG of the brood</a></li>
  <li><a download=${`${within.id}.apng`} href=${`/v1/generations/${within.id}/sheet.apng?size=96&frames=24`} data-testid="export-sheet-apng">APNG of the brood</a></li>
`;

/** What it can be taken away as, and its brood where that is named. @param {{of: Individual, within?: Generation, place: Place}} props */
export function Exports({ of, within, place }) {
  return html`
    <details class="exports" data-testid="exports">
      <summary>Export</summary>
      <ul>
        <li><button type="button" class="link" data-testid="export-brood" onClick=${() => saveText(of, place)}>.brood, the genome as text</button></li>
        <${SourceCode} of=${of} />
        <li><a download=${`${of.id}.apng`} href=${`/v1/individuals/${of.id}/render.apng?size=256&frames=24&seconds=4`} data-testid="export-apng">APNG, the light going around</a></li>
        <li><a download=${`${of.id}-strip.png`} href=${`/v1/individuals/${of.id}/strip.png?size=128&frames=24`} data-testid="export-strip">PNG strip of 24 pictures</a></li>
        <li><a download=${`${of.id}.png`} href=${`/v1/individuals/${of.id}/render.png?size=1024`}>PNG of 1024 x 1024</a></li>
        <li><a download=${`${of.id}.exr`} href=${`/v1/individuals/${of.id}/render.exr?size=1024`}>EXR of 1024 x 1024, linear</a></li>
        ${scene.value && html`<li><a download href=${`/v1/meshes/${scene.value.mesh}/mesh.glb`} data-testid="export-glb">glTF of the object, with the tangents that functions need</a></li>`}
        ${within && html`<${OfBrood} within=${within} />`}
      </ul>
    </details>
  `;
}
