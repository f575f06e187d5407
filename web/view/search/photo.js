/**
 * A photograph in the form: the picture with its crop, the object and the spot of the light, all to
 * be dragged, and the same as numbers.
 *
 * @import { Vec3 } from "../../model.js"
 * @import { Area, Circle } from "../../photo/placement.js"
 * @import { Placed } from "../../photo/setup.js"
 * @import { PictureDraft } from "../../search/views.js"
 */
import { moved, pressed, released } from "../../photo/drag.js";
import {
  chooseObject, findCircle, findSpot, setCircle, setCrop, setFov, setLens, setRotation, setSpot,
  setSurface, settle, showPhoto, uncrop,
} from "../../photo/edit.js";
import { seenMesh } from "../../photo/mesh.js";
import {
  BALL, LENSES, cameraOfPlaced, isWhole, lensOf, lightInWords, wholeOf,
} from "../../photo/setup.js";
import { photoStore } from "../../photo/store.js";
import { fromDegrees } from "../../scene/rotation.js";
import { sceneStore } from "../../scene/store.js";
import { cropOf } from "../../search/views.js";
import { Choice, typed } from "../control.js";
import { html } from "../html.js";

const OBJECTS = [
  { value: BALL, name: "a ball" },
  { value: "ball", name: "ball on a base" },
  { value: "torus", name: "torus" },
  { value: "cube", name: "cube" },
  { value: "knob", name: "knob" },
];
const SURFACES = [
  { value: "glossy", name: "highlight", title: "The spot is a highlight: a mirror image of the light" },
  { value: "matt", name: "brightest point", title: "The surface is matt: it is brightest where it faces the light" },
];
const DRAGS = [
  { value: "move", name: "moves it" },
  { value: "turn", name: "turns it", title: "Also with Alt held down" },
];
/** Corners and edges of the crop: points of the compass, and where they are. */
const GRIPS = [
  { grip: "nw", x: 0, y: 0 },
  { grip: "n", x: 0.5, y: 0 },
  { grip: "ne", x: 1, y: 0 },
  { grip: "e", x: 1, y: 0.5 },
  { grip: "se", x: 1, y: 1 },
  { grip: "s", x: 0.5, y: 1 },
  { grip: "sw", x: 0, y: 1 },
  { grip: "w", x: 0, y: 0.5 },
];

/** Radius of the ring around the spot of the light, relative to the longer side. */
const SPOT = 0.02;

/**
 * A number that is typed or stepped.
 * @param {{id: string, name: string, label: string, value: number, step?: number, onInput: (value:
 *   number) => void, onCommit?: () => void}} props `label`: the whole name
 */
const NumberField = ({ id, name, label, value, step = 1, onInput, onCommit }) => html`
  <label class="number"><span>${name}</span>
    <input type="number" data-testid=${id} aria-label=${label} value=${value} step=${step} inputmode="decimal" autocomplete="off"
      onInput=${(/** @type {Event} */ event) => typed(event) !== "" && Number.isFinite(Number(typed(event))) && onInput(Number(typed(event)))} onChange=${onCommit} />
  </label>
`;

/** A handle of constant size on the screen. @param {{grip: string, x: number, y: number}} props */
const Handle = ({ grip, x, y }) => html`
  <g class=${`handle ${grip}`} data-grip=${grip}>
    <path class="reach" d=${`M${x} ${y}h0`} /><path class="rim" d=${`M${x} ${y}h0`} /><path class="seen" d=${`M${x} ${y}h0`} />
  </g>
`;

/**
 * The crop, with everything else darkened.
 * @param {{crop: Area, size: {width: number, height: number}}} props
 */
const Crop = ({ crop: { x, y, width, height }, size }) => html`
  <path class="left-out" d=${`M0 0H${size.width}V${size.height}H0ZM${x} ${y}v${height}h${width}v${-height}Z`} />
  <rect class="crop" x=${x} y=${y} width=${width} height=${height} />
  ${GRIPS.map((one) => html`<${Handle} key=${one.grip} grip=${one.grip} x=${x + one.x * width} y=${y + one.y * height} />`)}
`;

/** Lines of a path. @param {number[]} outline */
function pathOf(outline) {
  const parts = [];
  for (let at = 0; at < outline.length; at += 4)
    parts.push(`M${outline[at].toFixed(1)} ${outline[at + 1].toFixed(1)}L${outline[at + 2].toFixed(1)} ${outline[at + 3].toFixed(1)}`);
  return parts.join("");
}

/** The outline of a mesh. @param {{placed: Placed, crop: Area}} props */
function Outline({ placed, crop }) {
  const arrays = photoStore.meshes.value.get(placed.mesh);
  if (!arrays || typeof arrays === "string") return null;
  const { outline } = seenMesh(cameraOfPlaced(placed, crop), crop, arrays, fromDegrees(placed.rotation_deg));
  return html`<path class="outline" data-testid="photo-outline" d=${pathOf(outline)} />`;
}

