/**
 * Pictures in the form: scene, mask, and settings of each.
 *
 * @import { PictureDraft } from "../../search/views.js"
 */
import { lineageStore } from "../../lineage/store.js";
import { bytesInWords } from "../../page/format.js";
import { searchStore } from "../../search/store.js";
import {
  addPictures, changeView, chooseScene, readPictures, removeView, useSceneFile,
} from "../../search/target.js";
import { MOST_PICTURES, SAMPLINGS, UNCERTAINTIES, uncertaintyOf } from "../../search/views.js";
import { Choice, Switch, typed } from "../control.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";
import { CropField, Photo, PlacementFields } from "./photo.js";

const EXAMPLE = '{"mesh": "sphere", "camera": {"orbit_deg": [30, 20]}, "lights": [{"kind": "point"}]}';
export const PICTURES = ".png,.jpg,.jpeg,.hdr,.exr";

/** Files of an input, which may be chosen again after they were corrected. @param {Event} event */
export function filesChosen(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  const files = [...(input.files ?? [])];
  input.value = "";
  return files;
}

/**
 * True if the last refusal names a field of a picture.
 * @param {number} at
 * @param {...string} fields
 */
const isWrong = (at, ...fields) => searchStore.wrongPicture.value?.view === at && fields.includes(searchStore.wrongPicture.value.field);

/** The refusal, at the field that it names. @param {{at: number, fields: string[]}} props */
const Refusal = ({ at, fields }) => isWrong(at, ...fields) && html`<div class="whole" id=${`view-${at}-wrong`}><${ProblemBox} place="target" /></div>`;

/** @param {number} at @param {string} field */
const described = (at, field) => (isWrong(at, field) ? `view-${at}-wrong` : undefined);

/** @param {{of: PictureDraft, at: number}} props */
function SceneField({ of, at }) {
  const open = lineageStore.lineage.value;
  const options = [
    ...(of.placed ? [{ value: "placed", name: "from the picture", title: "Object and light as you place them on the picture" }] : []),
    ...(open ? [{ value: "open", name: "the lineage's", title: `Object, camera and light of “${open.name}”, which is open` }] : []),
    { value: "default", name: "the default", title: "The server's default: a sphere under one light" },
    { value: "given", name: "a scene file", title: "A scene as JSON" },
  ];
  return html`
    <div class="entry of-scene" role="group" aria-label=${`Scene of picture ${at + 1}`}>
      <span>scene</span>
      <${Choice} id=${`view-${at}-from`} name=${`Scene of picture ${at + 1}`} value=${of.from} options=${options} onInput=${(/** @type {any} */ from) => chooseScene(of, from)} />
      ${of.from === "given" && html`
        <div class="whole pasted" data-takes="scene" data-key=${of.key}>
          <textarea rows="4" spellcheck=${false} data-testid=${`view-${at}-scene`} aria-label=${`Scene of picture ${at + 1} as JSON`} placeholder=${EXAMPLE}
            value=${of.text} aria-invalid=${isWrong(at, "scene")} aria-describedby=${described(at, "scene")} onInput=${(/** @type {Event} */ event) => changeView(of.key, { text: typed(event) })}></textarea>
          <label class="button"><input type="file" accept=".json,application/json" data-testid=${`view-${at}-scene-file`} aria-label=${`File of the scene of picture ${at + 1}`}
            onChange=${(/** @type {Event} */ event) => filesChosen(event).forEach((file) => useSceneFile(file, of.key))} /><span>a file …</span></label>
        </div>
      `}
    </div>
    <${Refusal} at=${at} fields=${["scene", "spot"]} />
    ${of.from === "placed" ? html`<${PlacementFields} of=${of} at=${at} />` : html`<${LightAngle} of=${of} at=${at} />`}
  `;
}

/** Light angle of a scene. @param {{of: PictureDraft, at: number}} props */
const LightAngle = ({ of, at }) => html`
    <label class="entry">
      <span>light</span>
      <input type="text" inputmode="decimal" class="short" data-testid=${`view-${at}-light`} value=${of.light} placeholder="as it is" autocomplete="off" maxlength="20"
        aria-invalid=${isWrong(at, "light")} aria-describedby=${described(at, "light")} onInput=${(/** @type {Event} */ event) => changeView(of.key, { light: typed(event) })} />
      <span class="small">light angle, if not the scene's</span>
    </label>
    <${Refusal} at=${at} fields=${["light"]} />
`;

/** @param {{of: PictureDraft, at: number}} props */
const MaskField = ({ of, at }) => html`
  <div class="entry" data-takes="mask" data-key=${of.key}>
    <span>mask</span>
    <span class="begin">
      <label class="button"><input type="file" accept=${PICTURES} data-testid=${`view-${at}-mask`} aria-label=${`Mask of picture ${at + 1}`}
        onChange=${(/** @type {Event} */ event) => filesChosen(event).forEach((mask) => changeView(of.key, { mask }))} /><span class="cut">${of.mask ? of.mask.name : "none: choose one …"}</span></label>
      ${of.mask && html`<button type="button" class="remove" aria-label=${`No mask for picture ${at + 1}`} title="No mask" onClick=${() => changeView(of.key, { mask: null })}>×</button>`}
    </span>
    <span class="small">white where the picture is used</span>
  </div>
  <${Refusal} at=${at} fields=${["mask"]} />
`;

