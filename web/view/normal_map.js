/** Controls of the normal map of a part of the scene: its image, strength and repetitions. */
import {
  NORMAL_MAP_PLACES, commitNormalMap, dragNormalMap, openNormalMap, removeNormalMap,
} from "../scene/images.js";
import { PLAIN, normalMapOf, short } from "../scene/normal_map.js";
import { sceneStore } from "../scene/store.js";
import { stopUpload } from "../scene/upload.js";
import { Slider } from "./control.js";
import { html } from "./html.js";
import { ImageField } from "./image_field.js";
import { ProblemBox } from "./problem.js";
import { UploadProgress } from "./upload.js";

/** Largest strength, and largest number of repetitions of the slider; a scene may have more. */
const STRENGTH_MAX = 4;
const REPEAT_MAX = 32;

/** Names of the parts in words. */
const PARTS = { subject: "the object", neighbour: "the other object", ground: "the ground" };

/** @param {{part: import("../scene/normal_map.js").Part}} props */
export function NormalMap({ part }) {
  const map = normalMapOf(sceneStore.editedScene.value, part);
  const place = NORMAL_MAP_PLACES[part];
  const prefix = part === "subject" ? "" : `${part}-`;
  const { strength, repeat } = { ...PLAIN, ...map };
  const commit = () => commitNormalMap(part);
  return html`
    <div class="scene-image" role="group" aria-label=${`Normal map of ${PARTS[part]}`} data-takes="normal-map" data-part=${part} data-testid=${`${prefix}normal-map-field`}>
      <div class="row">
        ${map && html`<span class="small" aria-hidden="true">Normal map</span>`}
        <${ImageField} id=${`${prefix}normal-map`} name="normal map" of=${PARTS[part]} image=${map?.image ?? null}
          title="A PNG or JPEG, opened or dropped here: red along growing u, green along growing v" onFile=${(/** @type {File} */ file) => void openNormalMap(part, file)} />
        ${map && html`
          <button type="button" data-testid=${`${prefix}normal-map-remove`} aria-label=${`Remove the normal map of ${PARTS[part]}`}
            onClick=${() => void removeNormalMap(part)}>Remove</button>
        `}
      </div>
      ${map && html`
        <${Slider} id=${`${prefix}normal-strength`} name="Strength" title="Height of the bumps; below 0 they are dents" value=${strength} min=${-STRENGTH_MAX} max=${STRENGTH_MAX} step=${0.1} shown=${short(strength)}
          onInput=${(/** @type {number} */ to) => dragNormalMap(part, { strength: to })} onCommit=${commit} />
        <${Slider} id=${`${prefix}normal-repeat`} name="Repeats" title="Number of times the image repeats across the texture" value=${repeat} min=${1} max=${REPEAT_MAX} step=${1} shown=${short(repeat)}
          onInput=${(/** @type {number} */ to) => dragNormalMap(part, { repeat: to })} onCommit=${commit} />
      `}
      <${UploadProgress} id=${`${prefix}normal-map-sending`} now=${sceneStore.uploads.value.get(place)} stop=${() => stopUpload(place)} />
      <${ProblemBox} place=${place} />
    </div>
  `;
}