/** The object and the spot of the light. @param {{placed: Placed, crop: Area}} props */
function Placement({ placed, crop }) {
  const { circle, spot, mesh, size } = placed;
  const diagonal = circle.radius * Math.SQRT1_2;
  return html`
    <circle class=${mesh === BALL ? "object" : "object loose"} data-grip="object" cx=${circle.x} cy=${circle.y} r=${circle.radius} />
    ${mesh !== BALL && html`<${Outline} placed=${placed} crop=${crop} />`}
    <circle class="rim-of" data-grip="rim" cx=${circle.x} cy=${circle.y} r=${circle.radius} />
    <${Handle} grip="rim" x=${circle.x + diagonal} y=${circle.y - diagonal} />
    <g class="spot-of" data-grip="spot">
      <path class="reach" d=${`M${spot.x} ${spot.y}h0`} />
      <circle class="under" cx=${spot.x} cy=${spot.y} r=${SPOT * Math.max(size.width, size.height)} /><circle class="seen" cx=${spot.x} cy=${spot.y} r=${SPOT * Math.max(size.width, size.height)} />
    </g>
  `;
}

/** @param {{of: PictureDraft, at: number, placed: Placed, crop: Area, url: string}} props */
const Paper = ({ of, at, placed, crop, url }) => html`
  <svg class="photo-paper" data-testid=${`view-${at}-paper`} role="img" aria-label=${`Picture ${at + 1} with its crop${of.from === "placed" ? ", the object and the spot of the light" : ""}. The fields below set the same.`}
    viewBox=${`0 0 ${placed.size.width} ${placed.size.height}`} onPointerDown=${pressed(of)} onPointerMove=${moved} onPointerUp=${released} onPointerCancel=${released}>
    <image href=${url} width=${placed.size.width} height=${placed.size.height} preserveAspectRatio="none" />
    <${Crop} crop=${crop} size=${placed.size} />
    ${of.from === "placed" && html`<${Placement} placed=${placed} crop=${crop} />`}
  </svg>
`;

/** @param {{of: PictureDraft, at: number, crop: Area, placed: Placed}} props */
function CropFields({ of, at, crop, placed }) {
  /** @param {string} field @param {string} name @param {"x"|"y"|"width"|"height"} side */
  const number = (field, name, side) => html`<${NumberField} id=${`view-${at}-crop-${field}`} name=${name} label=${`Crop of picture ${at + 1}: ${side === "x" ? "left" : side === "y" ? "top" : side}, pixels`} value=${crop[side]}
    onInput=${(/** @type {number} */ to) => setCrop(of.key, { ...crop, [side]: to })} onCommit=${() => settle(of.key)} />`;
  return html`
    <div class="entry" role="group" aria-label=${`Crop of picture ${at + 1}`}>
      <span>crop</span>
      <span class="numbers">${number("x", "left", "x")}${number("y", "top", "y")}${number("w", "width", "width")}${number("h", "height", "height")}
        ${!isWhole(crop, placed.size) && html`<button type="button" data-testid=${`view-${at}-crop-whole`} onClick=${() => uncrop(of.key)}>Whole picture</button>`}</span>
    </div>
  `;
}

/**
 * Objects that can be placed: built in, uploaded, and that of the open lineage.
 * @param {string} present
 */
function objects(present) {
  const uploaded = sceneStore.meshes.value.map((one) => ({ value: one.answer.id, name: one.name }));
  const open = sceneStore.scene.value?.mesh ?? BALL;
  const all = [...OBJECTS, ...uploaded];
  for (const mesh of [open, present])
    if (!all.some(({ value }) => value === mesh)) all.push({ value: mesh, name: "the lineage's object" });
  return all;
}

/** @param {{of: PictureDraft, at: number, placed: Placed}} props */
function ObjectFields({ of, at, placed }) {
  const { circle, mesh, rotation_deg } = placed;
  /** @param {keyof Circle} side @param {string} name @param {string} words */
  const number = (side, name, words) => html`<${NumberField} id=${`view-${at}-circle-${side}`} name=${name} label=${`Object of picture ${at + 1}: ${words}, pixels`} value=${circle[side]} step="any"
    onInput=${(/** @type {number} */ to) => setCircle(of.key, { ...circle, [side]: to })} onCommit=${() => settle(of.key)} />`;
  /** @param {0|1|2} axis */
  const turn = (axis) => html`<${NumberField} id=${`view-${at}-turn-${"xyz"[axis]}`} name=${`turn ${"xyz"[axis]}`} label=${`Object of picture ${at + 1}: rotation about ${"xyz"[axis]}, degrees`} value=${rotation_deg[axis]} step="any"
    onInput=${(/** @type {number} */ to) => setRotation(of.key, /** @type {Vec3} */ (rotation_deg.map((one, k) => (k === axis ? to : one))))} />`;
  const failure = photoStore.meshes.value.get(mesh);
  return html`
    <div class="entry" role="group" aria-label=${`Object of picture ${at + 1}`}>
      <span>object</span>
      <span class="numbers">
        <select data-testid=${`view-${at}-object`} aria-label=${`Object of picture ${at + 1}`} value=${mesh} onChange=${(/** @type {Event} */ event) => chooseObject(of.key, typed(event))}>
          ${objects(mesh).map(({ value, name }) => html`<option key=${value} value=${value} selected=${value === mesh}>${name}</option>`)}
        </select>
        <button type="button" data-testid=${`view-${at}-circle-find`} title="Searches for the outline of a ball" onClick=${() => findCircle(of.key)}>Find it</button>
        ${number("x", "middle x", "middle from the left")}${number("y", "y", "middle from the top")}${number("radius", "radius", "radius")}
      </span>
      ${!placed.found && html`<span class="small warning whole" role="status">No ball was found: drag the circle over it.</span>`}
      ${typeof failure === "string" && html`<span class="small warning whole" role="alert">${failure}</span>`}
    </div>
    ${mesh !== BALL && html`
      <div class="entry" role="group" aria-label=${`Rotation of the object of picture ${at + 1}`}>
        <span>dragging</span>
        <span class="numbers">
          <${Choice} id=${`view-${at}-drag`} name="Dragging the object" value=${photoStore.dragMode.value} options=${DRAGS} onInput=${(/** @type {any} */ to) => (photoStore.dragMode.value = to)} />
          ${turn(0)}${turn(1)}${turn(2)}
        </span>
      </div>
    `}
  `;
}

