/**
 * The right pane: facts and note of the centre, exports, comparison, favourites.
 *
 * @import { Individual, Outline } from "../../model.js"
 */
import { effect } from "../../vendor/signals-core.js";
import { pin } from "../../compare/ab.js";
import { openFavourites } from "../../favourites/list.js";
import { nameOf, setNote } from "../../lineage/breed.js";
import { makeToonShape, presentEdit } from "../../lineage/edit.js";
import { isBred, visit } from "../../lineage/generations.js";
import { birthOf } from "../../lineage/individuals.js";
import { inspect } from "../../lineage/inspections.js";
import { openInspector } from "../../lineage/inspector.js";
import { isByBrdf, isLayered } from "../../lineage/layers.js";
import { toggleOwnCover } from "../../lineage/listed.js";
import { regionsInWords } from "../../lineage/painting.js";
import { steerInWords } from "../../lineage/steer.js";
import { lineageStore } from "../../lineage/store.js";
import { albedoInWords, madeBy, reflectsInWords } from "../../page/format.js";
import { guarded } from "../../page/problem.js";
import { pageStore } from "../../page/store.js";
import { centreAsStart, searchFrom } from "../../search/draft.js";
import { Compare, Pin } from "../compare/ab.js";
import { Fact } from "../control.js";
import { html } from "../html.js";
import { isPlain } from "../keys.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";
import { TargetSection } from "../search/active_target.js";
import { EditButtons, Editor } from "./editor.js";
import { Effects } from "./effects.js";
import { Exports } from "./exports.js";
import { Images } from "./images.js";
import { Layers } from "./layers.js";

/**
 * Delay before the centre is inspected, so that a user who breeds on at once causes no inspections.
 */
const INSPECT_DELAY_MS = 400;

/** Inspects the centre, for its largest albedo, once its pictures are loaded. */
function inspectCentre() {
  const of = lineageStore.centre.value;
  const isRead = lineageStore.programsOnly.value || lineageStore.centreGenome.value !== null;
  const isDue = pageStore.detailsOpen.value && lineageStore.readyId.value !== null && isRead;
  // Painted materials have no albedo.
  if (!of || !isDue || lineageStore.painted.value || lineageStore.inspections.peek().has(of.hash)) return;
  const look = async () => {
    await inspect(of);
  };
  const timer = setTimeout(() => void guarded("centre", look, true), INSPECT_DELAY_MS);
  return () => clearTimeout(timer);
}

/** Opens the form of a search that starts from the centre. */
function fromCentre() {
  const start = centreAsStart();
  if (start) searchFrom(start.of, start.name);
}

/** Text of a note that is not saved yet. @type {{of: Individual, text: string}|null} */
let note = null;

/** Pause in writing after which a note is saved. */
const SAVE_DELAY_MS = 1500;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let saveTimer;

/** @param {Individual} of @param {string} text */
function writeNote(of, text) {
  note = { of, text };
  clearTimeout(saveTimer);
  saveTimer = setTimeout(saveNote, SAVE_DELAY_MS);
}

function saveNote() {
  const left = note;
  note = null;
  if (left) void setNote(left.of, left.text);
}

export function watchDetails() {
  effect(inspectCentre);
  effect(() => {
    // A note of the centre before is saved, even in the middle of a word.
    const id = lineageStore.centre.value?.id;
    if (note && note.of.id !== id) saveNote();
  });
  addEventListener("pagehide", saveNote);
}