/** @param {{of: PictureDraft, at: number}} props */
const Samples = ({ of, at }) => html`
  <label class="entry">
    <span>rays a pixel</span>
    <select data-testid=${`view-${at}-samples`} value=${of.samples} aria-invalid=${isWrong(at, "samples")} onChange=${(/** @type {Event} */ event) => changeView(of.key, { samples: typed(event) })}>
      ${SAMPLINGS.map(({ value, name }) => html`<option key=${value} value=${value} selected=${value === of.samples}>${name}</option>`)}
    </select>
    <span class="small">${SAMPLINGS.find(({ value }) => value === of.samples)?.words}</span>
  </label>
  <${Refusal} at=${at} fields=${["samples"]} />
`;

/** How well the scene is known. @param {{of: PictureDraft, at: number}} props */
const Uncertainty = ({ of, at }) => {
  const known = uncertaintyOf(of.refine);
  return html`
    <label class="entry" title="A search corrects the scene within these standard deviations, together with the material">
      <span>scene known</span>
      <select data-testid=${`view-${at}-refine`} value=${known?.value ?? "list"} aria-invalid=${isWrong(at, "refine")} onChange=${(/** @type {Event} */ event) => changeView(of.key, { refine: UNCERTAINTIES.find(({ value }) => value === typed(event))?.refine })}>
        ${UNCERTAINTIES.map(({ value, name }) => html`<option key=${value} value=${value} selected=${value === known?.value}>${name}</option>`)}
        ${!known && html`<option value="list" selected>as in the list</option>`}
      </select>
      <span class="small">${known?.words ?? "as in the list"}</span>
    </label>
    <${Refusal} at=${at} fields=${["refine"]} />
  `;
};

/** @param {{of: PictureDraft, at: number, many: boolean}} props */
const Known = ({ of, at, many }) => html`
  <div class="chips">
    ${of.from !== "placed" && html`<${Switch} id=${`view-${at}-gain`} name="brightness unknown" label=${`The brightness of picture ${at + 1} is unknown`} on=${of.gain} title="Solves for a gain, so that only colours and shapes count"
      onInput=${(/** @type {boolean} */ gain) => changeView(of.key, { gain })} />`}
    ${(many || of.held_out) && html`<${Switch} id=${`view-${at}-held`} name="held out" label=${`Picture ${at + 1} is held out`} on=${of.held_out} title="Not fitted; used to measure results only"
      onInput=${(/** @type {boolean} */ held_out) => changeView(of.key, { held_out })} />`}
  </div>
  <${Refusal} at=${at} fields=${["gain", "held_out"]} />
`;

/** @param {{of: PictureDraft, at: number, many: boolean}} props */
const Card = ({ of, at, many }) => html`
  <li class="picture-of" aria-label=${`Picture ${at + 1}`}>
    <div class="row">
      ${many && html`<strong>${at + 1}</strong>`}
      <span class="cut grow" title=${of.file.name}>${of.file.name}</span> <span class="small">${bytesInWords(of.file.size)}</span>
      <button type="button" class="remove" aria-label=${`Leave out picture ${at + 1}, ${of.file.name}`} title="Leave out" onClick=${() => removeView(of.key)}>×</button>
    </div>
    <${Refusal} at=${at} fields=${["picture"]} />
    <${Photo} of=${of} at=${at} />
    <${CropField} of=${of} at=${at} />
    <${Refusal} at=${at} fields=${["crop"]} />
    <${SceneField} of=${of} at=${at} />
    <${MaskField} of=${of} at=${at} />
    <${Uncertainty} of=${of} at=${at} />
    <${Samples} of=${of} at=${at} />
    <${Known} of=${of} at=${at} many=${many} />
  </li>
`;

/** True if the refusal is shown at a field and not above all pictures. */
export const isShownAtField = () => {
  const wrong = searchStore.wrongPicture.value;
  return wrong !== null && wrong.view !== null && searchStore.draft.value.file !== null && searchStore.draft.value.kind === "image" && wrong.view < searchStore.draft.value.views.length
    && ["picture", "mask", "scene", "light", "samples", "gain", "held_out", "crop", "spot", "refine"].includes(wrong.field);
};

export function Pictures() {
  const { views, target } = searchStore.draft.value;
  const many = views.length > 1;
  const isRead = target !== null;
  return html`
    <ol class="pictures-of" aria-label="Pictures">${views.map((of, at) => html`<${Card} key=${of.key} of=${of} at=${at} many=${many} />`)}</ol>
    <div class="row">
      ${views.length < MOST_PICTURES && html`<label class="button"><input type="file" multiple accept=${PICTURES} data-testid="views-add" aria-label="Add another picture of the same material"
        onChange=${(/** @type {Event} */ event) => addPictures(filesChosen(event))} /><span>+ another picture</span></label>`}
      <span class="grow"></span>
      ${searchStore.picturesChanged.value && !isRead && !searchStore.upload.value && html`<span class="small warning" role="status">Changed since the last read.</span>`}
      <button type="button" class=${isRead ? "" : "primary"} data-testid="views-read" disabled=${searchStore.upload.value !== null || isRead} title="Reads the pictures; no search is started yet" onClick=${readPictures}>${isRead ? "Read" : many ? "Read the pictures" : "Read the picture"}</button>
    </div>
  `;
}
