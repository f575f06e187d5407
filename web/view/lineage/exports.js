/**
 * List of export formats of an individual: genome, source code, pictures.
 *
 * @import { ExportFormat, Generation, Individual, Place } from "../../model.js"
 */
import * as api from "../../api/routes.js";
import { lineageStore } from "../../lineage/store.js";
import { meshPath } from "../../live/geometry.js";
import { guarded } from "../../page/problem.js";
import { SIDE_PX, requestedSize } from "../../page/size.js";
import { sceneStore } from "../../scene/store.js";
import { Switch, typed } from "../control.js";
import { html } from "../html.js";
import { viewStore } from "../store.js";

/** Reads the list of languages for source code once. @param {Place} place */
export function listFormats(place) {
  if (lineageStore.exportFormats.peek().length > 0) return;
  void guarded(place, async () => {
    lineageStore.exportFormats.value = await api.listExports();
  });
}

/** Saves the genome's text as a file. @param {Individual} of @param {Place} place */
const saveText = (of, place) => guarded(place, async () => {
  const text = await api.getGenomeText(of.hash);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = `${of.hash.slice(0, 12)}.brood`;
  link.click();
  // Some browsers read the address later.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
});

/** @param {{of: Individual}} props */
const SourceCode = ({ of }) => html`
  ${lineageStore.exportFormats.value.map((format) => html`
    <li key=${format.name}><a download href=${`/v1/individuals/${of.id}/exports/${format.name}?energy_limit=${viewStore.limitedExports.value}`} data-testid=${`export-${format.name}`}>${format.label}</a></li>
  `)}
  <li><${Switch} id="export-limited" name="Energy-conserving code" on=${viewStore.limitedExports.value} title="Divides exported functions by their largest albedo where that is above 1 (energy limit). Off: as bright as on the screen." onInput=${(/** @type {boolean} */ on) => (viewStore.limitedExports.value = on)} /></li>
`;

/** @param {{name: "width"|"height"}} props */
const SideOfPicture = ({ name }) => html`
  <input type="number" class="short" min=${SIDE_PX.min} max=${SIDE_PX.max} step="1" required data-testid=${`export-${name}`} aria-label=${`${name} of the picture in pixels`} value=${viewStore.exportSides.value[name]}
    onInput=${(/** @type {Event} */ event) => (viewStore.exportSides.value = { ...viewStore.exportSides.value, [name]: typed(event) })} />
`;

/** Pictures of a chosen width and height. @param {{of: Individual}} props */
function Pictures({ of }) {
  const size = requestedSize(viewStore.exportSides.value);
  return html`
    <li class="of-size"><${SideOfPicture} name="width" /> × <${SideOfPicture} name="height" /> pixels</li>
    ${size === null
      ? html`<li class="small" role="alert">Width and height must be ${SIDE_PX.min} to ${SIDE_PX.max} pixels.</li>`
      : html`
        <li><a download=${`${of.id}.png`} href=${`/v1/individuals/${of.id}/render.png?size=${size}`} data-testid="export-png">PNG of this size</a></li>
        <li><a download=${`${of.id}.exr`} href=${`/v1/individuals/${of.id}/render.exr?size=${size}`} data-testid="export-exr">EXR of this size, linear</a></li>
      `}
  `;
}

/** @param {{within: Generation}} props */
const OfBrood = ({ within }) => html`
  <li><a download=${`${within.id}.png`} href=${`/v1/generations/${within.id}/sheet.png`} data-testid="export-sheet">PNG of the brood</a></li>
  <li><a download=${`${within.id}.apng`} href=${`/v1/generations/${within.id}/sheet.apng?size=96&frames=24`} data-testid="export-sheet-apng">Animated PNG of the brood</a></li>
`;

/**
 * Exports of an individual, and of its brood if that is given.
 * @param {{of: Individual, within?: Generation, place: Place}} props
 */
export function Exports({ of, within, place }) {
  return html`
    <details class="exports" data-testid="exports">
      <summary>Export</summary>
      <ul>
        <li><button type="button" class="link" data-testid="export-brood" onClick=${() => saveText(of, place)}>.brood, the genome as text</button></li>
        <${SourceCode} of=${of} />
        <li><a download=${`${of.id}.apng`} href=${`/v1/individuals/${of.id}/render.apng?size=256&frames=24&seconds=4`} data-testid="export-apng">Animated PNG, light orbit</a></li>
        <li><a download=${`${of.id}-strip.png`} href=${`/v1/individuals/${of.id}/strip.png?size=128&frames=24`} data-testid="export-strip">PNG strip of 24 pictures</a></li>
        <${Pictures} of=${of} />
        ${sceneStore.scene.value && html`<li><a download href=${meshPath(sceneStore.scene.value, "mesh.glb")} data-testid="export-glb">Preview mesh with tangents (.glb)</a></li>`}
        ${within && html`<${OfBrood} within=${within} />`}
      </ul>
    </details>
  `;
}