function Centre() {
  const of = lineageStore.centre.value;
  const within = lineageStore.generation.value;
  if (!of || !within) return null;
  const energy = lineageStore.inspections.value.get(of.hash)?.energy;
  const painted = lineageStore.painted.value;
  const genome = lineageStore.centreGenome.value;
  const effects = genome?.effects ?? [];
  const layers = isLayered(of) ? lineageStore.genomes.value.get(of.hash)?.layers : undefined;
  return html`
    <section aria-labelledby="centre-title">
      <h2 id="centre-title">Centre</h2>
      <dl>
        ${(of.live_instructions > 0 || !(isLayered(of) || painted)) && html`<${Fact} name="live instructions" value=${of.live_instructions} />`}
        ${!painted && html`<${Fact} name="largest albedo" value=${energy ? reflectsInWords(energy) : "…"} title=${energy && albedoInWords(energy)} />`}
        <${Fact} name="made by" value=${madeBy(of)} />
        <${Fact} name="parents" value=${of.parents.length || "none"} />
        <${Fact} name="genome" value=${html`<a href=${`/v1/genomes/${of.hash}`} title=${of.hash}>${of.hash.slice(0, 12)}</a>`} />
        ${isBred(within) && html`<${Fact} name="mutation" value=${within.mutation.toFixed(2)} title="Of the brood" />`}
        ${steerInWords(within.steer) && html`<${Fact} name="steered" value=${steerInWords(within.steer)} title="Of the brood, compared with its parent" />`}
        ${within.painting && html`<${Fact} name="painted in" value=${regionsInWords(within.painting)} title="Of the brood: colours of a painting" />`}
        <${Fact} name="brood's seed" value=${within.seed} />
      </dl>
      ${layers && (presentEdit() ? html`<${Editor} />` : html`<${Layers} of=${layers} lockable=${true} />`)}
      ${layers && html`<${EditButtons} />`}
      ${painted && effects.length > 0 && html`<${Effects} of=${effects} /><${Images} of=${effects} />`}
      ${painted && html`<p class="small" data-testid="painted-note">A painted material is not a BRDF: it has no reflectance to inspect or to search from.${isByBrdf(genome) ? " This one paints what its BRDF reflects; the server draws it." : ""}</p>`}
      ${(genome || lineageStore.programsOnly.value) && !painted && html`<button type="button" class="start" data-testid="toon-shape" title="A child that paints what this material reflects with a palette; breeding changes both" onClick=${() => void makeToonShape()}>Make a toon shape</button>`}
      <button type="button" class="start" data-testid="inspect" disabled=${painted} title="Its code, its reflectance, and its locks (I on a frame)" onClick=${() => openInspector(of, nameOf("centre"))}>Inspect the genome</button>
      ${birthOf(of.id) && html`<button type="button" class="start" data-testid="cover" aria-pressed=${lineageStore.lineage.value?.cover_individual === of.id} title="Show this picture in the list of lineages" onClick=${() => toggleOwnCover(of.id)}>Cover of this lineage</button>`}
      <button type="button" class="start" data-testid="search-from" disabled=${painted} title="A search that starts from the centre, for a measured target" onClick=${fromCentre}>Search from this material</button>
      <${Exports} of=${of} name=${lineageStore.lineage.value?.name ?? ""} within=${within} place="centre" />
      <label class="note">Note
        <textarea rows="2" maxlength="10000" data-testid="note" defaultValue=${of.note} key=${of.id}
          onInput=${(/** @type {Event} */ event) => writeNote(of, /** @type {HTMLTextAreaElement} */ (event.target).value)} onChange=${saveNote}></textarea>
      </label>
      <${ProblemBox} place="centre" />
    </section>
  `;
}

/** @param {Outline} born @param {Individual} of */
async function showFavourite(born, of) {
  await visit(born.id);
  pageStore.focusedCell.value = of.slot < 20 ? of.slot : "centre";
}

/** @param {Individual} of @param {Outline} born */
const pinFavourite = (of, born) => pin(of, `Favourite ${of.slot + 1} of generation ${born.index}`);

/** @param {Individual} of @param {Outline} born */
const inspectFavourite = (of, born) => openInspector(of, `Favourite ${of.slot + 1} of generation ${born.index}`);

/** @param {Individual} of @param {Outline} born */
const keyOn = (of, born) => (/** @type {KeyboardEvent} */ event) => {
  if (isPlain(event, "b")) pinFavourite(of, born);
  else if (isPlain(event, "i")) inspectFavourite(of, born);
};

/** Number of favourites that are shown: the newest. */
const SHOWN = 60;

function Favourites() {
  const all = lineageStore.ordered.value.flatMap((born) => born.individuals.filter((one) => one.favourite).map((of) => ({ born, of })));
  const found = all.slice(-SHOWN);
  return html`
    <section aria-labelledby="favourites">
      <div class="row"><h2 id="favourites" class="grow">Favourites</h2><button type="button" data-testid="favourites-of-all" title="Favourites of all lineages, large (V)" onClick=${() => openFavourites()}>All …</button></div>
      ${found.length === 0
        ? html`<p class="small">None yet. Mark one with the star on a frame, or F.</p>`
        : html`<ul class="gallery">${found.map(({ born, of }) => html`
            <li key=${of.id} onKeyDown=${keyOn(of, born)}><button type="button" aria-label=${`Favourite ${of.slot + 1} of generation ${born.index}`} title=${of.note || `generation ${born.index}`} onClick=${() => showFavourite(born, of)}>
              <${ServerPicture} url=${of.thumbnail} lazy />
            </button><button type="button" class="about" data-testid="favourite-inspect" tabindex="-1" aria-label=${`Inspect and export favourite ${of.slot + 1} of generation ${born.index}`} title="Inspect and export (I)" onClick=${() => inspectFavourite(of, born)}>i</button><${Pin} name=${`favourite ${of.slot + 1} of generation ${born.index}`} onClick=${() => pinFavourite(of, born)} /></li>`)}</ul>`}
      ${all.length > SHOWN && html`<p class="small">The newest ${SHOWN} of ${all.length}.</p>`}
    </section>
  `;
}

export function Details() {
  return html`
    <aside class="pane right" aria-label="Details">
      <button type="button" class="close" aria-label="Close the details" onClick=${() => (pageStore.detailsOpen.value = false)}>×</button>
      <${Centre} /><${TargetSection} /><${Compare} /><${Favourites} />
    </aside>
  `;
}
