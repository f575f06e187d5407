/**
 * The find that is chosen: its picture beside the target's, under their own light or another, its figures, and what can be done with
 * it. Owns their words.
 *
 * @import { Found, Job, Target } from "../types.js"
 */
import { pin } from "../compare.js";
import { html } from "../html.js";
import { openInspector } from "../inspector.js";
import { besideFound } from "../pair.js";
import { breedFound, chosen, front, individuals, openLineageOf, showFound, target } from "../search_job.js";
import { findPicture, heldLight, isPaired, light, lookAt, targetPicture, view } from "../search_picture.js";
import { nameOfView } from "../search_views.js";
import { errorInWords, hasEnded } from "../search_words.js";
import { closeSearches } from "../searches.js";
import { Slider } from "./control.js";
import { Exports, listFormats } from "./exports.js";
import { Pair } from "./pair.js";
import { Trouble } from "./trouble.js";

/** @param {{name: string, value: unknown, title?: string}} props */
const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** @param {Found} of */
const nameOf = (of) => (of === front.value[0] ? "the best" : `a find of ${of.operations} operations`);

/** Puts the light back where its scene has it. */
function restLight() {
  light.value = null;
  heldLight.value = null;
}

/** Why the target is not beside it. @param {Target|null} to */
function alone(to) {
  if (!to) return "The target is not on the server any more.";
  return (to.views ?? []).length > 0 ? "The find alone: the picture was not taken under this light, so there is nothing to hold against it." : "";
}

/** The light goes around, to angles that nobody looked at. */
function Light() {
  const at = heldLight.value ?? light.value;
  const words = light.value === null ? "" : alone(target.value);
  /** @param {number} to */
  const rest = (to) => {
    light.value = to;
    heldLight.value = null;
  };
  return html`
    <div class="held-light">
      <${Slider} id="found-light" name="another light" value=${at ?? 0} min=${0} max=${355} step=${5} dim=${at === null} shown=${at === null ? "its own" : `${at}°`}
        title="How it looks under a light that stands elsewhere" turns=${(/** @type {number} */ to) => (heldLight.value = to)} rests=${rest} />
      <button type="button" data-testid="found-light-rest" disabled=${at === null} aria-label="Back to its own light" title="Back to its own light" onClick=${restLight}>↺</button>
    </div>
    ${words && html`<p class="small" role="status" data-testid="found-alone">${words}</p>`}
  `;
}

/** Under which light a picture is, where it is not its own. */
const underLight = () => (light.value === null ? "" : ` under a light at ${light.value}°`);

/** @param {import("../arriving.js").Arriving} picture @param {string} name @param {string} words @returns {import("./pair.js").Side} */
const side = (picture, name, words) => ({ name, words, url: picture.there.value?.url ?? null, coming: picture.isComing.value, lost: picture.isLost.value });

/** The find, with the target beside and over it where it can be drawn. @param {{of: Found|null, waits: string}} props */
function Picture({ of, waits }) {
  if (isPaired.value) {
    const views = target.value?.views ?? [];
    const named = views.length > 0 ? nameOfView(views, view.value) : "the target";
    const name = views.length > 1 ? `picture ${view.value + 1}` : views.length > 0 ? "picture" : "target";
    return html`
      <div data-testid="found-picture">
        <${Pair} id="found-pair" upper=${side(targetPicture, name, `${named}${underLight()}`)} lower=${side(findPicture, "find", `${of ? nameOf(of) : "nothing"}${underLight()}`)}
          state=${besideFound} waits=${of ? "It is drawn …" : waits} />
      </div>
    `;
  }
  const there = findPicture.there.value;
  const coming = findPicture.isComing.value;
  return html`
    <div class=${coming && there ? "best coming" : "best"} aria-busy=${coming} data-testid="found-picture">
      ${of && there
        ? html`<img src=${there.url} width="384" height="384" alt=${`${nameOf(of)}${underLight()}`} />`
        : html`<p class="small hollow">${!of ? waits : findPicture.isLost.value ? "Its picture cannot be drawn." : "Its picture is drawn …"}</p>`}
    </div>
  `;
}

