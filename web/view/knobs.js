/**
 * The left pane: breeding, object, film, view. Owns the controls and their words; what they change is done elsewhere.
 *
 * @import { Place } from "../types.js"
 */
import { keepSaturation, setEnergyLimit } from "../breed.js";
import { takeFiles } from "../files.js";
import { html } from "../html.js";
import { BUILT_IN, chooseObject, setExposure, setTone } from "../scene.js";
import { signal } from "../vendor/signals-core.js";
import { clipped, forget, greySurround, hinting, knobs, knobsOpen, meshes, scene, wishedScene } from "../state.js";
import { LightKnobs } from "./light.js";
import { Choice, Slider, Switch } from "./control.js";
import { Locks } from "./locks.js";
import { Trouble } from "./trouble.js";

/** An exposure being dragged, before it is let go. @type {import("../vendor/signals-core.js").Signal<number|null>} */
const draggedEv = signal(null);

/** @param {"mutation"|"recombination"|"saturation"} key @param {number} value */
function turn(key, value) {
  forget(/** @type {Place} */ (key));
  knobs.value = { ...knobs.value, [key]: value };
}

function Breeding() {
  const { mutation, recombination, saturation, isotropic, homogeneous, energy_limit } = knobs.value;
  return html`
    <section aria-labelledby="breeding">
      <h2 id="breeding">Breeding</h2>
      <${Slider} id="mutation" name="Mutation" value=${mutation} min=${0} max=${1} step=${0.01} shown=${mutation.toFixed(2)} turns=${(/** @type {number} */ to) => turn("mutation", to)} />
      <${Trouble} place="mutation" />
      <${Slider} id="recombination" name="Recombination" value=${recombination} min=${0} max=${1} step=${0.01} shown=${recombination.toFixed(2)} turns=${(/** @type {number} */ to) => turn("recombination", to)} />
      <${Trouble} place="recombination" />
      <${Slider} id="saturation" name="Saturation" value=${saturation} min=${0} max=${1} step=${0.01} shown=${saturation.toFixed(2)} turns=${(/** @type {number} */ to) => turn("saturation", to)} rests=${keepSaturation} />
      <${Trouble} place="saturation" />
      <div class="chips">
        <${Switch} id="isotropic" name="isotropic" on=${isotropic} title="New children look the same however they are turned" turns=${(/** @type {boolean} */ on) => (knobs.value = { ...knobs.value, isotropic: on })} />
        <${Switch} id="homogeneous" name="homogeneous" on=${homogeneous} title="New children have no texture" turns=${(/** @type {boolean} */ on) => (knobs.value = { ...knobs.value, homogeneous: on })} />
        <${Switch} id="energy-limit" name="energy limit" on=${energy_limit} title="New children reflect no more light than they receive" turns=${setEnergyLimit} />
      </div>
      <${Trouble} place="energy_limit" />
      <p class="small">These act on the next brood.</p>
    </section>
  `;
}

/** @param {Event} event */
function filesChosen(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  void takeFiles(input.files).finally(() => {
    // The same file, mended, may be chosen again.
    input.value = "";
  });
}

/** What was odd about the uploaded object. */
function MeshFacts() {
  const mesh = meshes.value.find((one) => one.answer.id === scene.value?.mesh);
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

function ObjectChooser() {
  const present = wishedScene.value?.mesh ?? "sphere";
  const uploaded = meshes.value.map((one) => ({ id: one.answer.id, name: one.name }));
  const known = BUILT_IN.includes(present) || uploaded.some((one) => one.id === present);
  return html`
    <section aria-labelledby="object-title">
      <h2 id="object-title">Object</h2>
      <div class="row">
        <select data-testid="object" aria-label="Object" value=${present} disabled=${!scene.value} onChange=${(/** @type {Event} */ event) => chooseObject(/** @type {HTMLSelectElement} */ (event.target).value)}>
          ${BUILT_IN.map((name) => html`<option value=${name} selected=${name === present}>${name}</option>`)}
          ${uploaded.map((one) => html`<option value=${one.id} selected=${one.id === present}>${one.name}</option>`)}
          ${!known && html`<option value=${present} selected>uploaded</option>`}
        </select>
        <label class="button">
          <input type="file" accept=".obj,model/obj" data-testid="obj-file" aria-label="Open or drop an OBJ" onChange=${filesChosen} />
          <span>Open or drop an OBJ</span>
        </label>
      </div>
      <${Trouble} place="object" />
      <${MeshFacts} />
    </section>
  `;
}

const TONES = [
  { value: "none", name: "no curve", title: "What is brighter than white is white" },
  { value: "reinhard", name: "Reinhard", title: "Highlights are compressed and never burn out" },
  { value: "filmic", name: "filmic", title: "Deeper shadows and highlights that roll off" },
];

function Film() {
  const exposure = wishedScene.value?.film.exposure ?? "auto";
  const auto = exposure === "auto" && draggedEv.value === null;
  const ev = draggedEv.value ?? (exposure === "auto" ? 0 : exposure);
  /** @param {number} to */
  const rest = (to) => {
    void setExposure(to);
    draggedEv.value = null;
  };
  return html`
    <section aria-labelledby="film">
      <h2 id="film">Film</h2>
      <${Slider} id="exposure" name="Exposure" value=${ev} min=${-8} max=${8} step=${0.25} dim=${auto}
        shown=${auto ? "auto" : `${ev > 0 ? "+" : ""}${ev} EV`} turns=${(/** @type {number} */ to) => (draggedEv.value = to)} rests=${rest} />
      <div class="chips">
        <${Switch} id="exposure-auto" name="automatic" on=${auto} title="Each picture at its own exposure" turns=${(/** @type {boolean} */ on) => setExposure(on ? "auto" : ev)} />
        <${Switch} id="clipped" name="clipped" on=${clipped.value} title="Marks what is lost: magenta where a channel is burnt out, blue where all are black, as the side away from the light is"
          turns=${(/** @type {boolean} */ on) => (clipped.value = on)} />
        <${Switch} id="surround" name="grey surround" on=${greySurround.value} title="18 % grey around the frames" turns=${(/** @type {boolean} */ on) => (greySurround.value = on)} />
        <${Switch} id="hint" name="help line" on=${hinting.value} title="The line of help under the frames" turns=${(/** @type {boolean} */ on) => (hinting.value = on)} />
      </div>
      <${Choice} id="tone" name="Tone curve" value=${wishedScene.value?.film.tone ?? "none"} options=${TONES} turns=${(/** @type {string} */ to) => setTone(/** @type {import("../types.js").Tone} */ (to))} />
      ${clipped.value && html`<p class="small"><span class="key burnt"></span> burnt out <span class="key black"></span> black</p>`}
      <${Trouble} place="film" />
    </section>
  `;
}

export function Knobs() {
  return html`
    <aside class="pane left" aria-label="Knobs">
      <button type="button" class="close" aria-label="Close the knobs" onClick=${() => (knobsOpen.value = false)}>×</button>
      <${Breeding} /><${Locks} /><${ObjectChooser} /><${LightKnobs} /><${Film} />
    </aside>
  `;
}
