/**
 * The light: its controls, and the dot that shows where it is. Owns what is told of it; the light itself is live/light.js.
 *
 * @import { Vec3 } from "../types.js"
 */
import { seenIn } from "../compare.js";
import { html } from "../html.js";
import { PLAIN } from "../light_color.js";
import { lamp, lampKnown, leaveLamp, turnLamp } from "../lighting.js";
import { letMove, moving, placeLight, rest, speed } from "../live/light.js";
import { able, isPictured, liveCells, sceneDrawable, watchers } from "../live/live.js";
import { still } from "../live/stills.js";
import { chooseLight, lightByFile, setShadows } from "../scene.js";
import { wishedScene } from "../state.js";
import { Colour, Slider, Switch } from "./control.js";
import { Trouble } from "./trouble.js";

/** Stops to either side; a scene may hold more. */
const EV_LIMIT = 4;
/** How far from the middle of the centre the dot is, where the light is at its farthest; in halves of its side. */
const REACH = 0.94;

/** The dot. Moved as things are drawn, without a pass over the page. @type {HTMLElement|null} */
let dot = null;

/** The angle is written so often in milliseconds: writing it lays the pane out anew. */
const TELLING_MS = 100;
let told = 0;

/** @param {number} degrees @param {Vec3|null} seen */
function follow(degrees, seen) {
  if (dot) {
    dot.hidden = seen === null;
    if (seen) {
      dot.style.transform = `translate(${50 * REACH * seen[0]}%, ${-50 * REACH * seen[1]}%)`;
      dot.classList.toggle("behind", seen[2] < 0);
    }
  }
  if (!moving.peek() || performance.now() - told < TELLING_MS) return;
  told = performance.now();
  const slider = /** @type {HTMLInputElement|null} */ (document.getElementById("light"));
  if (!slider || slider.matches(":active")) return;
  slider.value = String(Math.round(degrees));
  // The text node itself stays: it is the page's own, and gets the word for a resting light back when the light rests.
  const text = slider.parentElement?.querySelector("output")?.firstChild;
  if (text) text.nodeValue = `${Math.round(degrees)}°`;
}
watchers.add(follow);

export function LightDot() {
  const of = seenIn("centre");
  if (!liveCells.value.has("centre") && !((still.value || moving.value) && isPictured(of))) return null;
  return html`<span class="light-dot" data-testid="light-dot" aria-hidden="true" ref=${(/** @type {HTMLElement|null} */ element) => (dot = element)}></span>`;
}

/** Where the light is and how it moves, which only what is drawn live follows. */
function Circle() {
  if (able.value === false) return html`<p class="small">This browser draws nothing live (WebGL 2 is missing, or what it draws may not be read back), so the light rests.</p>`;
  const on = moving.value;
  return html`
    <div class="row">
      <button type="button" data-testid="light-moves" aria-pressed=${on} disabled=${able.value === null} onClick=${() => letMove(!on)}>${on ? "Pause the light" : "Let the light circle"}</button>
    </div>
    <${Slider} id="light" name="Angle" value=${rest.value} min=${0} max=${360} step=${1} shown=${on ? "moves" : `${Math.round(rest.value)}°`} dim=${on}
      turns=${(/** @type {number} */ to) => placeLight(to)} />
    <${Slider} id="light-speed" name="Speed" value=${speed.value} min=${5} max=${180} step=${5} shown=${`${speed.value}°/s`}
      turns=${(/** @type {number} */ to) => (speed.value = to)} />
    ${!sceneDrawable.value && html`<p class="small" data-testid="stills">Point lights without shadows, tone curve and plain normals are drawn live. These are pictures of the server, which follow the light in steps.</p>`}
  `;
}

