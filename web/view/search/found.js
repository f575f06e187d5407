/**
 * The chosen result: its picture beside the target's, under their own light or another, its
 * figures, and actions.
 *
 * @import { Found, Job, Target } from "../../model.js"
 */
import { pin } from "../../compare/ab.js";
import { openInspector } from "../../lineage/inspector.js";
import { breedFound, openLineageOf, showFound } from "../../search/job.js";
import { findPicture, lookAt, targetPicture } from "../../search/picture.js";
import { closeSearches } from "../../search/searches.js";
import { mapPixels, nextInWords } from "../../search/spread.js";
import { searchStore } from "../../search/store.js";
import { correctionInWords, isDoubtful, nameOfView } from "../../search/views.js";
import { errorInWords, hasEnded } from "../../search/words.js";
import { Pair } from "../compare/pair.js";
import { Fact, Slider } from "../control.js";
import { html } from "../html.js";
import { Exports } from "../lineage/exports.js";
import { ProblemBox } from "../problem.js";

/** @param {Found} of */
const nameOf = (of) => (of === searchStore.front.value[0] ? "the best" : `a result of ${of.operations} operations`);

/** Moves the light back to its place in the scene. */
function restLight() {
  searchStore.pictureLight.value = null;
  searchStore.draggedLight.value = null;
}

/** Reason why the target is not shown beside the result. @param {Target|null} to */
function whyNoTarget(to) {
  if (!to) return "The target was deleted.";
  return (to.views ?? []).length > 0 ? "The result alone: the target has no picture under this light to compare it with." : "";
}

/** Slider that moves the light to other angles. */
function Light() {
  const at = searchStore.draggedLight.value ?? searchStore.pictureLight.value;
  const words = searchStore.pictureLight.value === null ? "" : whyNoTarget(searchStore.target.value);
  /** @param {number} to */
  const rest = (to) => {
    searchStore.pictureLight.value = to;
    searchStore.draggedLight.value = null;
  };
  return html`
    <div class="held-light">
      <${Slider} id="found-light" name="another light" value=${at ?? 0} min=${0} max=${355} step=${5} dim=${at === null} shown=${at === null ? "its own" : `${at}°`}
        title="The result under a light from another angle" onInput=${(/** @type {number} */ to) => (searchStore.draggedLight.value = to)} onCommit=${rest} />
      <button type="button" data-testid="found-light-rest" disabled=${at === null} aria-label="Back to its own light" title="Back to its own light" onClick=${restLight}>↺</button>
    </div>
    ${words && html`<p class="small" role="status" data-testid="found-alone">${words}</p>`}
  `;
}

/** Angle of the light in words, if it is not its own. */
const underLight = () => (searchStore.pictureLight.value === null ? "" : ` under a light at ${searchStore.pictureLight.value}°`);

/**
 * @param {import("../../search/loading_picture.js").LoadingPicture} picture
 * @param {string} name
 * @param {string} words
 * @returns {import("../compare/pair.js").Side}
 */
const side = (picture, name, words) => ({ name, words, url: picture.current.value?.url ?? null, coming: picture.isLoading.value, lost: picture.isFailed.value });

/**
 * The result, with the target beside and over it if it can be drawn.
 * @param {{of: Found|null, placeholder: string}} props
 */
function Picture({ of, placeholder }) {
  if (searchStore.isPaired.value) {
    const views = searchStore.target.value?.views ?? [];
    const named = views.length > 0 ? nameOfView(views, searchStore.pictureView.value) : "the target";
    const name = views.length > 1 ? `picture ${searchStore.pictureView.value + 1}` : views.length > 0 ? "picture" : "target";
    return html`
      <div data-testid="found-picture">
        <${Pair} id="found-pair" upper=${side(targetPicture, name, `${named}${underLight()}`)} lower=${side(findPicture, "result", `${of ? nameOf(of) : "nothing"}${underLight()}`)}
          state=${searchStore.foundPair} placeholder=${of ? "Loading …" : placeholder} />
      </div>
    `;
  }
  const there = findPicture.current.value;
  const coming = findPicture.isLoading.value;
  return html`
    <div class=${coming && there ? "best coming" : "best"} aria-busy=${coming} data-testid="found-picture">
      ${of && there
        ? html`<img src=${there.url} width="384" height="384" alt=${`${nameOf(of)}${underLight()}`} />`
        : html`<p class="small hollow">${!of ? placeholder : findPicture.isFailed.value ? "This picture cannot be drawn." : "Loading …"}</p>`}
    </div>
  `;
}

