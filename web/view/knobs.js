/**
 * The left pane: breeding, locks, object, light, film.
 *
 * @import { Place } from "../model.js"
 */
import { saveSaturation, setEnergyLimit } from "../lineage/breed.js";
import { lineageStore } from "../lineage/store.js";
import { clearProblems } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import {
  BUILT_IN, chooseObject, isTurned, resetView, setConvention, setExposure, setTone,
} from "../scene/edit.js";
import { sceneStore } from "../scene/store.js";
import { stopUpload } from "../scene/upload.js";
import { Choice, Slider, Switch } from "./control.js";
import { openFiles } from "./file_drop.js";
import { html } from "./html.js";
import { LightKnobs } from "./light.js";
import { SurroundingsKnobs } from "./surroundings.js";
import { Locks } from "./lineage/locks.js";
import { Painting } from "./lineage/painting.js";
import { Steering } from "./lineage/steer.js";
import { NormalMap } from "./normal_map.js";
import { ProblemBox } from "./problem.js";
import { viewStore } from "./store.js";
import { UploadProgress } from "./upload.js";

/** @param {"mutation"|"recombination"|"saturation"} key @param {number} value */
function turn(key, value) {
  clearProblems(/** @type {Place} */ (key));
  lineageStore.knobs.value = { ...lineageStore.knobs.value, [key]: value };
}

/** Choice of bumps of new children. */
const Bumps = () => html`
  <div class="row"><span>Bumps</span>
    <${Choice} id="bumps" name="Bumps of new children" value=${String(lineageStore.knobs.value.bumps)} options=${[
      { value: "null", name: "as parents", title: "Children have bumps if their parents do" },
      { value: "true", name: "all", title: "All new children have bumps, which are bred with them" },
      { value: "false", name: "none", title: "New children are smooth" },
    ]} onInput=${(/** @type {string} */ value) => (lineageStore.knobs.value = { ...lineageStore.knobs.value, bumps: JSON.parse(value) })} />
  </div>
`;

function Breeding() {
  const painted = lineageStore.painted.value;
  const withoutBrdf = lineageStore.withoutBrdf.value;
  const { mutation, recombination, saturation, isotropic, homogeneous, energy_limit } = lineageStore.knobs.value;
  return html`
    <section aria-labelledby="breeding">
      <h2 id="breeding">Breeding</h2>
      <${Slider} id="mutation" name="Mutation" title="Difference of children from their parent: just visible at 0.02, unrelated at 1" value=${mutation} min=${0} max=${1} step=${0.01} shown=${mutation.toFixed(2)} onInput=${(/** @type {number} */ to) => turn("mutation", to)} />
      <${ProblemBox} place="mutation" />
      ${painted && html`<${Painting} />`}
      <${Steering} />
      <${Slider} id="recombination" name="Recombination" title="Share of the mate in a cross" value=${recombination} min=${0} max=${1} step=${0.01} shown=${recombination.toFixed(2)} onInput=${(/** @type {number} */ to) => turn("recombination", to)} />
      <${ProblemBox} place="recombination" />
      <${Slider} id="saturation" name="Saturation" title="Colourfulness of new children; 0 is grey" value=${saturation} disabled=${withoutBrdf} min=${0} max=${1} step=${0.01} shown=${saturation.toFixed(2)} onInput=${(/** @type {number} */ to) => turn("saturation", to)} onCommit=${saveSaturation} />
      <${ProblemBox} place="saturation" />
      ${!painted && html`<${Bumps} />`}
      <div class="chips">
        <${Switch} id="isotropic" name="isotropic" on=${isotropic} title="New children look the same when the surface is rotated about its normal" onInput=${(/** @type {boolean} */ on) => (lineageStore.knobs.value = { ...lineageStore.knobs.value, isotropic: on })} />
        <${Switch} id="homogeneous" name="homogeneous" on=${homogeneous} title="New children have no texture" onInput=${(/** @type {boolean} */ on) => (lineageStore.knobs.value = { ...lineageStore.knobs.value, homogeneous: on })} />
        <${Switch} id="energy-limit" name="energy limit" on=${energy_limit && !withoutBrdf} disabled=${withoutBrdf} title="New children reflect no more light than they receive" onInput=${setEnergyLimit} />
      </div>
      <${ProblemBox} place="energy_limit" />
      ${withoutBrdf && html`<p class="small" data-testid="painted-knobs">Saturation and energy limit are of BRDFs; the next brood is painted.</p>`}
      <p class="small">These apply to the next brood.</p>
    </section>
  `;
}

