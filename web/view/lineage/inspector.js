/**
 * The genome inspector: facts, physical checks, image slice, polar plot, code.
 *
 * @import { Individual, Inspection } from "../../model.js"
 */
import { sliceUrl } from "../../api/routes.js";
import { closeInspector, isLockable } from "../../lineage/inspector.js";
import { genomeIn, modelsInWords } from "../../lineage/layers.js";
import { lineageStore } from "../../lineage/store.js";
import { albedoInWords, amount, reflectsInWords } from "../../page/format.js";
import { showProblem } from "../../page/problem.js";
import { Fact } from "../control.js";
import { modal, shut } from "../dialog.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";
import { Exports } from "./exports.js";
import { Code } from "./listing.js";
import { Polar } from "./polar.js";

const SLICE_PX = 288;

const opened = modal();

/** "paper smooth registers 7" as "paper, smooth, 7 registers". @param {string} words */
const dialectInWords = (words) => words.split(/ (?!\d)/).map((part) => part.replace(/^(\w+) (\d+)$/, "$2 $1")).join(", ");

/** @param {{of: Inspection}} props */
const ProgramFacts = ({ of: { counts, dialect, inputs } }) => html`
  <${Fact} name="dialect" value=${dialectInWords(dialect)} />
  <${Fact} name="inputs read" value=${inputs.join(" ") || "none"} title=${`${counts.inputs_read} of ${counts.inputs_known}`} />
  <${Fact} name="instructions" value=${`${counts.live_instructions} of ${counts.instructions} live`} />
  <${Fact} name="operations run" value=${counts.operations} title="Scalar operations for each sample, after folding" />
  <${Fact} name="registers" value=${counts.registers} title="Values that the scalar code holds at the same time" />
`;

/** @param {{of: Inspection}} props */
function Facts({ of }) {
  const { counts, physics, energy } = of;
  const { layers } = genomeIn(of.source);
  const reciprocity = physics.not_reciprocal === 0
    ? `all ${physics.swapped_pairs.toLocaleString("en")} pairs the same`
    : `${physics.not_reciprocal.toLocaleString("en")} of ${physics.swapped_pairs.toLocaleString("en")} pairs differ`;
  return html`
    <section aria-labelledby="facts-title">
      <h3 id="facts-title">Facts</h3>
      <dl>
        ${layers.length > 0 && html`<${Fact} name="models" value=${modelsInWords(layers.map(({ model }) => model))} title=${layers.length > 1 ? "Their reflectances are added" : undefined} />`}
        ${counts.instructions > 0 && html`<${ProgramFacts} of=${of} />`}
      </dl>
    </section>
    <section aria-labelledby="checks-title">
      <h3 id="checks-title">Physical checks</h3>
      <dl>
        <${Fact} name="f" value=${`${amount(physics.min_f)} to ${amount(physics.max_f)}`} title=${`Of ${physics.samples.toLocaleString("en")} sampled values`} />
        <${Fact} name="not finite" value=${physics.non_finite === 0 ? "none" : physics.non_finite.toLocaleString("en")} />
        <${Fact} name="swapped light and eye" value=${reciprocity} title="Reciprocity: f is bit-equal when light and eye are exchanged" />
        <${Fact} name="largest albedo" value=${reflectsInWords(energy)} title=${albedoInWords(energy)} />
      </dl>
      <p class="small">${albedoInWords(energy)}</p>
      ${of.bumps && html`<p class="small" data-testid="inspected-bumps">Bumps: mean slope ${amount(of.bumps.mean)}, largest ${amount(of.bumps.largest)}. The checks are about the normal that they turn; about the mesh's, f is not reciprocal, and steep places may reflect more.</p>`}
    </section>
  `;
}

const noSlice = () => showProblem("inspector", { problem: { title: "The image slice cannot be drawn", status: 500, detail: "The rest of the inspection is shown." } });

/** @param {{of: Individual}} props */
const Slice = ({ of }) => html`
  <figure class="slice" data-testid="slice">
    <span class="up">difference angle, 0 to 90°</span>
    <${ServerPicture} url=${sliceUrl(of.id, SLICE_PX)} side=${SLICE_PX} alt="Image slice: half angle to the right, difference angle upward, both from 0 to 90 degrees" onFailed=${(/** @type {boolean} */ often) => often && noSlice()} />
    <span class="right">half angle, 0 to 90°</span>
  </figure>
`;

/** @param {{of: Individual, found: Inspection}} props */
const Found = ({ of, found }) => html`
  <div class="found">
    <div class="looks">
      <${Facts} of=${found} />
      <section aria-labelledby="slice-title"><h3 id="slice-title">Image slice</h3><${Slice} of=${of} /></section>
      <section aria-labelledby="polar-title"><h3 id="polar-title">Reflectance</h3><${Polar} planes=${found.planes} /></section>
    </div>
    <${Code} of=${found} lockable=${isLockable(of)} />
  </div>
`;

export function Inspector() {
  if (!lineageStore.inspected.value) return null;
  const { of, name } = lineageStore.inspected.value;
  const found = lineageStore.inspections.value.get(of.hash);
  return html`
    <dialog class="inspector" data-testid="inspector" ref=${opened} aria-labelledby="inspector-title" onClose=${closeInspector}>
      <div class="row title">
        <h2 id="inspector-title">Genome <code title=${of.hash}>${of.hash.slice(0, 12)}</code></h2>
        <span class="small grow">${name}</span>
        <button type="button" data-testid="inspector-close" onClick=${shut}>Close</button>
      </div>
      <${ProblemBox} place="inspector" />
      <${Exports} of=${of} name=${lineageStore.lineage.value?.name ?? ""} place="inspector" />
      ${found ? html`<${Found} of=${of} found=${found} />` : html`<p class="small" role="status">The server is inspecting the genome …</p>`}
    </dialog>
  `;
}
