/**
 * The right pane: facts and note of the individual in the centre, and the lineage's favourites. Owns their words.
 *
 * @import { Generation, Individual } from "../types.js"
 */
import * as api from "../api.js";
import { nameOf, setNote } from "../breed.js";
import { pin } from "../compare.js";
import { genomes } from "../genomes.js";
import { html } from "../html.js";
import { inspect, inspections } from "../inspections.js";
import { openInspector } from "../inspector.js";
import { isPlain } from "../keys.js";
import { isLayered } from "../layers.js";
import { guarded, visit } from "../lineage.js";
import { ready } from "../pictures.js";
import { effect, signal } from "../vendor/signals-core.js";
import { detailsOpen, focused, generation, inOrder, large } from "../state.js";
import { Compare, Pin } from "./compare.js";
import { Switch } from "./control.js";
import { Layers } from "./layers.js";
import { Trouble } from "./trouble.js";
import { albedoInWords, madeBy, reflectsInWords } from "./words.js";

/** @type {import("../vendor/signals-core.js").Signal<import("../types.js").ExportFormat[]>} */
const formats = signal([]);
effect(() => {
  if (!detailsOpen.value || !generation.value || formats.peek().length > 0) return;
  void guarded("centre", async () => {
    formats.value = await api.listExports();
  });
});

/** Somebody who breeds on at once does not wait for what is known of the centre. */
const REST_MS = 400;

// How much the centre reflects: looked for once its pictures are there and nobody has gone on.
effect(() => {
  const of = large.value;
  if (!detailsOpen.value || !of || ready.value === null || inspections.peek().has(of.hash)) return;
  const look = async () => {
    await inspect(of);
  };
  const timer = setTimeout(() => void guarded("centre", look), REST_MS);
  return () => clearTimeout(timer);
});

/** Has the browser save the genome's text. @param {Individual} of */
const saveText = (of) => guarded("centre", async () => {
  const text = await api.getGenomeText(of.hash);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = `${of.hash.slice(0, 12)}.brood`;
  link.click();
  URL.revokeObjectURL(link.href);
});

/** @param {{name: string, value: unknown, title?: string}} props */
const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** Whether functions are exported under the energy limit: other renderers count on it. */
const limitedExports = signal(true);

/** Models have no source code, and nobody is to find that out by a download that fails. @param {{of: Individual}} props */
function SourceCode({ of }) {
  if (isLayered(of)) {
    const names = formats.value.map(({ label }) => label.replace(/ functions.*$/, ""));
    return html`<li class="small" data-testid="no-source">Not as ${names.join(", ")}: models are not written as source code.</li>`;
  }
  return html`
    ${formats.value.map((format) => html`
      <li key=${format.name}><a download href=${`/v1/individuals/${of.id}/exports/${format.name}?energy_limit=${limitedExports.value}`} data-testid=${`export-${format.name}`}>${format.label}</a></li>
    `)}
    <li><${Switch} id="export-limited" name="functions reflect no more than they receive" on=${limitedExports.value} title="The energy limit: functions are divided by their largest albedo where that is above 1. Off: as bright as on the screen." turns=${(/** @type {boolean} */ on) => (limitedExports.value = on)} /></li>
  `;
}

/** What it and its brood can be taken away as. @param {{of: Individual, within: Generation}} props */
function Exports({ of, within }) {
  return html`
    <details class="exports" data-testid="exports">
      <summary>Export</summary>
      <ul>
        <li><button type="button" class="link" data-testid="export-brood" onClick=${() => saveText(of)}>.brood, the genome as text</button></li>
        <${SourceCode} of=${of} />
        <li><a download=${`${of.id}.apng`} href=${`/v1/individuals/${of.id}/render.apng?size=256&frames=24&seconds=4`} data-testid="export-apng">APNG, the light going around</a></li>
        <li><a download=${`${of.id}-strip.png`} href=${`/v1/individuals/${of.id}/strip.png?size=128&frames=24`} data-testid="export-strip">PNG strip of 24 pictures</a></li>
        <li><a download=${`${of.id}.png`} href=${`/v1/individuals/${of.id}/render.png?size=1024`}>PNG of 1024 x 1024</a></li>
        <li><a download=${`${of.id}.exr`} href=${`/v1/individuals/${of.id}/render.exr?size=1024`}>EXR of 1024 x 1024, linear</a></li>
        <li><a download=${`${within.id}.png`} href=${`/v1/generations/${within.id}/sheet.png`} data-testid="export-sheet">PNG of the brood</a></li>
        <li><a download=${`${within.id}.apng`} href=${`/v1/generations/${within.id}/sheet.apng?size=96&frames=24`} data-testid="export-sheet-apng">APNG of the brood</a></li>
      </ul>
    </details>
  `;
}

