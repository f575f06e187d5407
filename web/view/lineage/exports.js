/**
 * List of export formats of an individual: genome, source code, pictures.
 *
 * @import { ExportFormat, Generation, Individual, Place } from "../../model.js"
 */
import { listFormats } from "../../lineage/formats.js";
import { isByBrdf, isPainted } from "../../lineage/layers.js";
import { lineageStore } from "../../lineage/store.js";
import { meshPath } from "../../live/geometry.js";
import { movingAngle } from "../../live/light_circle.js";
import { fileName, slug } from "../../page/file_name.js";
import { SIDE_PX, requestedSize } from "../../page/size.js";
import { sceneStore } from "../../scene/store.js";
import { Archive } from "../archive.js";
import { Switch, typed } from "../control.js";
import { Download } from "../download.js";
import { html } from "../html.js";
import { viewStore } from "../store.js";

/**
 * An individual to export, and the name of its lineage or search. `isElsewhere`: true if it is not
 * shown in the scene of the open lineage.
 * @typedef {{of: Individual, name: string, place: Place, isElsewhere?: boolean}} Exported
 */

/** Formats that a BRDF, or a painted material, may have. @param {boolean} painted */
const formatsFor = (painted) =>
  lineageStore.exportFormats.value.filter((format) => (painted ? !format.brdf : !format.painted));

/**
 * Name of the file of an export. Python imports names without dashes.
 * @param {string} name
 * @param {string} hash
 * @param {ExportFormat} format
 */
const exportName = (name, hash, format) =>
  format.extension === "py" ? `brood_${hash.slice(0, 8)}.py` : fileName(name, hash, format.extension);

/** Number of lights for which a painted material is exported: those of the screen. */
const lightCount = () => Math.min(8, Math.max(1, sceneStore.scene.value?.lights?.length ?? 1));

/**
 * Link to an export, with what the format is for, and the commands that open it.
 * @param {{format: ExportFormat, name: string, place: Place, path: string}} props
 */
function OfFormat({ format, name, place, path }) {
  const commands = (format.commands ?? []).map((command) =>
    command.replace("FILE", name).replace("URL", `${location.origin}${path}`));
  return html`
    <li>
      <${Download} id=${`export-${format.name}`} text=${format.label} name=${name} place=${place} path=${() => path} />
      <span class="small purpose" title=${`Error: ${format.error}.`}>${format.exactness}, for ${format.opened_by}</span>
      ${commands.length > 0 && html`<pre class="commands" tabindex="0" data-testid=${`commands-${format.name}`}>${commands.join("\n")}</pre>`}
    </li>
  `;
}

/** @param {Exported} props */
function SourceCode({ of, name, place }) {
  const genome = lineageStore.genomes.value.get(of.hash);
  if (isByBrdf(genome)) return html`<li class="small" data-testid="export-by-brdf">No code: the light of a toon shape is a picture of its BRDF.</li>`;
  const painted = isPainted(genome);
  /** @param {ExportFormat} format */
  const query = (format) =>
    painted ? `lights=${lightCount()}` : `energy_limit=${viewStore.limitedExports.value || format.path_traced === true}`;
  return html`
    ${formatsFor(painted).map((format) => html`
      <${OfFormat} key=${format.name} format=${format} name=${exportName(name, of.hash, format)} place=${place}
        path=${`/v1/individuals/${of.id}/exports/${format.name}?${query(format)}`} />
    `)}
    ${!painted && html`<li><${Switch} id="export-limited" name="Energy-conserving code" on=${viewStore.limitedExports.value} title="Divides exported functions by their largest albedo where that is above 1 (energy limit). Off: as bright as on the screen. Files for path tracers always are." onInput=${(/** @type {boolean} */ on) => (viewStore.limitedExports.value = on)} /></li>`}
  `;
}

/** @param {{name: "width"|"height"}} props */
const SideOfPicture = ({ name }) => html`
  <input type="number" class="short" min=${SIDE_PX.min} max=${SIDE_PX.max} step="1" required data-testid=${`export-${name}`} aria-label=${`${name} of the picture in pixels`} value=${viewStore.exportSides.value[name]}
    onInput=${(/** @type {Event} */ event) => (viewStore.exportSides.value = { ...viewStore.exportSides.value, [name]: typed(event) })} />
`;

