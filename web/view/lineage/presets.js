/**
 * The gallery of presets.
 *
 * @import { Preset } from "../../model.js"
 */
import { crossWith, fits, isPaint, listPresets, startFrom } from "../../lineage/presets.js";
import { lineageStore } from "../../lineage/store.js";
import { clearProblems, guarded, runExclusive } from "../../page/problem.js";
import { pageStore } from "../../page/store.js";
import { Choice } from "../control.js";
import { modal, shut } from "../dialog.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";
import { viewStore } from "../store.js";

const USES = [{ value: "begin", name: "begin a lineage" }, { value: "cross", name: "cross with the centre" }];
const WORDS = {
  begin: "Each begins a new lineage; the open lineage stays as it is.",
  cross: "Each is imported into this lineage and crossed with the centre.",
};

const opened = modal(() => {
  viewStore.presetUse.value = "begin";
  void guarded("presets", listPresets);
});

function close() {
  pageStore.presetsOpen.value = false;
  clearProblems("presets");
}

/**
 * Reason why a preset cannot be crossed with the centre; empty if it can.
 * @param {Preset} preset
 */
function misfit(preset) {
  const { dialect } = preset;
  const of = lineageStore.lineage.value;
  const centre = lineageStore.centreGenome.value;
  if (viewStore.presetUse.value === "cross" && isPaint(preset) !== lineageStore.painted.value) return "Painted materials are crossed with painted ones only";
  return viewStore.presetUse.value === "begin" || !of || fits(of, centre, dialect) ? "" : `Its program is for another machine: ${dialect.opcodes} instructions, ${dialect.registers} registers`;
}

/** @param {Preset} preset */
const choose = (preset) => runExclusive("presets", () => (viewStore.presetUse.value === "cross" ? crossWith(preset) : startFrom(preset)));

/** @param {Preset} preset */
const Tile = (preset) => html`
  <li key=${preset.name}>
    <button type="button" data-testid=${`preset-${preset.name}`} disabled=${misfit(preset) !== ""} title=${misfit(preset)} onClick=${() => choose(preset)}>
      <${ServerPicture} url=${`/web/presets/${preset.name}.png`} side=${96} lazy />
      <strong>${preset.title}</strong>
      <span class="small">${preset.words}</span>
    </button>
  </li>
`;

/** @param {{title: string, of: Preset[]}} props */
const Group = ({ title, of }) => of.length > 0 && html`<h3>${title}</h3><ul class="presets">${of.map(Tile)}</ul>`;

export function Presets() {
  if (!pageStore.presetsOpen.value) return null;
  return html`
    <dialog class="wide" ref=${opened} aria-labelledby="presets-title" onClose=${close}>
      <h2 id="presets-title">Start from a material</h2>
      <${Choice} id="preset-use" name="Use of a preset" value=${viewStore.presetUse.value} options=${USES} onInput=${(/** @type {any} */ to) => (viewStore.presetUse.value = to)} />
      <p class="small">${WORDS[viewStore.presetUse.value]}</p>
      <${ProblemBox} place="presets" />
      <${Group} title="Programs" of=${lineageStore.presets.value.filter((one) => one.dialect.length > 0 && !isPaint(one))} />
      <${Group} title="Models" of=${lineageStore.presets.value.filter((one) => one.dialect.length === 0 && !isPaint(one))} />
      <${Group} title="Painted materials" of=${lineageStore.presets.value.filter(isPaint)} />
      <div class="row end"><button type="button" onClick=${shut}>Close</button></div>
    </dialog>
  `;
}
