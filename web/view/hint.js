/**
 * The lines under the frames: the hint, the mate if no frame shows it, its buttons on touch
 * screens, and the lineages of others on a first visit.
 *
 * @import { Individual } from "../model.js"
 */
import { cancelMate, setFavourite } from "../lineage/breed.js";
import { shownIndividual } from "../lineage/individuals.js";
import { lineageStore } from "../lineage/store.js";
import { pageStore } from "../page/store.js";
import { html } from "./html.js";
import { ServerPicture } from "./picture.js";

/** The mate if no frame shows it. @param {{of: Individual}} props */
const Elsewhere = ({ of }) => html`
  <div class="mating elsewhere" data-testid="mate-elsewhere">
    <span class="chip-picture"><${ServerPicture} url=${of.thumbnail} alt="The mate" /></span>
    <span>is the mate: choose the other parent</span>
    <button type="button" title="Cancel the mate (Esc)" onClick=${cancelMate}>Cancel</button>
  </div>
`;

/** On a first visit: the open lineage is new, and others can be opened. */
export function Others() {
  const count = pageStore.othersFound.value;
  if (count === 0) return null;
  return html`
    <div class="others" data-testid="others">
      <span>This is a new lineage of your own. The server has ${count === 1 ? "one other" : `${count} others`}.</span>
      <button type="button" onClick=${() => (pageStore.lineagesOpen.value = true)}>Show ${count === 1 ? "it" : "them"}</button>
      <button type="button" aria-label="Hide this message" onClick=${() => (pageStore.othersFound.value = 0)}>×</button>
    </div>
  `;
}

/** Buttons for touch screens, which have no Escape key and no room for a star on a small frame. */
export function Mating() {
  const shown = lineageStore.mate.value && shownIndividual(lineageStore.mate.value.id);
  const of = shown ?? lineageStore.mate.value;
  if (!of) return null;
  if (!shown) return html`<${Elsewhere} of=${of} />`;
  return html`
    <div class="mating" data-testid="mating">
      <span>Tap the other parent</span>
      <button type="button" aria-pressed=${of.favourite} onClick=${() => setFavourite(of, !of.favourite, "The mate")}>${of.favourite ? "★" : "☆"} Favourite</button>
      <button type="button" onClick=${cancelMate}>Cancel</button>
    </div>
  `;
}

export function Hint() {
  if (!pageStore.hintShown.value) return null;
  return html`
    <div class="hint">
      <p class="mouse">Click a picture to breed from it · right-click one and click another to mix them · the star keeps one · drag the centre to turn it</p>
      <p class="touch">Tap a picture to breed from it · press one long and tap another to mix them · drag the centre to turn it</p>
      <button type="button" aria-label="Hide this hint" title="Hide this hint; the knobs bring it back" onClick=${() => (pageStore.hintShown.value = false)}>×</button>
    </div>
  `;
}
