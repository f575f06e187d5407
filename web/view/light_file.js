/** Button that lights the object with a file. */
import { lightByFile } from "../scene/edit.js";
import { LIGHT_KINDS } from "../scene/light_kind.js";
import { html } from "./html.js";

/** @param {"ies"|"environment"} kind @param {Event} event */
function readFile(kind, event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  const [file] = input.files ?? [];
  if (file) void lightByFile(kind, file);
  input.value = "";
}

/** @param {{kind: "ies"|"environment", disabled: boolean}} properties */
export function LightFile({ kind, disabled }) {
  const { name, accept } = LIGHT_KINDS[kind];
  return html`
    <label class="button">
      <input type="file" accept=${accept} data-testid=${`light-${kind}`} aria-label=${name} disabled=${disabled} onChange=${(/** @type {Event} */ event) => readFile(kind, event)} />
      <span>${name}…</span>
    </label>
  `;
}
