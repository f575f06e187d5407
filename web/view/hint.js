/**
 * The one line of help under the frames. Owns its words; whether it is wanted is remembered by the page.
 */
import { html } from "../html.js";
import { hinting } from "../state.js";

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
