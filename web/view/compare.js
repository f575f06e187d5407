/**
 * A and B in the right pane: both pictures, what is known of both, and how to choose B. Owns their words; what is pinned and
 * flipped is compare.js's.
 *
 * @import { Individual } from "../types.js"
 */
import { pictureUrl } from "../api.js";
import { choosing, flip, flipped, pin, pinPasted, pinned, unpin } from "../compare.js";
import { openComparison } from "../comparison.js";
import { html } from "../html.js";
import { isLayered, modelsInWords, modelsOf } from "../layers.js";
import { large, lineage, tell } from "../state.js";
import { Switch } from "./control.js";
import { madeBy } from "./words.js";
import { Trouble } from "./trouble.js";

const SIDE_PX = 256;

const lost = () => tell("compare", { problem: { title: "B cannot be drawn", status: 404, detail: "This server does not have it any more; Unpin lets it go." } });

/** @param {{letter: "A"|"B", of: Individual, seen: boolean}} props */
function Side({ letter, of, seen }) {
  const sceneId = lineage.value?.scene;
  return html`
    <figure class=${seen ? "side on" : "side"}>
      ${sceneId && html`<img src=${pictureUrl(of.id, sceneId, SIDE_PX)} width=${SIDE_PX} height=${SIDE_PX} alt=${letter === "A" ? "A, the centre" : "B, what is pinned"} onError=${letter === "B" ? lost : undefined} />`}
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

/** Where B is named by its id or a link. */
const Paste = () => html`
  <form class="row paste" onSubmit=${submit}>
    <input type="text" name="other" class="grow" aria-label="Id or share link of another individual" placeholder="an id or a share link" maxlength="500" autocomplete="off" spellcheck=${false} data-testid="compare-other" />
    <button type="submit" data-testid="compare-pin">Compare</button>
  </form>
`;

/** @param {{of: Individual}} props */
function Choice({ of }) {
  if (!choosing.value) return html`<button type="button" class="start" data-testid="compare" onClick=${() => (choosing.value = true)}>Compare the centre with …</button>`;
  return html`
    <p class="small">The B on a frame, a favourite or the history pins it, as the key B does. Or name any other:</p>
    <${Paste} />
    <div class="row">
      <button type="button" onClick=${() => pin(of, "The centre")}>Pin the centre as B</button>
      <button type="button" onClick=${() => (choosing.value = false)}>Cancel</button>
    </div>
  `;
}

/** @param {{a: Individual, b: Individual}} props */
const Both = ({ a, b }) => html`
  <div class="sides" data-testid="compare-sides"><${Side} letter="A" of=${a} seen=${!flipped.value} /><${Side} letter="B" of=${b} seen=${flipped.value} /></div>
  ${a.id === b.id && html`<p class="small">B is the centre itself: breed on, and compare what comes with it.</p>`}
  <div class="row">
    <${Switch} id="flip" name="flip" on=${flipped.value} title="Shows B in the place of the centre (X; hold X to glance at it)" turns=${flip} />
    <button type="button" data-testid="unpin" title="Unpin B (Esc)" onClick=${unpin}>Unpin</button>
  </div>
  <${Facts} a=${a} b=${b} />
  <${Paste} />
`;

export function Compare() {
  const a = large.value;
  const b = pinned.value;
  if (!a) return null;
  return html`
    <section aria-labelledby="compare-title" data-testid="compare-section">
      <h2 id="compare-title">A / B</h2>
      ${b ? html`<${Both} a=${a} b=${b} />` : html`<${Choice} of=${a} />`}
      <button type="button" class="start" data-testid="compare-several" title="Pictures, differences, curves and numbers of two to six materials (C)" onClick=${openComparison}>Side by side, measured …</button>
      <${Trouble} place="compare" />
    </section>
  `;
}

/** The button that pins what it stands on; its letter is drawn by the style, for a frame's name is in words. @param {{name: string, on?: boolean, does: () => void}} props */
export const Pin = ({ name, on = false, does }) => html`
  <button type="button" class=${on ? "pin on" : "pin"} data-testid="pin" tabindex="-1" aria-pressed=${on} aria-label=${`Compare with the centre: ${name}`} title="Compare with the centre, as B (B)" onClick=${does}></button>
`;
