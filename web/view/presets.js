/**
 * The gallery of presets. Owns the dialog; what choosing one leads to is done elsewhere.
 *
 * @import { Preset } from "../types.js"
 */
import { genomes } from "../genomes.js";
import { html } from "../html.js";
import { alone, guarded } from "../lineage.js";
import { crossWith, fits, listPresets, presets, startFrom } from "../presets.js";
import { forget, large, lineage, presetsOpen } from "../state.js";
import { signal } from "../vendor/signals-core.js";
import { Choice } from "./control.js";
import { modal, shut } from "./dialog.js";
import { Trouble } from "./trouble.js";

/** What choosing one does. @type {import("../vendor/signals-core.js").Signal<"begin"|"cross">} */
const use = signal("begin");
const USES = [{ value: "begin", name: "begin a lineage" }, { value: "cross", name: "cross with the centre" }];
const WORDS = {
  begin: "Each begins a lineage of its own; what you have bred stays where it is.",
  cross: "Each comes into this lineage and is crossed with what is in the centre.",
};

const opened = modal(() => {
  use.value = "begin";
  void guarded("presets", listPresets);
});

function close() {
  presetsOpen.value = false;
  forget("presets");
}

/** Why one cannot be crossed with what is here; empty where it can. @param {Preset} preset */
function misfit({ dialect }) {
  const of = lineage.value;
  const centre = genomes.value.get(large.value?.hash ?? "") ?? null;
  return use.value === "begin" || !of || fits(of, centre, dialect) ? "" : `Its program is for another machine: ${dialect.opcodes} instructions, ${dialect.registers} registers`;
}

/** @param {Preset} preset */
const choose = (preset) => alone("presets", () => (use.value === "cross" ? crossWith(preset) : startFrom(preset)));

/** @param {Preset} preset */
const Tile = (preset) => html`
  <li key=${preset.name}>
    <button type="button" data-testid=${`preset-${preset.name}`} disabled=${misfit(preset) !== ""} title=${misfit(preset)} onClick=${() => choose(preset)}>
      <img src=${`/web/presets/${preset.name}.png`} alt="" width="96" height="96" loading="lazy" />
      <strong>${preset.title}</strong>
      <span class="small">${preset.words}</span>
    </button>
  </li>
`;

/** @param {{title: string, of: Preset[]}} props */
const Group = ({ title, of }) => of.length > 0 && html`<h3>${title}</h3><ul class="presets">${of.map(Tile)}</ul>`;

export function Presets() {
  if (!presetsOpen.value) return null;
  return html`
    <dialog class="wide" ref=${opened} aria-labelledby="presets-title" onClose=${close}>
      <h2 id="presets-title">Start from a material</h2>
      <${Choice} id="preset-use" name="What a preset does" value=${use.value} options=${USES} turns=${(/** @type {any} */ to) => (use.value = to)} />
      <p class="small">${WORDS[use.value]}</p>
      <${Trouble} place="presets" />
      <${Group} title="Programs" of=${presets.value.filter((one) => one.dialect.length > 0)} />
      <${Group} title="Models" of=${presets.value.filter((one) => one.dialect.length === 0)} />
      <div class="row end"><button type="button" onClick=${shut}>Close</button></div>
    </dialog>
  `;
}
