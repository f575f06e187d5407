/**
 * The one line of help under the frames, and what fingers can do with a mate. Owns their words; whether help is wanted is remembered
 * by the page.
 */
import { cancelMate, setFavourite } from "../breed.js";
import { html } from "../html.js";
import { hinting, individualOf, mate } from "../state.js";

/** A finger has no Escape, and a small frame no room for a star. */
export function Mating() {
  const of = mate.value && (individualOf(mate.value.id) ?? mate.value);
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
  if (!hinting.value) return null;
  return html`
    <div class="hint">
      <p class="mouse">Click a picture to breed from it · right-click one and click another to mix them · the star keeps one · drag the centre to turn it</p>
      <p class="touch">Tap a picture to breed from it · press one long and tap another to mix them · drag the centre to turn it</p>
      <button type="button" aria-label="Hide this help" title="Hide this help; the knobs bring it back" onClick=${() => (hinting.value = false)}>×</button>
    </div>
  `;
}
