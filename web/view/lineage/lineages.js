/**
 * The dialog of lineages: search, open, new, edit, hide, restore.
 *
 * @import { Lineage } from "../../model.js"
 */
import { forgetToken } from "../../api/session.js";
import { kindInWords } from "../../lineage/layers.js";
import { describe, listedLineages, restore, tagsIn } from "../../lineage/listed.js";
import { STARTS, create, hide, open } from "../../lineage/open.js";
import { lineageStore } from "../../lineage/store.js";
import { fileName } from "../../page/file_name.js";
import { clearProblems, guarded, runExclusive } from "../../page/problem.js";
import { pageStore } from "../../page/store.js";
import { Choice, Switch, typed } from "../control.js";
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
  { value: "painted", name: "painted", title: "Cartoons, ink and water colours: palettes mixed by the amount of light" },
  { value: "wild", name: "wild", title: "Random programs, which can become anything" },
];

const opened = modal(() => {
  viewStore.startKind.value = "believable";
});

function close() {
  viewStore.renaming.value = null;
  viewStore.hiding.value = null;
  lineageStore.listFilter.value = { search: "", hidden: false };
  pageStore.othersFound.value = 0;
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
const selectName = (input) => {
  if (input && document.activeElement !== input) input.select();
};

/** @param {{of: Lineage}} props */
const Cover = ({ of }) => html`<span class="cover">${of.cover && html`<${ServerPicture} url=${of.cover} lazy />`}</span>`;

/** @param {number} count @param {string} noun */
const counted = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;

/** Facts of a lineage in a line. @param {Lineage} of */
const factsOf = (of) =>
  [
    ...[kindInWords(of)].filter((kind) => kind !== ""),
    counted(of.generations, "generation"),
    ...(of.favourites > 0 ? [counted(of.favourites, "favourite")] : []),
    new Date(of.created_ms).toLocaleDateString(),
  ].join(" · ");

/** Form for name, tags and notes. @param {{of: Lineage}} props */
function Edit({ of }) {
  const submit = (/** @type {Event} */ event) => {
    const words = {
      name: fieldOf(event, "name"),
      tags: tagsIn(fieldOf(event, "tags")),
      notes: fieldOf(event, "notes"),
    };
    void guarded("lineages", async () => {
      await describe(of, words);
      viewStore.renaming.value = null;
    });
  };
  return html`
    <li><form class="edit" onSubmit=${submit}>
      <${Cover} of=${of} />
      <div class="fields">
        <label>Name <input type="text" name="name" maxlength="200" required defaultValue=${of.name} ref=${selectName} data-testid="lineage-rename-name" /></label>
        <label>Tags, separated by commas <input type="text" name="tags" maxlength="400" defaultValue=${of.tags.join(", ")} data-testid="lineage-tags" /></label>
        <label>Notes <textarea name="notes" rows="2" maxlength="10000" defaultValue=${of.notes} data-testid="lineage-notes"></textarea></label>
        <div class="row end">
          <button type="button" onClick=${() => (viewStore.renaming.value = null)}>Cancel</button>
          <button type="submit" data-testid="lineage-edit-save">Save</button>
        </div>
      </div>
    </form></li>
  `;
}

/** @param {Lineage} of */
function Row(of) {
  const now = of.id === lineageStore.lineage.value?.id;
  if (viewStore.renaming.value === of.id) return html`<${Edit} key=${of.id} of=${of} />`;
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
        <span class="cut">${of.name}</span>
        <span class="small facts-line">${factsOf(of)}</span>
        ${of.tags.length > 0 && html`<span class="tags">${of.tags.map((tag) => html`<span key=${tag} class="tag">${tag}</span>`)}</span>`}
      </button>
      <${Download} button id=${`lineage-save-${of.id}`} text="Download" label=${`Download ${of.name}`} name=${fileName(of.name, of.id, "json")} place="lineages" path=${() => `/v1/lineages/${of.id}/file`} />
      <button type="button" aria-label=${`Edit ${of.name}`} title="Name, tags and notes" onClick=${() => (viewStore.renaming.value = of.id)}>Edit</button>
      ${of.hidden
        ? html`<button type="button" data-testid=${`lineage-restore-${of.id}`} aria-label=${`Restore ${of.name}`} onClick=${exclusively(() => restore(of))}>Restore</button>`
        : html`<button type="button" aria-label=${`Hide ${of.name}`} onClick=${() => (viewStore.hiding.value = of.id)}>Hide</button>`}
    </div></li>
  `;
}

/** Search by words, and the choice of hidden lineages. */
function Search() {
  const filter = lineageStore.listFilter.value;
  const set = (/** @type {Partial<typeof filter>} */ change) => {
    viewStore.renaming.value = null;
    viewStore.hiding.value = null;
    lineageStore.listFilter.value = { ...filter, ...change };
  };
  return html`
    <div class="row" role="search" aria-label="Lineages">
      <input type="search" class="grow" maxlength="200" aria-label="Search lineages" placeholder="search names, tags and notes" value=${filter.search} data-testid="lineage-search" onInput=${(/** @type {Event} */ event) => set({ search: typed(event).trimStart() })} />
      <${Switch} id="lineage-hidden" name="Hidden" on=${filter.hidden} title="List the hidden lineages, to restore them" onInput=${(/** @type {boolean} */ hidden) => set({ hidden })} />
    </div>
  `;
}

/** Reason why the list is empty. */
function nothingListed() {
  const { search, hidden } = lineageStore.listFilter.value;
  if (search) return `No ${hidden ? "hidden " : ""}lineage has these words.`;
  return hidden ? "No lineage is hidden." : "No lineages yet.";
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
  const listed = listedLineages();
  return html`
    <dialog class="middling of-lineages" ref=${opened} aria-labelledby="lineages-title" onClose=${close}>
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
      <${Search} />
      ${listed.length > 0 ? html`<ul class="lineages" aria-label="Lineages, newest first">${listed.map(Row)}</ul>` : html`<p class="small lineages" role="status">${nothingListed()}</p>`}
      <div class="row end">
        ${pageStore.tokenGiven.value && html`<button type="button" data-testid="forget-token" onClick=${exclusively(forgetToken)}>Remove the token</button>`}
        <button type="button" onClick=${shut}>Close</button>
      </div>
    </dialog>
  `;
}
