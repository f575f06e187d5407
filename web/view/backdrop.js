/** Controls of the backdrop: what pictures show behind the object. */
import { awaitPicture, chooseBackdrop, isPictureAwaited, openBackdrop } from "../scene/images.js";
import { commitLight, dragBackdrop } from "../scene/light_controls.js";
import { environmentOf } from "../scene/lights.js";
import { sceneStore } from "../scene/store.js";
import { stopUpload } from "../scene/upload.js";
import { Colour, Slider } from "./control.js";
import { html } from "./html.js";
import { ImageField } from "./image_field.js";
import { ProblemBox } from "./problem.js";
import { UploadProgress } from "./upload.js";

/** Blur of environments at first, degrees: the server's default. */
const BLUR_DEG = 12;
/** Largest blur of the slider, degrees. */
const BLUR_DEG_MAX = 60;
/** Colour at first, sRGB. */
const COLOR = /** @type {[number, number, number]} */ ([0.8, 0.8, 0.8]);

/** @param {number[]} color @returns {string} */
const hex = (color) =>
  `#${color.map((c) => Math.round(255 * c).toString(16).padStart(2, "0")).join("")}`;

/** @param {string} text @returns {[number, number, number]} */
const colorOf = (text) => [
  Number.parseInt(text.slice(1, 3), 16) / 255,
  Number.parseInt(text.slice(3, 5), 16) / 255,
  Number.parseInt(text.slice(5, 7), 16) / 255,
];

/** @param {Event} event */
function choose(event) {
  const { value } = /** @type {HTMLSelectElement} */ (event.target);
  if (value === "image") awaitPicture();
  else if (value === "environment") chooseBackdrop({ kind: "environment", blur_deg: BLUR_DEG });
  else chooseBackdrop(value === "color" ? { kind: "color", color: COLOR } : null);
}

export function BackdropKnobs() {
  const scene = sceneStore.editedScene.value;
  const backdrop = scene?.backdrop ?? null;
  const kind = isPictureAwaited() ? "image" : (backdrop?.kind ?? "none");
  const shown = kind === backdrop?.kind ? backdrop : null;
  return html`
    <div class="scene-image" role="group" aria-label="Backdrop" data-takes="backdrop" data-testid="backdrop-field">
      <div class="row">
        <label for="backdrop">Backdrop</label>
        <select id="backdrop" data-testid="backdrop" disabled=${!scene} onChange=${choose} title="What pictures show behind the object">
          <option value="none" selected=${kind === "none"}>none</option>
          <option value="environment" selected=${kind === "environment"} disabled=${!environmentOf(scene)}>environment, blurred</option>
          <option value="color" selected=${kind === "color"}>colour</option>
          <option value="image" selected=${kind === "image"}>picture</option>
        </select>
      </div>
      ${shown?.kind === "environment" && html`
        <${Slider} id="backdrop-blur" name="Blur" title="Width of the blur of the environment behind the object" value=${shown.blur_deg} min=${0} max=${BLUR_DEG_MAX} step=${1} shown=${`${shown.blur_deg}°`}
          onInput=${(/** @type {number} */ to) => dragBackdrop({ kind: "environment", blur_deg: to })} onCommit=${commitLight} />
      `}
      ${shown?.kind === "color" && html`
        <${Colour} id="backdrop-color" name="Colour" value=${hex(shown.color)}
          onInput=${(/** @type {string} */ to) => dragBackdrop({ kind: "color", color: colorOf(to) })} onCommit=${commitLight} />
      `}
      ${kind === "image" && html`
        <div class="row">
          <${ImageField} id="backdrop-image" name="picture" of="the backdrop" image=${shown?.kind === "image" ? shown.image : null}
            title="A PNG or JPEG, opened or dropped here; its middle covers the picture" onFile=${openBackdrop} />
        </div>
      `}
      <${UploadProgress} id="backdrop-sending" now=${sceneStore.uploads.value.get("backdrop")} stop=${() => stopUpload("backdrop")} />
      <${ProblemBox} place="backdrop" />
    </div>
  `;
}
