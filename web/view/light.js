/**
 * Controls of the light, and the dot that shows where it is.
 *
 * @import { Vec3 } from "../model.js"
 */
import { effect } from "../vendor/signals-core.js";
import { individualSeenIn } from "../compare/ab.js";
import { commitAngle, dragAngle, restAngle, setLightMoving } from "../live/light_circle.js";
import { isServerDrawn } from "../live/loop.js";
import { liveStore } from "../live/store.js";
import { chooseLamp, lightByFile, setShadows } from "../scene/edit.js";
import { NEUTRAL } from "../scene/light_color.js";
import { commitLight, dragLight, dragShape } from "../scene/light_controls.js";
import { LIGHT_KINDS } from "../scene/light_kind.js";
import { shapeControls } from "../scene/light_shape.js";
import { lampOf, othersOf } from "../scene/lights.js";
import { sceneStore } from "../scene/store.js";
import { stopUpload } from "../scene/upload.js";
import { BackdropKnobs } from "./backdrop.js";
import { Colour, Slider, Switch } from "./control.js";
import { EnvironmentKnobs } from "./environment.js";
import { html } from "./html.js";
import { ProblemBox } from "./problem.js";
import { LightFile } from "./light_file.js";
import { UploadProgress } from "./upload.js";

/** Range of the intensity in stops; a scene may exceed it. */
const EV_LIMIT = 4;
/** Largest distance of the dot from the centre of the frame, relative to half of its side. */
const REACH = 0.94;

/** The dot; moved directly, without redrawing a component. @type {HTMLElement|null} */
let dot = null;

/** Milliseconds between two writes of the angle, because each causes a new layout of the pane. */
const WRITE_MS = 100;
let writtenAt = 0;

/**
 * Moves the dot.
 * @param {Vec3|null} direction of the light as the camera sees it; null without a light
 */
function placeDot(direction) {
  if (!dot) return;
  dot.hidden = direction === null;
  if (!direction) return;
  dot.style.transform = `translate(${50 * REACH * direction[0]}%, ${-50 * REACH * direction[1]}%)`;
  dot.classList.toggle("behind", direction[2] < 0);
}

/** Writes the angle of the moving light to its slider. @param {number} degrees */
function writeAngle(degrees) {
  if (!liveStore.lightMoving.peek() || performance.now() - writtenAt < WRITE_MS) return;
  writtenAt = performance.now();
  const slider = /** @type {HTMLInputElement|null} */ (document.getElementById("light"));
  if (!slider || slider.matches(":active")) return;
  slider.value = String(Math.round(degrees));
  // The text node belongs to the component, which writes to it again when the light rests.
  const text = slider.parentElement?.querySelector("output")?.firstChild;
  if (text) text.nodeValue = `${Math.round(degrees)}°`;
}

/** Follows the light as it is drawn. */
export const watchLightDot = () => effect(() => {
  const drawn = liveStore.drawnLight.value;
  if (!drawn) return;
  placeDot(drawn.direction);
  writeAngle(drawn.degrees);
});

/** The dot may appear after the last drawing. @param {HTMLElement|null} element */
function attachDot(element) {
  dot = element;
  placeDot(liveStore.drawnLight.peek()?.direction ?? null);
}

export function LightDot() {
  const of = individualSeenIn("centre");
  if (!liveStore.liveCells.value.has("centre") && !((liveStore.still.value || liveStore.lightMoving.value) && isServerDrawn(of))) return null;
  return html`<span class="light-dot" data-testid="light-dot" aria-hidden="true" ref=${attachDot}></span>`;
}

/** True if the picture behind the scene is one that the browser cannot draw as the server does. */
function refusedPicture() {
  const backdrop = sceneStore.editedScene.value?.backdrop;
  return backdrop?.kind === "image" && liveStore.refusedImages.value.has(backdrop.image);
}

/** Angle and speed of the light, which live frames follow. */
function Circle() {
  const on = liveStore.lightMoving.value;
  const rest = restAngle();
  const circles = liveStore.lightCircles.value;
  return html`
    ${liveStore.supported.value === false
      ? html`<p class="small">Live preview is not available: WebGL 2 is missing or its pixels cannot be read. The light cannot circle.</p>`
      : html`
        <div class="row">
          <button type="button" data-testid="light-moves" aria-pressed=${on} disabled=${liveStore.supported.value === null || !circles} onClick=${() => setLightMoving(!on)}>${on ? "Pause the light" : "Let the light circle"}</button>
        </div>
      `}
    <${Slider} id="light" name="Angle" title="Rotates the lights about the vertical axis" value=${rest} min=${0} max=${359} step=${1} shown=${on ? "moving" : `${Math.round(rest)}°`} dim=${on} disabled=${!circles}
      onInput=${dragAngle} onCommit=${commitAngle} />
    ${liveStore.supported.value !== false && html`
      <${Slider} id="light-speed" name="Speed" value=${liveStore.lightSpeed.value} min=${5} max=${180} step=${5} shown=${`${liveStore.lightSpeed.value}°/s`}
        onInput=${(/** @type {number} */ to) => (liveStore.lightSpeed.value = to)} />
    `}
    ${sceneStore.scene.value && !circles && html`<p class="small">The environment stays in place; a lamp would circle.</p>`}
    ${liveStore.supported.value !== false && !liveStore.sceneDrawable.value && html`<p class="small" data-testid="stills">Live preview needs curved normals, no normal maps, and point, spot or directional lights; an environment only around an object alone without shadows. ${refusedPicture() ? "This browser cannot read the picture behind as the server does. " : ""}Showing server renders.</p>`}
  `;
}