/** Scene and light of the screen, as parameters of a request. */
function onScreen() {
  const scene = lineageStore.lineage.value?.scene;
  const light = movingAngle();
  return `${scene ? `&scene=${scene}` : ""}${light === null ? "" : `&light_deg=${light}`}`;
}

/** Pictures of a chosen width and height. @param {Exported} props */
function Pictures({ of, name, place, isElsewhere }) {
  const size = requestedSize(viewStore.exportSides.value);
  return html`
    <li class="of-size"><${SideOfPicture} name="width" /> × <${SideOfPicture} name="height" /> pixels</li>
    ${size === null
      ? html`<li class="small" role="alert">Width and height must be ${SIDE_PX.min} to ${SIDE_PX.max} pixels.</li>`
      : [["png", "PNG of this size"], ["exr", "EXR of this size, linear"]].map(([format, text]) => html`
        <li key=${format}><${Download} id=${`export-${format}`} text=${text} name=${fileName(name, of.hash, format)} place=${place}
          path=${() => `/v1/individuals/${of.id}/render.${format}?size=${size}${isElsewhere ? "" : onScreen()}`} /></li>
      `)}
  `;
}

/** @param {{within: Generation, name: string, place: Place}} props */
const OfBrood = ({ within, name, place }) => html`
  <li><${Download} id="export-sheet" text="PNG of the brood" name=${fileName(name, within.id, "brood.png")} place=${place}
    path=${() => `/v1/generations/${within.id}/sheet.png?${onScreen().slice(1)}`} /></li>
  <li><${Download} id="export-sheet-apng" text="Animated PNG of the brood" name=${fileName(name, within.id, "brood.apng")} place=${place}
    path=${() => `/v1/generations/${within.id}/sheet.apng?size=96&frames=24`} /></li>
`;

/** All children in one file. @param {{within: Generation, name: string, place: Place}} props */
function WholeBrood({ within, name, place }) {
  const count = within.individuals.length;
  return html`<${Archive} flat id="brood-export" title=${`Export all ${count}`} members=${{ generation: within.id }} count=${count} what=${`all ${count}`} name=${fileName(name, within.id, "brood.zip")} place=${place} />`;
}

/** The shown object. @param {{place: Place}} props */
function Mesh({ place }) {
  const scene = sceneStore.scene.value;
  if (!scene) return null;
  const known = sceneStore.meshes.value.find((one) => one.answer.id === scene.mesh)?.name.replace(/\.obj$/i, "");
  return html`<li><${Download} id="export-glb" text="Preview mesh with tangents (.glb)" name=${`${slug(known ?? scene.mesh)}.glb`} place=${place} path=${() => meshPath(scene, "mesh.glb")} /></li>`;
}

/**
 * Exports of an individual, and of its brood if that is given.
 * @param {Exported & {within?: Generation}} props
 */
export function Exports({ of, name, within, place, isElsewhere = false }) {
  const shared = { of, name, place, isElsewhere };
  const scene = isElsewhere ? undefined : lineageStore.lineage.value?.scene;
  const inScene = scene ? `&scene=${scene}` : "";
  return html`
    <details class="exports" data-testid="exports" onToggle=${(/** @type {Event} */ event) => /** @type {HTMLDetailsElement} */ (event.currentTarget).open && listFormats(place)}>
      <summary>Export</summary>
      <ul>
        <li><${Download} id="export-brood" text=".brood, the genome as text" name=${fileName(name, of.hash, "brood")} place=${place} path=${() => `/v1/genomes/${of.hash}`} accept="text/x-brood" /></li>
        <${SourceCode} ...${shared} />
        <li><${Download} id="export-apng" text="Animated PNG, light orbit" name=${fileName(name, of.hash, "apng")} place=${place} path=${() => `/v1/individuals/${of.id}/render.apng?size=256&frames=24&seconds=4${inScene}`} /></li>
        <li><${Download} id="export-strip" text="PNG strip of 24 pictures" name=${fileName(name, of.hash, "strip.png")} place=${place} path=${() => `/v1/individuals/${of.id}/strip.png?size=128&frames=24${inScene}`} /></li>
        <${Pictures} ...${shared} />
        <${Mesh} place=${place} />
        ${within && html`<${OfBrood} within=${within} name=${name} place=${place} />`}
      </ul>
    </details>
    ${within && html`<${WholeBrood} within=${within} name=${name} place=${place} />`}
  `;
}
