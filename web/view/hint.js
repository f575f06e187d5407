/** The hint line under the frames, and the mate's buttons on touch screens. */
import { cancelMate, setFavourite } from "../lineage/breed.js";
import { shownIndividual } from "../lineage/individuals.js";
import { lineageStore } from "../lineage/store.js";
import { pageStore } from "../page/store.js";
import { html } from "./html.js";

/** Buttons for touch screens, which have no Escape key and no room for a star on a small frame. */
export function Mating() {
  const of = lineageStore.mate.value && (shownIndividual(lineageStore.mate.value.id) ?? lineageStore.mate.value);
  if (!of) return null;
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
