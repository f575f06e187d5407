/** Controls of what is beside and below the object: another object, and the ground. */
import { isPaint, listPresets } from "../lineage/presets.js";
import { lineageStore } from "../lineage/store.js";
import { guarded } from "../page/problem.js";
import { BUILT_IN } from "../scene/edit.js";
import {
  chooseNeighbour, commitNeighbour, dragNeighbour, knownExtents, setGround, setGroundMaterial,
  setNeighbourMaterial, setStage,
} from "../scene/objects.js";
import { spotOf } from "../scene/spot.js";
import { sceneStore } from "../scene/store.js";
import { Slider, Switch } from "./control.js";
import { html } from "./html.js";
import { NormalMap } from "./normal_map.js";
import { ProblemBox } from "./problem.js";

/** Value of the lists without a choice. */
const NONE = "none";
/** Value of the list of materials for the individual in the centre. */
const CENTRE = "centre";

/** Reads the presets when a list of materials is opened. */
const readPresets = () => void guarded("surroundings", listPresets);

/**
 * List of materials.
 * @param {{id: string, name: string, value: string|undefined, onInput: (material:
 *   string|undefined) => void}} props
 */
function Material({ id, name, value, onInput }) {
  const presets = lineageStore.presets.value;
  const centre = lineageStore.centre.value;
  const isCentre = value !== undefined && value === centre?.hash;
  const isOther = value !== undefined && !isCentre && !presets.some((one) => one.name === value);
  /** @param {Event} event */
  const choose = (event) => {
    const chosen = /** @type {HTMLSelectElement} */ (event.target).value;
    onInput(chosen === NONE ? undefined : chosen === CENTRE ? centre?.hash : chosen);
  };
  const option = (/** @type {{name: string, title: string}} */ one) =>
    html`<option key=${one.name} value=${one.name} selected=${one.name === value}>${one.title}</option>`;
  return html`
    <div class="row">
      <label for=${id}>${name}</label>
      <select id=${id} data-testid=${id} onPointerDown=${readPresets} onFocus=${readPresets} onChange=${choose}>
        <option value=${NONE} selected=${value === undefined}>neutral grey</option>
        ${centre && html`<option value=${CENTRE} selected=${isCentre}>the present centre</option>`}
        ${isOther && html`<option value=${value} selected>${/^[0-9a-f]{64}$/.test(value ?? "") ? `material ${value?.slice(0, 6)}` : value}</option>`}
        <optgroup label="Presets">${presets.filter((one) => !isPaint(one)).map(option)}</optgroup>
        <optgroup label="Painted">${presets.filter(isPaint).map(option)}</optgroup>
      </select>
    </div>
  `;
}

/** Place and size of the neighbour. */
function Spot() {
  const scene = sceneStore.editedScene.value;
  const object = scene?.objects?.[0];
  const extents = knownExtents();
  if (!scene || !object || !extents) return null;
  const { around, distance, radius } = spotOf(object, scene, extents);
  return html`
    <${Slider} id="neighbour-around" name="Around" title="Direction of the other object from the one that is bred" value=${Math.round(around)} min=${0} max=${359} step=${1} shown=${`${Math.round(around)}°`}
      onInput=${(/** @type {number} */ to) => dragNeighbour({ around: to })} onCommit=${commitNeighbour} />
    <${Slider} id="neighbour-distance" name="Distance" title="Distance between the two centres, in radii of the object that is bred" value=${distance.toFixed(2)} min=${0.5} max=${4} step=${0.05} shown=${distance.toFixed(2)}
      onInput=${(/** @type {number} */ to) => dragNeighbour({ distance: to })} onCommit=${commitNeighbour} />
    <${Slider} id="neighbour-size" name="Size" title="Radius, in radii of the object that is bred" value=${radius.toFixed(2)} min=${0.1} max=${2} step=${0.05} shown=${radius.toFixed(2)}
      onInput=${(/** @type {number} */ to) => dragNeighbour({ radius: to })} onCommit=${commitNeighbour} />
  `;
}

/** @param {Event} event */
function choose(event) {
  const { value } = /** @type {HTMLSelectElement} */ (event.target);
  void chooseNeighbour(value === NONE ? null : value);
}

export function SurroundingsKnobs() {
  const scene = sceneStore.editedScene.value;
  const [object, ...others] = scene?.objects ?? [];
  const mesh = object ? (object.mesh ?? "sphere") : NONE;
  const uploaded = sceneStore.meshes.value.map(({ name, answer }) => ({ name, mesh: answer.id }));
  const isKnown = [NONE, ...BUILT_IN, ...uploaded.map((one) => one.mesh)].includes(mesh);
  return html`
    <section aria-labelledby="surroundings-title">
      <h2 id="surroundings-title">Surroundings</h2>
      <div class="row">
        <${Switch} id="ground" name="ground" on=${scene?.ground ?? false} disabled=${!scene} onInput=${setGround} title="Puts the object on level ground" />
        <button type="button" data-testid="stage-light" disabled=${!scene} title="On the ground, in a studio, under a soft lamp that casts shadows" onClick=${setStage}>Studio with shadows</button>
      </div>
      ${scene?.ground && html`<${Material} id="ground-material" name="Ground" value=${scene.ground.material ?? undefined} onInput=${setGroundMaterial} /><${NormalMap} part="ground" />`}
      <div class="row">
        <label for="neighbour">Other object</label>
        <select id="neighbour" data-testid="neighbour" disabled=${!scene} onChange=${choose} title="Puts another object beside the one that is bred">
          <option value=${NONE} selected=${mesh === NONE}>none</option>
          ${BUILT_IN.map((one) => html`<option key=${one} value=${one} selected=${one === mesh}>${one}</option>`)}
          ${uploaded.map((one) => html`<option key=${one.mesh} value=${one.mesh} selected=${one.mesh === mesh}>${one.name}</option>`)}
          ${!isKnown && html`<option value=${mesh} selected>uploaded</option>`}
        </select>
      </div>
      ${object && html`<${Material} id="neighbour-material" name="Material" value=${object.material ?? undefined} onInput=${setNeighbourMaterial} /><${NormalMap} part="neighbour" /><${Spot} />`}
      ${others.length > 0 && html`<p class="small">${others.length} more ${others.length === 1 ? "object stays" : "objects stay"} as the scene has ${others.length === 1 ? "it" : "them"}.</p>`}
      ${(scene?.ground || object) && !scene?.shadows && html`<p class="small">Switch on shadows under Light, and objects shade each other.</p>`}
      <${ProblemBox} place="surroundings" />
    </section>
  `;
}
