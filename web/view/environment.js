/** Controls of the environment: which one, its rotation and its brightness. */
import { chooseEnvironment } from "../scene/edit.js";
import { commitLight, dragEnvironment } from "../scene/light_controls.js";
import { ENVIRONMENTS } from "../scene/light_kind.js";
import { environmentOf } from "../scene/lights.js";
import { sceneStore } from "../scene/store.js";
import { Slider } from "./control.js";
import { html } from "./html.js";
import { LightFile } from "./light_file.js";

/** Range of the brightness in stops; a scene may exceed it. */
const EV_LIMIT = 4;
/** Value of the list without an environment. */
const NONE = "none";

/** @param {Event} event */
function choose(event) {
  const { value } = /** @type {HTMLSelectElement} */ (event.target);
  void chooseEnvironment(value === NONE ? null : value);
}

/** Stops of a scale, of which the controls adjust all channels. @param {number[]} scale */
function stopsOf(scale) {
  const strongest = Math.max(...scale);
  return strongest > 0 ? Math.round(100 * Math.log2(strongest)) / 100 : -EV_LIMIT;
}

export function EnvironmentKnobs() {
  const scene = sceneStore.editedScene.value;
  const present = environmentOf(scene);
  const image = present ? (present.image ?? "") : NONE;
  const isFile = present !== undefined && !Object.hasOwn(ENVIRONMENTS, image);
  const rotation = Math.round((((present?.rotation_deg ?? 0) % 360) + 360) % 360);
  const given = present?.scale ?? 1;
  const scale = typeof given === "number" ? [given, given, given] : given;
  const ev = stopsOf(scale);
  const strongest = Math.max(...scale);
  const brighten = (/** @type {number} */ to) => {
    const factor = strongest > 0 ? 2 ** to / strongest : 2 ** to;
    const own = strongest > 0 ? scale : [1, 1, 1];
    dragEnvironment({ scale: [own[0] * factor, own[1] * factor, own[2] * factor] });
  };
  return html`
    <div class="row">
      <label for="environment">Environment</label>
      <select id="environment" data-testid="environment" disabled=${!scene} onChange=${choose}>
        <option value=${NONE} selected=${!present}>none</option>
        ${Object.entries(ENVIRONMENTS).map(([one, name]) => html`<option key=${one} value=${one} selected=${one === image}>${name}</option>`)}
        ${isFile && html`<option value=${image} selected>from a file</option>`}
      </select>
    </div>
    <div class="row"><${LightFile} kind="environment" disabled=${!scene} /></div>
    ${present && html`
      <${Slider} id="environment-rotation" name="Rotation" title="Rotates the environment about the vertical axis" value=${rotation} min=${0} max=${359} step=${1} shown=${`${rotation}°`}
        onInput=${(/** @type {number} */ to) => dragEnvironment({ rotation_deg: to })} onCommit=${commitLight} />
      <${Slider} id="environment-ev" name="Brightness" title="Brightness of the environment beside the lamp" value=${ev} min=${-EV_LIMIT} max=${EV_LIMIT} step=${0.25} shown=${`${ev > 0 ? "+" : ""}${ev} EV`}
        onInput=${brighten} onCommit=${commitLight} />
    `}
  `;
}
