/** Images of a painted individual: opened in a place of its effects, with a share, or removed. */
import { imageUrl } from "../../api/routes.js";
import { percent, placeInWords, placeKey, placesOf } from "../../lineage/images.js";
import {
  applyShare, choosePlace, isShareMoved, moveShare, openImage, presentImage, presentPlace, presentShare, removeImage,
} from "../../lineage/place_image.js";
import { PICTURES } from "../../lineage/painting.js";
import { sceneStore } from "../../scene/store.js";
import { stopUpload } from "../../scene/upload.js";
import { Slider, typed } from "../control.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";
import { UploadProgress } from "../upload.js";

/**
 * A small picture of an image.
 * @param {{image: string, name: string}} props `name`: where it is, in words
 */
export const Thumbnail = ({ image, name }) =>
  html`<img class="thumbnail" src=${imageUrl(image)} alt=${`Image: ${name}`} loading="lazy" decoding="async" />`;

/** @param {Event} event */
function readFile(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  const [file] = input.files ?? [];
  if (file) void openImage(file);
  // The same file may be chosen again.
  input.value = "";
}

/** @param {{of: import("../../model.js").Effect[]}} props effects of the centre */
export function Images({ of }) {
  const place = presentPlace();
  if (!place) return null;
  const image = presentImage();
  const share = presentShare();
  const isMoved = isShareMoved();
  const key = placeKey(place);
  return html`
    <div class="images" role="group" aria-labelledby="images-title" data-takes="image" data-testid="images">
      <p class="small" id="images-title">Images</p>
      <div class="row where">
        <label for="image-place">Where</label>
        <select id="image-place" class="grow" data-testid="image-place" value=${key}
          onChange=${(/** @type {Event} */ event) => choosePlace(typed(event))}>
          ${placesOf(of).map((one) => html`
            <option key=${placeKey(one)} value=${placeKey(one)} selected=${placeKey(one) === key}>
              ${placeInWords(one)}
            </option>
          `)}
        </select>
      </div>
      <div class="row">
        ${image && html`<${Thumbnail} image=${image.image} name=${placeInWords(place)} />`}
        <label class="button" title="A PNG or JPEG, opened or dropped here">
          <input type="file" accept=${PICTURES} data-testid="image-file" aria-label="Open an image"
            onChange=${readFile} />
          <span>Open an image</span>
        </label>
        ${image && html`
          <button type="button" data-testid="image-remove" title="A child without this image"
            onClick=${() => void removeImage()}>Remove</button>
        `}
      </div>
      <div class="share">
        <${Slider} id="image-share" name="Share" title="Share of the image; the rest is painted without it"
          value=${share} min=${0} max=${1} step=${0.01} shown=${percent(share)} onInput=${moveShare} />
        ${image && html`
          <button type="button" class=${isMoved ? "on" : ""} data-testid="image-apply"
            aria-disabled=${isMoved ? undefined : "true"} title="A child with this share of the image"
            onClick=${() => isMoved && void applyShare()}>Apply</button>
        `}
      </div>
      <${UploadProgress} id="image-sending" now=${sceneStore.uploads.value.get("image")}
        stop=${() => stopUpload("image")} />
      <${ProblemBox} place="image" />
      <p class="small">${image ? "Each change is stored as a child." : "A PNG or JPEG: a child is painted with it."}</p>
    </div>
  `;
}