/** The target's pictures, each with how far the find is from it. @param {{of: Found}} props */
function Views({ of }) {
  const to = target.value;
  const views = to?.views ?? [];
  if (views.length === 0) return null;
  return html`
    <table class="finds views" data-testid="found-views">
      <caption class="unseen">How the find looks in the target's pictures</caption>
      <thead><tr><th scope="col">picture</th><th scope="col" title="Root mean square of the differences of linear radiance">RMSE</th><th scope="col" title="How different they look when one flips to the other, 0 to 1">FLIP</th>
        <th scope="col" title="By what the picture is multiplied: its brightness was not known where this was solved for">gain</th></tr></thead>
      <tbody>
        ${views.map((one, at) => {
          const on = at === view.value;
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

/** @param {{of: Found}} props */
const Figures = ({ of }) => html`
  <dl>
    <${Fact} name="error, held out" value=${errorInWords(of.e_log)} title="E log: root mean square of the differences of log(1 + f cos), on samples that the search never saw" />
    <${Fact} name="error, fitted" value=${errorInWords(of.e_log_fitted)} title="The same on the samples it was fitted to" />
    <${Fact} name="E cube root" value=${errorInWords(of.e_cbrt)} title="The same kind of error of cube roots" />
    <${Fact} name="relative L2" value=${errorInWords(of.relative_l2)} />
    <${Fact} name="operations" value=${of.operations.toLocaleString("en")} title="Scalar operations a sample, under the energy limit" />
    <${Fact} name="numbers" value=${of.numbers.toLocaleString("en")} title="Numbers that were fitted" />
    <${Fact} name="divisor" value=${Number(of.divisor.toPrecision(4))} title="By what the energy limit divides; 1 where it has nothing to do" />
    <${Fact} name="found in" value=${`generation ${of.generation}`} />
  </dl>
`;

/** @param {{of: Found, within: Job}} props */
function Deeds({ of, within }) {
  const one = individuals.value.get(of.individual);
  const name = nameOf(of);
  const inspect = () => one && openInspector(one, `${name} of ${within.name}`);
  const toB = () => {
    if (!one) return;
    pin(one, name);
    closeSearches();
  };
  if (one) listFormats("found");
  return html`
    <div class="deeds-of">
      <button type="button" class="primary" data-testid="found-breed" title="Twenty children around it, in its lineage" onClick=${() => breedFound(of)}>Breed from it</button>
      <button type="button" data-testid="found-show" title="Where it was born" onClick=${() => showFound(of)}>Show in lineage</button>
      <button type="button" data-testid="found-inspect" disabled=${!one} onClick=${inspect}>Inspect</button>
      <button type="button" data-testid="found-pin" disabled=${!one} title="Beside what is bred, as B" onClick=${toB}>Pin as B</button>
    </div>
    ${one && html`<${Exports} of=${one} place="found" />`}
  `;
}

/** @param {Found|null} of @param {Job} within */
function titleOf(of, within) {
  if (of && front.value.length > 1 && of !== front.value[0]) return "Chosen from the front";
  if (hasEnded(within)) return of ? "The best" : "Nothing found";
  return "Best so far";
}

/** @param {{of: Job, waits: string}} props */
export function FoundView({ of: within, waits }) {
  const of = chosen.value;
  return html`
    <section class="found-one" aria-labelledby="found-title">
      <h3 id="found-title">${titleOf(of, within)}</h3>
      <${Picture} of=${of} waits=${waits} />
      ${of && html`<${Light} /><${Views} of=${of} /><${Figures} of=${of} /><${Deeds} of=${of} within=${within} />`}
      <${Trouble} place="found" />
      <button type="button" class="link" data-testid="job-lineage" title="All that was found on the way, in order" onClick=${() => openLineageOf(within)}>Open its lineage</button>
    </section>
  `;
}