/** @param {Event} event */
function filesChosen(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  void openFiles(input.files).finally(() => {
    // The same file may be chosen again after it was corrected.
    input.value = "";
  });
}

/** Warnings of the uploaded object. */
function MeshFacts() {
  const mesh = sceneStore.meshes.value.find((one) => one.answer.id === sceneStore.scene.value?.mesh);
  if (!mesh) return null;
  const { vertices, triangles, has_uv, warnings } = mesh.answer;
  return html`
    <div class="facts" data-testid="mesh-facts">
      <p class="small">${vertices} vertices, ${triangles} triangles, ${has_uv ? "with" : "without"} texture coordinates</p>
      ${warnings.length > 0 && html`
        <details open>
          <summary>${warnings.length} ${warnings.length === 1 ? "warning" : "warnings"}</summary>
          <ul>${warnings.map((warning) => html`<li>line ${warning.line}: ${warning.text}</li>`)}</ul>
        </details>
      `}
    </div>
  `;
}

/** @param {Event} event */
async function objectChosen(event) {
  const select = /** @type {HTMLSelectElement} */ (event.target);
  await chooseObject(select.value);
  // After a refusal the select shows the scene's object again.
  select.value = sceneStore.editedScene.value?.mesh ?? select.value;
}

/**
 * Conventions in which renderers differ, with the scene's default first.
 * @type {{field: "normals"|"tangents"|"sphere_pole", name: string, options: {value: string, name:
 *   string, title: string}[]}[]}
 */
const CONVENTIONS = [
  { field: "normals", name: "Normals", options: [
    { value: "curved", name: "curved", title: "Normals describe a curved surface: no shadow borders along triangles" },
    { value: "plain", name: "plain", title: "Shadow rays start on the flat triangles, as in Mitsuba" },
  ] },
  { field: "tangents", name: "Tangents", options: [
    { value: "vertex", name: "per vertex", title: "Interpolated between vertices" },
    { value: "triangle", name: "per triangle", title: "One direction of growing u for each triangle, as in Mitsuba" },
  ] },
  { field: "sphere_pole", name: "Poles of the texture", options: [
    { value: "y", name: "y axis", title: "Above and below" },
    { value: "z", name: "z axis", title: "In front and behind, as in Mitsuba" },
  ] },
];

/** How the object's surface is interpolated and textured. */
function Conventions() {
  const scene = sceneStore.editedScene.value;
  if (!scene) return null;
  const shown = CONVENTIONS.filter(({ field }) => field !== "sphere_pole" || scene.mesh === "sphere");
  return html`
    <details class="facts" data-testid="conventions">
      <summary>Conventions</summary>
      ${shown.map(({ field, name, options }) => html`
        <div class="convention" key=${field}><span class="small" aria-hidden="true">${name}</span>
          <${Choice} id=${field} name=${name} value=${scene[field] ?? options[0].value} options=${options} onInput=${(/** @type {string} */ to) => setConvention(field, to)} /></div>
      `)}
    </details>
  `;
}