/** The target's pictures, each with the error of the result. @param {{of: Found}} props */
function Views({ of }) {
  const to = searchStore.target.value;
  const views = to?.views ?? [];
  if (views.length === 0) return null;
  return html`
    <table class="finds views" data-testid="found-views">
      <caption class="unseen">Error of the result in each of the target's pictures</caption>
      <thead><tr><th scope="col">picture</th><th scope="col" title="Root mean square of the differences of linear radiance">RMSE</th><th scope="col" title="Visible difference when flipping between the two, 0 to 1">FLIP</th>
        <th scope="col" title="Factor on the picture's brightness; solved for where that is not known">gain</th></tr></thead>
      <tbody>
        ${views.map((one, at) => {
          const on = at === searchStore.pictureView.value;
          const found = of.views?.[at];
          return html`
            <tr key=${at} class=${on ? "on" : ""} onClick=${() => lookAt(at)}>
              <td><button type="button" aria-pressed=${on} data-testid=${`found-view-${at}`} onClick=${() => lookAt(at)}>${views.length > 1 ? at + 1 : "the picture"}${one.held_out ? " held out" : ""}</button></td>
              <td>${errorInWords(found?.rmse)}</td><td>${errorInWords(found?.flip)}</td><td>${one.gain_solved ? errorInWords(found?.gain) : "known"}</td>
            </tr>
          `;
        })}
      </tbody>
    </table>
  `;
}

/** Corrections of the scene of the picture in view. */
function Corrections() {
  const view = searchStore.target.value?.views?.[searchStore.pictureView.value];
  const found = view?.corrected?.corrections ?? [];
  if (found.length === 0) return null;
  const number = (/** @type {number} */ value) => Number(value.toPrecision(3));
  return html`
    <table class="finds" data-testid="found-corrections">
      <caption>The scene, corrected with the material</caption>
      <thead><tr><th scope="col">number</th><th scope="col" title="Turn, or factor of what was stated">found</th><th scope="col" title="Standard deviation after the fit">±</th><th scope="col" title="Standard deviation before the fit">stated ±</th></tr></thead>
      <tbody>
        ${found.map((one) => html`<tr key=${one.name}><td>${correctionInWords(one.name)}</td><td>${number(one.value)}</td><td>${number(one.deviation)}</td><td>${number(one.stated_deviation)}</td></tr>`)}
      </tbody>
    </table>
    ${found.some(isDoubtful) && html`<p class="small warning" data-testid="found-doubtful">A correction is above twice the stated deviation. Is the scene right: units, camera, which light?</p>`}
  `;
}

/** Map of the directions that are known, and the picture to take next. */
function Open() {
  const spread = searchStore.spread.value;
  if (!spread) return null;
  const { cells, e_log, next, pictures } = spread;
  const job = searchStore.job.value?.id;
  /** @param {HTMLCanvasElement|null} canvas */
  const draw = (canvas) => canvas?.getContext("2d")?.putImageData(new ImageData(mapPixels(spread), cells, cells), 0, 0);
  const scene = next && `data:application/json,${encodeURIComponent(JSON.stringify(next.scene, null, 2))}`;
  return html`
    <figure class="open" data-testid="found-open">
      <canvas width=${cells} height=${cells} ref=${draw} role="img" aria-label="Map of what is known, by the angles of the half vector" title="To the right: angle between half vector and normal; downwards: between half vector and light; 0 to 90 degrees. Green: the pictures show it. Red: materials that match them differ there." />
      <figcaption>
        Expected error over all directions: ${errorInWords(e_log)}. Green: directions that the pictures show. Red: directions in which materials that match them differ.
        ${
          pictures &&
          job &&
          html`<div class="extremes" data-testid="found-extremes">
            ${["darkest", "brightest"].map((name) => html`<span key=${name}><img src=${`/v1/jobs/${job}/${name}.png`} alt=${`The ${name} that the material could be under other lights`} />${name}</span>`)}
          </div>
          <p>The darkest and the brightest that each pixel could be under other lights, that of the most useful next picture first: 5 and 95 % of the materials that match.</p>`
        }
        ${next && html`<p data-testid="found-next">Next picture: ${nextInWords(next)}. Expected error with it: ${errorInWords(next.e_log)}. <a class="link" href=${scene} download="next.json">Its scene</a></p>`}
      </figcaption>
    </figure>
  `;
}