function Centre() {
  const of = large.value;
  const within = generation.value;
  if (!of || !within) return null;
  const energy = inspections.value.get(of.hash)?.energy;
  const layers = isLayered(of) ? genomes.value.get(of.hash)?.layers : undefined;
  return html`
    <section aria-labelledby="centre-title">
      <h2 id="centre-title">Centre</h2>
      <dl>
        ${(of.live_instructions > 0 || !isLayered(of)) && html`<${Fact} name="live instructions" value=${of.live_instructions} />`}
        <${Fact} name="reflects at most" value=${energy ? reflectsInWords(energy) : "…"} title=${energy && albedoInWords(energy)} />
        <${Fact} name="made by" value=${madeBy(of)} />
        <${Fact} name="parents" value=${of.parents.length || "none"} />
        <${Fact} name="genome" value=${html`<a href=${`/v1/genomes/${of.hash}`} title=${of.hash}>${of.hash.slice(0, 12)}</a>`} />
        <${Fact} name="brood's seed" value=${within.seed} />
      </dl>
      ${layers && html`<${Layers} of=${layers} lockable=${true} />`}
      <button type="button" class="start" data-testid="inspect" title="Its code, its reflectance, and its locks (I on a frame)" onClick=${() => openInspector(of, nameOf("centre"))}>Inspect the genome</button>
      <${Exports} of=${of} within=${within} />
      <label class="note">Note
        <textarea rows="2" maxlength="10000" data-testid="note" value=${of.note} key=${of.id}
          onChange=${(/** @type {Event} */ event) => setNote(/** @type {HTMLTextAreaElement} */ (event.target).value)}></textarea>
      </label>
      <${Trouble} place="centre" />
    </section>
  `;
}

/** @param {Generation} born @param {Individual} of */
async function showFavourite(born, of) {
  await visit(born.id);
  focused.value = of.slot < 20 ? of.slot : "centre";
}

/** @param {Individual} of @param {Generation} born */
const pinFavourite = (of, born) => pin(of, `Favourite ${of.slot + 1} of generation ${born.index}`);

/** @param {Individual} of @param {Generation} born */
const keyB = (of, born) => (/** @type {KeyboardEvent} */ event) => {
  if (isPlain(event, "b")) pinFavourite(of, born);
};

function Favourites() {
  const found = inOrder.value.flatMap((born) => born.individuals.filter((one) => one.favourite).map((of) => ({ born, of })));
  return html`
    <section aria-labelledby="favourites">
      <h2 id="favourites">Favourites</h2>
      ${found.length === 0
        ? html`<p class="small">None yet: the star on a frame, or F, marks one.</p>`
        : html`<ul class="gallery">${found.map(({ born, of }) => html`
            <li key=${of.id} onKeyDown=${keyB(of, born)}><button type="button" aria-label=${`Favourite ${of.slot + 1} of generation ${born.index}`} title=${of.note || `generation ${born.index}`} onClick=${() => showFavourite(born, of)}>
              <img src=${of.thumbnail} alt="" loading="lazy" />
            </button><${Pin} name=${`favourite ${of.slot + 1} of generation ${born.index}`} does=${() => pinFavourite(of, born)} /></li>`)}</ul>`}
    </section>
  `;
}

export function Details() {
  return html`
    <aside class="pane right" aria-label="Details">
      <button type="button" class="close" aria-label="Close the details" onClick=${() => (detailsOpen.value = false)}>×</button>
      <${Centre} /><${Compare} /><${Favourites} />
    </aside>
  `;
}
