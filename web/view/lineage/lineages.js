/**
 * The dialog of lineages: open, new, rename, hide.
 *
 * @import { Lineage } from "../../model.js"
 */
import * as api from "../../api/routes.js";
import { forgetToken } from "../../api/session.js";
import { STARTS, create, hide, open, rename } from "../../lineage/open.js";
import { lineageStore } from "../../lineage/store.js";
import { fileName } from "../../page/file_name.js";
import { clearProblems, guarded, runExclusive } from "../../page/problem.js";
import { pageStore } from "../../page/store.js";
import { Choice } from "../control.js";
import { modal, shut } from "../dialog.js";
import { Download } from "../download.js";
import { openFiles } from "../file_drop.js";
import { html } from "../html.js";
import { ServerPicture } from "../picture.js";
import { ProblemBox } from "../problem.js";
import { viewStore } from "../store.js";

const KINDS = [
  { value: "believable", name: "believable", title: "Programs like measured metals, plastics, paints, cloth and wood, in new colours; their children stay like them" },
  { value: "presets", name: "presets", title: "Twenty hand-written materials, as programs and models" },
  { value: "models", name: "models", title: "Models of reflectance with random parameters" },
  { value: "wild", name: "wild", title: "Random programs, which can become anything" },
];

const opened = modal(() => {
  viewStore.startKind.value = "believable";
  void guarded("lineages", async () => {
    lineageStore.lineages.value = await api.listLineages();
  });
});

function close() {
  viewStore.renaming.value = null;
  viewStore.hiding.value = null;
  pageStore.lineagesOpen.value = false;
  clearProblems("lineages");
}

/** @param {Event} event @param {string} field */
function fieldOf(event, field) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  return String(new FormData(form).get(field) ?? "").trim();
}

/** @param {() => Promise<void>} work */
const exclusively = (work) => () => void runExclusive("lineages", work);

/** Selects the old name, so that typing replaces it. @param {HTMLInputElement|null} input */
const selectName = (input) => input?.select();

/** @param {{of: Lineage}} props */
const Cover = ({ of }) => html`<span class="cover">${of.cover && html`<${ServerPicture} url=${of.cover} lazy />`}</span>`;

/** @param {Lineage} of */
function Row(of) {
  const now = of.id === lineageStore.lineage.value?.id;
  if (viewStore.renaming.value === of.id) {
    const submit = (/** @type {Event} */ event) => {
      const name = fieldOf(event, "name");
      void guarded("lineages", async () => {
        if (name && name !== of.name) await rename(of, name);
        viewStore.renaming.value = null;
      });
    };
    return html`
      <li key=${of.id}><form class="row" onSubmit=${submit}>
        <${Cover} of=${of} />
        <input type="text" name="name" aria-label="New name" maxlength="200" required defaultValue=${of.name} ref=${selectName} data-testid="lineage-rename-name" />
        <button type="submit">Rename</button>
        <button type="button" onClick=${() => (viewStore.renaming.value = null)}>Cancel</button>
      </form></li>
    `;
  }
  if (viewStore.hiding.value === of.id) {
    return html`
      <li key=${of.id}><div class="row">
        <${Cover} of=${of} />
        <span class="grow">Hide “${of.name}”? Nothing is deleted.</span>
        <button type="button" data-testid=${`lineage-hide-${of.id}`} onClick=${exclusively(async () => { await hide(of); viewStore.hiding.value = null; })}>Hide</button>
        <button type="button" onClick=${() => (viewStore.hiding.value = null)}>Cancel</button>
      </div></li>
    `;
  }
  return html`
    <li key=${of.id}><div class="row">
      <${Cover} of=${of} />
      <button type="button" class=${now ? "grow on" : "grow"} aria-current=${now ? "true" : undefined} data-testid=${`lineage-open-${of.id}`} onClick=${exclusively(() => open(of.id, null))}>
        <span class="cut">${of.name}</span> <span class="small">${of.dialect.length === 0 && "models · "}${new Date(of.created_ms).toLocaleDateString()}</span>
      </button>
      <${Download} button id=${`lineage-save-${of.id}`} text="Download" label=${`Download ${of.name}`} name=${fileName(of.name, of.id, "json")} place="lineages" path=${() => `/v1/lineages/${of.id}/file`} />
      <button type="button" aria-label=${`Rename ${of.name}`} onClick=${() => (viewStore.renaming.value = of.id)}>Rename</button>
      <button type="button" aria-label=${`Hide ${of.name}`} onClick=${() => (viewStore.hiding.value = of.id)}>Hide</button>
    </div></li>
  `;
}

/** @param {Event} event */
function fileChosen(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  close();
  void openFiles(input.files).finally(() => (input.value = ""));
}

/** @param {Event} event */
function createNamed(event) {
  const name = fieldOf(event, "name");
  const start = STARTS[viewStore.startKind.value];
  if (name) void runExclusive("lineages", () => create(name, start));
}

export function Lineages() {
  if (!pageStore.lineagesOpen.value) return null;
  const newestFirst = [...lineageStore.lineages.value].sort((a, b) => b.created_ms - a.created_ms);
  return html`
    <dialog class="middling" ref=${opened} aria-labelledby="lineages-title" onClose=${close}>
      <h2 id="lineages-title">Lineages</h2>
      <form class="new" onSubmit=${createNamed}>
        <input type="text" name="name" aria-label="Name of a new lineage" placeholder="name of a new lineage" maxlength="200" required data-testid="lineage-name" />
        <span class="row"><span class="small" aria-hidden="true">starts with</span>
          <${Choice} id="lineage-start" name="Content of the new lineage" value=${viewStore.startKind.value} options=${KINDS} onInput=${(/** @type {any} */ to) => (viewStore.startKind.value = to)} /></span>
        <button type="submit" data-testid="lineage-new">New</button>
      </form>
      <label class="button">
        <input type="file" accept=".json,.brood" data-testid="lineage-file" aria-label="Open a saved lineage or a .brood file" onChange=${fileChosen} />
        <span>Open a saved lineage or a .brood file</span>
      </label>
      <${ProblemBox} place="lineages" />
      <ul class="lineages">${newestFirst.map(Row)}</ul>
      <div class="row end">
        ${pageStore.tokenGiven.value && html`<button type="button" data-testid="forget-token" onClick=${exclusively(forgetToken)}>Remove the token</button>`}
        <button type="button" onClick=${shut}>Close</button>
      </div>
    </dialog>
  `;
}
