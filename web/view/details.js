/**
 * The right pane: facts and note of the individual in the centre, and the lineage's favourites. Owns their words.
 *
 * @import { Generation, Individual } from "../types.js"
 */
import { setNote } from "../breed.js";
import { html } from "../html.js";
import { visit } from "../lineage.js";
import { detailsOpen, focused, generation, inOrder, large } from "../state.js";
import { Trouble } from "./trouble.js";

/** @type {Record<string, string>} */
const OPERATORS = { random: "drawn at random", mutate: "mutation", recombine: "recombination" };

/** @param {{name: string, value: unknown}} props */
const Fact = ({ name, value }) => html`<div><dt>${name}</dt><dd>${value}</dd></div>`;

function Centre() {
  const of = large.value;
  const within = generation.value;
  if (!of || !within) return null;
  return html`
    <section aria-labelledby="centre-title">
      <h2 id="centre-title">Centre</h2>
      <dl>
        <${Fact} name="live instructions" value=${of.live_instructions} />
        <${Fact} name="made by" value=${OPERATORS[of.operator] ?? of.operator} />
        <${Fact} name="parents" value=${of.parents.length || "none"} />
        <${Fact} name="genome" value=${html`<a href=${`/v1/genomes/${of.hash}`} title=${of.hash}>${of.hash.slice(0, 12)}</a>`} />
        <${Fact} name="brood's seed" value=${within.seed} />
      </dl>
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

function Favourites() {
  const found = inOrder.value.flatMap((born) => born.individuals.filter((one) => one.favourite).map((of) => ({ born, of })));
  return html`
    <section aria-labelledby="favourites">
      <h2 id="favourites">Favourites</h2>
      ${found.length === 0
        ? html`<p class="small">None yet: the star on a frame, or F, marks one.</p>`
        : html`<ul class="gallery">${found.map(({ born, of }) => html`
            <li key=${of.id}><button type="button" aria-label=${`Favourite ${of.slot + 1} of generation ${born.index}`} title=${of.note || `generation ${born.index}`} onClick=${() => showFavourite(born, of)}>
              <img src=${of.thumbnail} alt="" loading="lazy" />
            </button></li>`)}</ul>`}
    </section>
  `;
}

export function Details() {
  return html`
    <aside class="pane right" aria-label="Details">
      <button type="button" class="close" aria-label="Close the details" onClick=${() => (detailsOpen.value = false)}>×</button>
      <${Centre} /><${Favourites} />
    </aside>
  `;
}