function ObjectChooser() {
  const present = sceneStore.editedScene.value?.mesh ?? "sphere";
  const uploaded = sceneStore.meshes.value.map((one) => ({ id: one.answer.id, name: one.name }));
  const known = BUILT_IN.includes(present) || uploaded.some((one) => one.id === present);
  return html`
    <section aria-labelledby="object-title">
      <h2 id="object-title">Object</h2>
      <div class="row">
        <select data-testid="object" aria-label="Object" value=${present} disabled=${!sceneStore.scene.value} onChange=${objectChosen}>
          ${BUILT_IN.map((name) => html`<option value=${name} selected=${name === present}>${name}</option>`)}
          ${uploaded.map((one) => html`<option value=${one.id} selected=${one.id === present}>${one.name}</option>`)}
          ${!known && html`<option value=${present} selected>uploaded</option>`}
        </select>
        ${isTurned(sceneStore.editedScene.value) && html`<button type="button" data-testid="reset-view" title="Resets rotation, scale and light angle (double click on the centre)" onClick=${resetView}>Reset view</button>`}
        <label class="button">
          <input type="file" accept=".obj,model/obj" data-testid="obj-file" aria-label="Open or drop an OBJ" onChange=${filesChosen} />
          <span>Open or drop an OBJ</span>
        </label>
      </div>
      <${UploadProgress} id="object-sending" now=${sceneStore.uploads.value.get("object")} stop=${() => stopUpload("object")} />
      <${ProblemBox} place="object" />
      <${MeshFacts} />
      ${sceneStore.scene.value && html`<${NormalMap} part="subject" />`}
      <${Conventions} />
    </section>
  `;
}

const TONES = [
  { value: "none", name: "Linear", title: "Values brighter than white are clipped" },
  { value: "reinhard", name: "Reinhard", title: "Highlights are compressed and never clip" },
  { value: "filmic", name: "Filmic", title: "Deeper shadows and highlights that roll off" },
];

function Film() {
  const exposure = sceneStore.editedScene.value?.film.exposure ?? "auto";
  const auto = exposure === "auto" && viewStore.draggedExposure.value === null;
  const ev = viewStore.draggedExposure.value ?? (exposure === "auto" ? 0 : exposure);
  /** @param {number} to */
  const rest = (to) => {
    void setExposure(to);
    viewStore.draggedExposure.value = null;
  };
  return html`
    <section aria-labelledby="film">
      <h2 id="film">Film</h2>
      <${Slider} id="exposure" name="Exposure" title="Exposure value: one stop up doubles the brightness" value=${ev} min=${-8} max=${8} step=${0.25} dim=${auto}
        shown=${auto ? "auto" : `${ev > 0 ? "+" : ""}${ev} EV`} onInput=${(/** @type {number} */ to) => (viewStore.draggedExposure.value = to)} onCommit=${rest} />
      <div class="chips">
        <${Switch} id="exposure-auto" name="automatic" on=${auto} title="Each picture has its own exposure" onInput=${(/** @type {boolean} */ on) => setExposure(on ? "auto" : ev)} />
        <${Switch} id="clipped" name="Show clipping" on=${pageStore.clippingShown.value} title="Marks clipped pixels: magenta where a channel is burnt out, blue where all channels are black"
          onInput=${(/** @type {boolean} */ on) => (pageStore.clippingShown.value = on)} />
        <${Switch} id="surround" name="grey surround" on=${pageStore.greySurround.value} title="18 % grey around the frames" onInput=${(/** @type {boolean} */ on) => (pageStore.greySurround.value = on)} />
        <${Switch} id="hint" name="Show hint" on=${pageStore.hintShown.value} title="Shows the hint line under the frames" onInput=${(/** @type {boolean} */ on) => (pageStore.hintShown.value = on)} />
      </div>
      <${Choice} id="tone" name="Tone curve" value=${sceneStore.editedScene.value?.film.tone ?? "none"} options=${TONES} onInput=${(/** @type {string} */ to) => setTone(/** @type {import("../model.js").Tone} */ (to))} />
      ${pageStore.clippingShown.value && html`<p class="small"><span class="key burnt"></span> burnt out <span class="key black"></span> black</p>`}
      <${ProblemBox} place="film" />
    </section>
  `;
}

export function Knobs() {
  return html`
    <aside class="pane left" aria-label="Knobs">
      <button type="button" class="close" aria-label="Close the knobs" onClick=${() => (pageStore.knobsOpen.value = false)}>×</button>
      <${Breeding} /><${Locks} /><${ObjectChooser} /><${LightKnobs} /><${SurroundingsKnobs} /><${Film} />
    </aside>
  `;
}
