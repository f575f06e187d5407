/**
 * The gallery of presets. Owns the dialog; what choosing one leads to is done elsewhere.
 *
 * @import { Preset } from "../types.js"
 */
import { html } from "../html.js";
import { guarded } from "../lineage.js";
import { listPresets, presets, startFrom } from "../presets.js";
import { forget, presetsOpen } from "../state.js";
import { Trouble } from "./trouble.js";

/** @param {HTMLDialogElement|null} dialog */
function opened(dialog) {
  if (!dialog || dialog.open) return;
  dialog.showModal();
  void guarded("presets", listPresets);
}

function close() {
  presetsOpen.value = false;
  forget("presets");
}

/** @param {Preset} preset */
const Choice = (preset) => html`
  <li key=${preset.name}>
    <button type="button" data-testid=${`preset-${preset.name}`} onClick=${() => guarded("presets", () => startFrom(preset))}>
      <img src=${`/web/presets/${preset.name}.png`} alt="" width="96" height="96" loading="lazy" />
      <strong>${preset.title}</strong>
      <span class="small">${preset.words}</span>
    </button>
  </li>
`;

export function Presets() {
  if (!presetsOpen.value) return null;
  return html`
    <dialog class="wide" ref=${opened} aria-labelledby="presets-title" onClose=${close}>
      <h2 id="presets-title">Start from a material</h2>
      <p class="small">Each begins a lineage of its own; what you have bred stays where it is.</p>
      <${Trouble} place="presets" />
      <ul class="presets">${presets.value.map(Choice)}</ul>
      <div class="row end"><button type="button" onClick=${close}>Close</button></div>
    </dialog>
  `;
}