/** @param {{of: PictureDraft, at: number, placed: Placed}} props */
const LensFields = ({ of, at, placed }) => html`
  <div class="entry" role="group" aria-label=${`Lens of picture ${at + 1}`}>
    <span>lens</span>
    <span class="numbers">
      <${Choice} id=${`view-${at}-lens`} name=${`Lens of picture ${at + 1}`} value=${lensOf(placed)} options=${LENSES} onInput=${(/** @type {string} */ lens) => setLens(of.key, lens)} />
      <${NumberField} id=${`view-${at}-fov`} name="field of view °" label=${`Vertical field of view of the whole picture ${at + 1}, degrees`} value=${Number(placed.fov_y_deg.toFixed(2))} step="any" onInput=${(/** @type {number} */ to) => to > 0 && setFov(of.key, to)} />
    </span>
  </div>
`;

/** @param {{of: PictureDraft, at: number, placed: Placed}} props */
function LightFields({ of, at, placed }) {
  const { spot, light, surface } = placed;
  /** @param {"x"|"y"} side @param {string} name */
  const number = (side, name) => html`<${NumberField} id=${`view-${at}-spot-${side}`} name=${name} label=${`Spot of the light in picture ${at + 1}: ${side === "x" ? "from the left" : "from the top"}, pixels`} value=${spot[side]} step="any"
    onInput=${(/** @type {number} */ to) => setSpot(of.key, { ...spot, [side]: to })} />`;
  return html`
    <div class="entry" role="group" aria-label=${`Light of picture ${at + 1}`}>
      <span>light</span>
      <span class="numbers">
        <${Choice} id=${`view-${at}-surface`} name=${`Spot of the light in picture ${at + 1}`} value=${surface} options=${SURFACES} onInput=${(/** @type {any} */ to) => setSurface(of.key, to)} />
        ${placed.mesh === BALL && html`<button type="button" data-testid=${`view-${at}-spot-find`} title="Searches for a highlight, or for the direction of the light on a matt ball" onClick=${() => findSpot(of.key)}>Find it</button>`}
        ${number("x", "spot x")}${number("y", "y")}
      </span>
      <span class="small whole" role="status" data-testid=${`view-${at}-light-words`}>${light ? `Light ${lightInWords(light)}.` : "The spot is not on the object: drag it to the highlight."}</span>
    </div>
  `;
}

/**
 * The picture, large, and the fields that place it.
 * @param {{of: PictureDraft, at: number}} props
 */
export function Photo({ of, at }) {
  const shown = photoStore.shown.value.get(of.key);
  const begin = (/** @type {HTMLElement|null} */ element) => element && void showPhoto(of);
  const { placed } = of;
  if (typeof shown === "string") return html`<p class="small warning" role="status" data-testid=${`view-${at}-not-shown`}>${shown}</p>`;
  if (!shown || !placed) return html`<p class="small" ref=${begin}>Opening the picture …</p>`;
  const crop = cropOf(of) ?? wholeOf(placed.size);
  return html`
    <div class="photo" data-testid=${`view-${at}-photo`}>
      <${Paper} of=${of} at=${at} placed=${placed} crop=${crop} url=${shown.url} />
      ${of.from === "placed" && html`<p class="small">Drag the circle onto the object, the yellow ring onto its highlight (or click there), and the corners to crop.</p>`}
    </div>
  `;
}

/**
 * Fields of object, lens and light, in place of a scene.
 * @param {{of: PictureDraft, at: number}} props
 */
export const PlacementFields = ({ of, at }) => of.placed && html`
  <${ObjectFields} of=${of} at=${at} placed=${of.placed} />
  <${LensFields} of=${of} at=${at} placed=${of.placed} />
  <${LightFields} of=${of} at=${at} placed=${of.placed} />
`;

/** @param {{of: PictureDraft, at: number}} props */
export const CropField = ({ of, at }) => of.placed && html`<${CropFields} of=${of} at=${at} placed=${of.placed} crop=${cropOf(of) ?? wholeOf(of.placed.size)} />`;
