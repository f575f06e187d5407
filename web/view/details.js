/**
 * The right pane: facts and note of the individual in the centre, and the lineage's favourites. Owns their words.
 *
 * @import { Generation, Individual } from "../types.js"
 */
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
import { centreAsStart, searchFrom } from "../search_draft.js";
import { effect } from "../vendor/signals-core.js";
import { detailsOpen, focused, generation, inOrder, large } from "../state.js";
import { Compare, Pin } from "./compare.js";
import { Exports, listFormats } from "./exports.js";
import { Layers } from "./layers.js";
import { SoughtSection } from "./sought.js";
import { Trouble } from "./trouble.js";
import { albedoInWords, madeBy, reflectsInWords } from "./words.js";

effect(() => {
  if (detailsOpen.value && generation.value) listFormats("centre");
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

/** @param {{name: string, value: unknown, title?: string}} props */
const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** What was bred by eye goes on by itself. */
function fromCentre() {
  const start = centreAsStart();
  if (start) searchFrom(start.of, start.name);
}

/** What is being written and not yet kept. @type {{of: Individual, text: string}|null} */
let note = null;

/** Somebody who stops writing for so long has written something. */
const PAUSE_MS = 1500;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let pausing;

/** @param {Individual} of @param {string} text */
function writeNote(of, text) {
  note = { of, text };
  clearTimeout(pausing);
  pausing = setTimeout(saveNote, PAUSE_MS);
}

function saveNote() {
  const left = note;
  note = null;
  if (left) void setNote(left.of, left.text);
}

globalThis.addEventListener?.("pagehide", saveNote);

// Who goes on to another centre in the middle of a word keeps the word.
effect(() => {
  if (note && note.of.id !== large.value?.id) saveNote();
});

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
      <button type="button" class="start" data-testid="search-from" title="A search that starts from the centre, to come closer to something measured" onClick=${fromCentre}>Search from here …</button>
      <${Exports} of=${of} within=${within} place="centre" />
      <label class="note">Note
        <textarea rows="2" maxlength="10000" data-testid="note" defaultValue=${of.note} key=${of.id}
          onInput=${(/** @type {Event} */ event) => writeNote(of, /** @type {HTMLTextAreaElement} */ (event.target).value)} onChange=${saveNote}></textarea>
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
      <${Centre} /><${SoughtSection} /><${Compare} /><${Favourites} />
    </aside>
  `;
}
