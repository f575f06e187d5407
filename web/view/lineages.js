/**
 * The list of lineages: open, new, rename, hide. Owns the dialog; the deeds are elsewhere.
 *
 * @import { Lineage } from "../types.js"
 */
import { signal } from "../vendor/signals-core.js";
import * as api from "../api.js";
import { takeFiles } from "../files.js";
import { html } from "../html.js";
import { alone, create, guarded, hide, open, rename } from "../lineage.js";
import { forget, lineage, lineages, lineagesOpen } from "../state.js";
import { forgetToken, given } from "../token.js";
import { Choice } from "./control.js";
import { modal, shut } from "./dialog.js";
import { Trouble } from "./trouble.js";

/** Id of the lineage whose name is being written. @type {import("../vendor/signals-core.js").Signal<string|null>} */
const renaming = signal(null);
/** Id of the lineage that is about to be hidden. @type {import("../vendor/signals-core.js").Signal<string|null>} */
const hiding = signal(null);

/** What a new lineage starts with. @type {import("../vendor/signals-core.js").Signal<"programs"|"models">} */
const start = signal("programs");
const STARTS = [
  { value: "programs", name: "programs", title: "Random programs, which become anything" },
  { value: "models", name: "models", title: "Models of reflectance with random parameters: metals, plastics, cloth" },
];

const opened = modal(() => {
  start.value = "programs";
  void guarded("lineages", async () => {
    lineages.value = await api.listLineages();
  });
});

function close() {
  renaming.value = null;
  hiding.value = null;
  lineagesOpen.value = false;
  forget("lineages");
}

/** @param {Event} event @param {string} field */
function fieldOf(event, field) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  return String(new FormData(form).get(field) ?? "").trim();
}

/** @param {() => Promise<void>} work */
const does = (work) => () => void alone("lineages", work);

/** A picture that cannot be had leaves its place empty. @param {Event} event */
const hideBroken = (event) => /** @type {HTMLImageElement} */ (event.target).style.setProperty("visibility", "hidden");

/** The name that is to be written anew is where the next letter goes. @param {HTMLInputElement|null} input */
const begun = (input) => input?.select();

/** @param {{of: Lineage}} props */
const Cover = ({ of }) => html`<span class="cover">${of.cover && html`<img key=${of.cover} src=${of.cover} alt="" loading="lazy" onError=${hideBroken} />`}</span>`;

/** @param {Lineage} of */
function Row(of) {
  const now = of.id === lineage.value?.id;
  if (renaming.value === of.id) {
    const submit = (/** @type {Event} */ event) => {
      const name = fieldOf(event, "name");
      void guarded("lineages", async () => {
        if (name && name !== of.name) await rename(of, name);
        renaming.value = null;
      });
    };
    return html`
      <li key=${of.id}><form class="row" onSubmit=${submit}>
        <${Cover} of=${of} />
        <input type="text" name="name" aria-label="New name" maxlength="200" required defaultValue=${of.name} ref=${begun} data-testid="lineage-rename-name" />
        <button type="submit">Rename</button>
        <button type="button" onClick=${() => (renaming.value = null)}>Cancel</button>
      </form></li>
    `;
  }
  if (hiding.value === of.id) {
    return html`
      <li key=${of.id}><div class="row">
        <${Cover} of=${of} />
        <span class="grow">Hide “${of.name}”? Nothing of it is deleted.</span>
        <button type="button" data-testid=${`lineage-hide-${of.id}`} onClick=${does(async () => { await hide(of); hiding.value = null; })}>Hide</button>
        <button type="button" onClick=${() => (hiding.value = null)}>Cancel</button>
      </div></li>
    `;
  }
  return html`
    <li key=${of.id}><div class="row">
      <${Cover} of=${of} />
      <button type="button" class=${now ? "grow on" : "grow"} aria-current=${now ? "true" : undefined} data-testid=${`lineage-open-${of.id}`} onClick=${does(() => open(of.id, null))}>
        <span class="cut">${of.name}</span> <span class="small">${of.dialect.length === 0 && "models · "}${new Date(of.created_ms).toLocaleDateString()}</span>
      </button>
      <a class="button" download href=${`/v1/lineages/${of.id}/file`} aria-label=${`Save ${of.name} to a file`} data-testid=${`lineage-save-${of.id}`}>Save</a>
      <button type="button" aria-label=${`Rename ${of.name}`} onClick=${() => (renaming.value = of.id)}>Rename</button>
      <button type="button" aria-label=${`Hide ${of.name}`} onClick=${() => (hiding.value = of.id)}>Hide</button>
    </div></li>
  `;
}

/** @param {Event} event */
function fileChosen(event) {
  const input = /** @type {HTMLInputElement} */ (event.target);
  close();
  void takeFiles(input.files).finally(() => (input.value = ""));
}

/** @param {Event} event */
function createNamed(event) {
  const name = fieldOf(event, "name");
  const dialect = start.value === "models" ? { length: 0 } : undefined;
  if (name) void alone("lineages", () => create(name, { dialect }));
}

export function Lineages() {
  if (!lineagesOpen.value) return null;
  const newestFirst = [...lineages.value].sort((a, b) => b.created_ms - a.created_ms);
  return html`
    <dialog class="middling" ref=${opened} aria-labelledby="lineages-title" onClose=${close}>
      <h2 id="lineages-title">Lineages</h2>
      <form class="new" onSubmit=${createNamed}>
        <input type="text" name="name" aria-label="Name of a new lineage" placeholder="name of a new lineage" maxlength="200" required data-testid="lineage-name" />
        <span class="row"><span class="small" aria-hidden="true">starts with</span>
          <${Choice} id="lineage-start" name="What it starts with" value=${start.value} options=${STARTS} turns=${(/** @type {any} */ to) => (start.value = to)} /></span>
        <button type="submit" data-testid="lineage-new">New</button>
      </form>
      <label class="button">
        <input type="file" accept=".json,.brood" data-testid="lineage-file" aria-label="Open a saved lineage or a .brood file" onChange=${fileChosen} />
        <span>Open a saved lineage or a .brood file</span>
      </label>
      <${Trouble} place="lineages" />
      <ul class="lineages">${newestFirst.map(Row)}</ul>
      <div class="row end">
        ${given.value && html`<button type="button" data-testid="forget-token" onClick=${does(forgetToken)}>Forget the token</button>`}
        <button type="button" onClick=${shut}>Close</button>
      </div>
    </dialog>
  `;
}