/** @type {{kind: import("../types.js").LightKind, name: string}[]} */
const KINDS = [
  { kind: "point", name: "point" },
  { kind: "directional", name: "directional" },
  { kind: "spot", name: "spot" },
  { kind: "sphere", name: "sphere" },
  { kind: "disk", name: "disk" },
  { kind: "rectangle", name: "rectangle" },
  { kind: "ambient", name: "ambient" },
];
/** Those that are chosen by a file. @type {{kind: "ies"|"environment", name: string, accept: string}[]} */
const FROM_FILES = [
  { kind: "ies", name: "IES profile…", accept: ".ies,.IES" },
  { kind: "environment", name: "environment…", accept: ".hdr,.exr" },
];

/** @param {"ies"|"environment"} kind @param {Event} event */
function readFile(kind, event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  const [file] = input.files ?? [];
  if (file) void lightByFile(kind, file);
  input.value = "";
}

/** Which kind of light it is, and whether it casts shadows. */
function Kind() {
  const scene = wishedScene.value;
  const kind = scene?.lights?.[0]?.kind ?? "point";
  const others = (scene?.lights?.length ?? 1) - 1;
  const file = FROM_FILES.find((one) => one.kind === kind);
  return html`
    <div class="row">
      <select data-testid="light-kind" aria-label="Kind of light" disabled=${!scene}
        onChange=${(/** @type {Event} */ event) => chooseLight(/** @type {import("../types.js").LightKind} */ (/** @type {HTMLSelectElement} */ (event.target).value))}>
        ${KINDS.map((one) => html`<option key=${one.kind} value=${one.kind} selected=${one.kind === kind}>${one.name}</option>`)}
        ${file && html`<option value=${kind} selected>${file.name.replace("…", "")}</option>`}
      </select>
      <${Switch} id="shadows" name="shadows" on=${scene?.shadows ?? false} turns=${setShadows} title="What stands in the way of the light darkens what is behind it" />
    </div>
    <div class="row">
      ${FROM_FILES.map((one) => html`
        <label key=${one.kind} class="button">
          <input type="file" accept=${one.accept} data-testid=${`light-${one.kind}`} aria-label=${one.name.replace("…", "")} disabled=${!scene} onChange=${(/** @type {Event} */ event) => readFile(one.kind, event)} />
          <span>${one.name}</span>
        </label>
      `)}
    </div>
    ${others > 0 && html`<p class="small">${others} more ${others === 1 ? "light stays" : "lights stay"} as the scene has ${others === 1 ? "it" : "them"}.</p>`}
  `;
}

/** What the light is like, which belongs to the scene. */
function Lamp() {
  const { color, ev } = lamp.value ?? PLAIN;
  const dark = lamp.value === null;
  const auto = wishedScene.value?.film.exposure === "auto";
  const white = () => {
    turnLamp({ color: PLAIN.color });
    leaveLamp();
  };
  return html`
    <${Colour} id="light-color" name="Colour" value=${color} disabled=${!lampKnown.value}
      turns=${(/** @type {string} */ to) => turnLamp({ color: to })} rests=${leaveLamp}>
      ${color === PLAIN.color
        ? html`<output for="light-color">white</output>`
        : html`<button type="button" data-testid="light-white" title="White light again" onClick=${white}>White</button>`}
    <//>
    <${Slider} id="light-ev" name="Intensity" value=${ev} min=${-EV_LIMIT} max=${EV_LIMIT} step=${0.25} disabled=${!lampKnown.value} dim=${auto}
      shown=${dark ? "dark" : `${ev > 0 ? "+" : ""}${ev} EV`} title=${auto ? "Automatic exposure evens it out; a fixed one shows it" : undefined}
      turns=${(/** @type {number} */ to) => turnLamp({ ev: to })} rests=${leaveLamp} />
    ${auto && ev !== 0 && html`<p class="small">Automatic exposure evens the intensity out.</p>`}
    <${Trouble} place="light" />
  `;
}

export function LightKnobs() {
  return html`
    <section aria-labelledby="light-title">
      <h2 id="light-title">Light</h2>
      <${Kind} /><${Circle} /><${Lamp} />
    </section>
  `;
}