/** @param {{of: Found}} props */
const Figures = ({ of }) => html`
  <dl>
    <${Fact} name="error, held out" value=${errorInWords(of.e_log)} title="E log: root mean square of the differences of log(1 + f cos), on samples that are not fitted" />
    <${Fact} name="error, fitted" value=${errorInWords(of.e_log_fitted)} title="The same error on the samples that were fitted" />
    <${Fact} name="E cube root" value=${errorInWords(of.e_cbrt)} title="Root mean square of the differences of cube roots" />
    <${Fact} name="relative L2" value=${errorInWords(of.relative_l2)} />
    <${Fact} name="operations" value=${of.operations.toLocaleString("en")} title="Scalar operations per sample, including the energy limit" />
    <${Fact} name="free parameters" value=${of.numbers.toLocaleString("en")} title="Constants that were fitted" />
    <${Fact} name="energy scale" value=${Number(of.divisor.toPrecision(4))} title="The energy limit divides by this; 1 where it changes nothing" />
    <${Fact} name="found in" value=${`generation ${of.generation}`} />
  </dl>
`;

/** @param {{of: Found, within: Job}} props */
function Actions({ of, within }) {
  const one = searchStore.individuals.value.get(of.individual);
  const name = nameOf(of);
  const inspect = () => one && openInspector(one, `${name} of ${within.name}`);
  const toB = () => {
    if (!one) return;
    pin(one, name);
    closeSearches();
  };
  return html`
    <div class="result-actions">
      <button type="button" class="primary" data-testid="found-breed" title="Twenty children around it, in its lineage" onClick=${() => breedFound(of)}>Breed from it</button>
      <button type="button" data-testid="found-show" title="Opens the generation of this result" onClick=${() => showFound(of)}>Show in lineage</button>
      <button type="button" data-testid="found-inspect" disabled=${!one} onClick=${inspect}>Inspect</button>
      <button type="button" data-testid="found-pin" disabled=${!one} title="Pins it as B, beside the centre" onClick=${toB}>Pin as B</button>
    </div>
    ${one && html`<${Exports} of=${one} name=${within.name} place="found" isElsewhere />`}
  `;
}

/** @param {Found|null} of @param {Job} within */
function titleOf(of, within) {
  if (of && searchStore.front.value.length > 1 && of !== searchStore.front.value[0]) return "Chosen from the front";
  if (hasEnded(within)) return of ? "The best" : "No result";
  return "Best so far";
}

/** @param {{of: Job, placeholder: string}} props */
export function FoundView({ of: within, placeholder }) {
  const of = searchStore.chosenResult.value;
  return html`
    <section class="found-one" aria-labelledby="found-title">
      <h3 id="found-title">${titleOf(of, within)}</h3>
      <${Picture} of=${of} placeholder=${placeholder} />
      ${of && html`<${Light} /><${Views} of=${of} /><${Corrections} />${of === searchStore.front.value[0] && html`<${Open} />`}<${Figures} of=${of} /><${Actions} of=${of} within=${within} />`}
      <${ProblemBox} place="found" />
      <button type="button" class="link" data-testid="job-lineage" title="All results of this search, in order" onClick=${() => openLineageOf(within)}>Open the lineage of the results</button>
    </section>
  `;
}

