/**
 * A/B comparison in the right pane: both pictures, facts, and how to choose B.
 *
 * @import { Individual } from "../../model.js"
 */
import { problemOf } from "../../api/request.js";
import { getIndividual, pictureUrl } from "../../api/routes.js";
import { flip, pin, pinPasted, unpin } from "../../compare/ab.js";
import { openComparison } from "../../compare/comparison.js";
import { compareStore } from "../../compare/store.js";
import { isLayered, modelsInWords, modelsOf } from "../../lineage/layers.js";
import { lineageStore } from "../../lineage/store.js";
import { madeBy } from "../../page/format.js";
import { showProblem } from "../../page/problem.js";
import { Switch } from "../control.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";

const SIDE_PX = 256;

/** Id of the last B that was checked. */
let checkedB = "";

/** Shows why B has no picture, if the server no longer has B. @param {Individual} b */
async function checkB(b) {
  if (checkedB === b.id) return;
  checkedB = b.id;
  try {
    await getIndividual(b.id);
  } catch (error) {
    if (problemOf(error).status !== 404 || compareStore.pinned.value?.id !== b.id) return;
    showProblem("compare", { problem: { title: "B cannot be drawn", status: 404, detail: "This server does not have B any more; Unpin removes it." } });
  }
}

/** @param {{letter: "A"|"B", of: Individual, seen: boolean}} props */
function Side({ letter, of, seen }) {
  const sceneId = lineageStore.lineage.value?.scene;
  return html`
    <figure class=${seen ? "side on" : "side"}>
      ${sceneId && html`<${ServerPicture} url=${pictureUrl(of.id, sceneId, SIDE_PX)} side=${SIDE_PX} alt=${letter === "A" ? "A, the centre" : "B, the pinned individual"} onFailed=${letter === "B" ? () => checkB(of) : undefined} />`}
      <figcaption>${letter}</figcaption>
    </figure>
  `;
}

/** @param {{name: string, a: unknown, b: unknown}} props */
const Row = ({ name, a, b }) => html`<tr><th scope="row">${name}</th><td>${a}</td><td>${b}</td></tr>`;

/** @param {Individual} of */
const genome = (of) => html`<a href=${`/v1/genomes/${of.hash}`} title=${of.hash}>${of.hash.slice(0, 8)}</a>`;

/** @param {{a: Individual, b: Individual}} props */
function Facts({ a, b }) {
  const both = [a, b];
  const models = (/** @type {Individual} */ of) => modelsInWords(modelsOf(of)) || "none";
  return html`
    <table class="both">
      <thead><tr><th scope="col"><span class="unseen">Fact</span></th><th scope="col">A</th><th scope="col">B</th></tr></thead>
      <tbody>
        ${both.some((one) => one.live_instructions > 0) && html`<${Row} name="instructions" a=${a.live_instructions || "none"} b=${b.live_instructions || "none"} />`}
        ${both.some(isLayered) && html`<${Row} name="models" a=${models(a)} b=${models(b)} />`}
        <${Row} name="made by" a=${madeBy(a)} b=${madeBy(b)} />
        <${Row} name="genome" a=${genome(a)} b=${genome(b)} />
      </tbody>
    </table>
  `;
}

/** @param {SubmitEvent} event */
async function submit(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  if (await pinPasted(String(new FormData(form).get("other") ?? ""))) form.reset();
}

/** Form that names B by its id or a link. */
const Paste = () => html`
  <form class="row paste" onSubmit=${submit}>
    <input type="text" name="other" class="grow" aria-label="Id or share link of another individual" placeholder="an id or a share link" maxlength="500" autocomplete="off" spellcheck=${false} data-testid="compare-other" />
    <button type="submit" data-testid="compare-pin">Compare</button>
  </form>
`;

/** @param {{of: Individual}} props */
function Choice({ of }) {
  if (!compareStore.choosingOther.value) return html`<button type="button" class="start" data-testid="compare" onClick=${() => (compareStore.choosingOther.value = true)}>Compare the centre with …</button>`;
  return html`
    <p class="small">Pin B by the button on a frame, a favourite or a generation, or by the key B. Or name any other:</p>
    <${Paste} />
    <div class="row">
      <button type="button" onClick=${() => pin(of, "The centre")}>Pin the centre as B</button>
      <button type="button" onClick=${() => (compareStore.choosingOther.value = false)}>Cancel</button>
    </div>
  `;
}

/** @param {{a: Individual, b: Individual}} props */
const Both = ({ a, b }) => html`
  <div class="sides" data-testid="compare-sides"><${Side} letter="A" of=${a} seen=${!compareStore.flipped.value} /><${Side} letter="B" of=${b} seen=${compareStore.flipped.value} /></div>
  ${a.id === b.id && html`<p class="small">B is the centre itself. Breed on to compare it with its children.</p>`}
  <div class="row">
    <${Switch} id="flip" name="flip" on=${compareStore.flipped.value} title="Shows B in place of the centre (X; hold X to glance)" onInput=${flip} />
    <button type="button" data-testid="unpin" title="Unpin B (Esc)" onClick=${unpin}>Unpin</button>
  </div>
  <${Facts} a=${a} b=${b} />
  <${Paste} />
`;

export function Compare() {
  const a = lineageStore.centre.value;
  const b = compareStore.pinned.value;
  if (!a) return null;
  return html`
    <section aria-labelledby="compare-title" data-testid="compare-section">
      <h2 id="compare-title">A / B</h2>
      ${b ? html`<${Both} a=${a} b=${b} />` : html`<${Choice} of=${a} />`}
      <button type="button" class="start" data-testid="compare-several" title="Pictures, differences, curves and figures of two to six materials (C)" onClick=${openComparison}>Side by side, measured …</button>
      <${ProblemBox} place="compare" />
    </section>
  `;
}

/**
 * The button that pins the individual it stands on. CSS draws its letter, because screen readers
 * take the name of a frame from its text.
 * @param {{name: string, on?: boolean, onClick: () => void}} props
 */
export const Pin = ({ name, on = false, onClick }) => html`
  <button type="button" class=${on ? "pin on" : "pin"} data-testid="pin" tabindex="-1" aria-pressed=${on} aria-label=${`Compare with the centre: ${name}`} title="Compare with the centre, as B (B)" onClick=${onClick}></button>
`;