/** Kinds of lamps that need no file. */
const KINDS = /** @type {import("../model.js").LightKind[]} */ (Object.keys(LIGHT_KINDS)).filter((kind) => !LIGHT_KINDS[kind].accept);
/** Value of the list of lamps without a lamp. */
const NONE = "none";

/** @param {Event} event */
function choose(event) {
  const { value } = /** @type {HTMLSelectElement} */ (event.target);
  void chooseLamp(value === NONE ? null : /** @type {import("../model.js").LightKind} */ (value));
}

/** Kind of lamp, and shadows. */
function Kind() {
  const scene = sceneStore.editedScene.value;
  const lamp = lampOf(scene);
  const kind = lamp ? (lamp.kind ?? "point") : NONE;
  const others = othersOf(scene);
  return html`
    <div class="row">
      <label for="light-kind">Lamp</label>
      <select id="light-kind" data-testid="light-kind" disabled=${!scene} onChange=${choose}>
        <option value=${NONE} selected=${!lamp}>none</option>
        ${KINDS.map((one) => html`<option key=${one} value=${one} selected=${one === kind}>${LIGHT_KINDS[one].name}</option>`)}
        ${kind === "ies" && html`<option value="ies" selected>${LIGHT_KINDS.ies.name}</option>`}
      </select>
    </div>
    <div class="row">
      <${LightFile} kind="ies" disabled=${!scene} />
      <${Switch} id="shadows" name="shadows" on=${scene?.shadows ?? false} onInput=${setShadows} title="Objects cast shadows" />
    </div>
    ${others > 0 && html`<p class="small">${others} more ${others === 1 ? "light stays" : "lights stay"} as the scene has ${others === 1 ? "it" : "them"}.</p>`}
  `;
}

/** Size, cone and softness of the lamp. */
function Shape() {
  const scene = sceneStore.editedScene.value;
  const light = lampOf(scene);
  const extent = scene && sceneStore.extents.value.get(scene.mesh);
  if (!light || !extent) return null;
  return shapeControls(light, extent).map(({ change, ...control }) => html`
    <${Slider} key=${control.id} ...${control} onInput=${(/** @type {number} */ to) => dragShape(change(to))} onCommit=${commitLight} />
  `);
}

/** Colour and intensity of the light, which belong to the scene. */
function Lamp() {
  const { color, ev } = sceneStore.lightSetting.value ?? NEUTRAL;
  const dark = sceneStore.lightSetting.value === null;
  const auto = sceneStore.editedScene.value?.film.exposure === "auto";
  const white = () => {
    dragLight({ color: NEUTRAL.color });
    commitLight();
  };
  return html`
    <${Colour} id="light-color" name="Colour" value=${color} disabled=${!sceneStore.lightEditable.value}
      onInput=${(/** @type {string} */ to) => dragLight({ color: to })} onCommit=${commitLight}>
      ${color === NEUTRAL.color
        ? html`<output for="light-color">white</output>`
        : html`<button type="button" data-testid="light-white" title="White light again" onClick=${white}>White</button>`}
    <//>
    <${Slider} id="light-ev" name="Intensity" value=${ev} min=${-EV_LIMIT} max=${EV_LIMIT} step=${0.25} disabled=${!sceneStore.lightEditable.value} dim=${auto}
      shown=${dark ? "dark" : `${ev > 0 ? "+" : ""}${ev} EV`} title=${auto ? "Automatic exposure cancels the intensity; a fixed one shows it" : undefined}
      onInput=${(/** @type {number} */ to) => dragLight({ ev: to })} onCommit=${commitLight} />
    ${auto && ev !== 0 && html`<p class="small">Automatic exposure cancels the intensity.</p>`}
    <${ProblemBox} place="light" />
  `;
}

export function LightKnobs() {
  return html`
    <section aria-labelledby="light-title">
      <h2 id="light-title">Light</h2>
      <${EnvironmentKnobs} /><${BackdropKnobs} />
      <${UploadProgress} id="light-sending" now=${sceneStore.uploads.value.get("light")} stop=${() => stopUpload("light")} />
      <${Kind} /><${Shape} /><${Circle} /><${Lamp} />
    </section>
  `;
}
