/**
 * The dialog of favourites of all lineages: filter, pictures, choice of several.
 *
 * @import { Favourite } from "../../model.js"
 */
import { FEWEST, MOST } from "../../compare/comparison.js";
import { chooseAll, compareFavourites } from "../../favourites/chosen.js";
import {
  closeFavourites, lineageName, lineageOf, loadMoreFavourites, openFavourites,
} from "../../favourites/list.js";
import { ALL, favouritesStore } from "../../favourites/store.js";
import { lineageStore } from "../../lineage/store.js";
import { slug } from "../../page/file_name.js";
import { Archive } from "../archive.js";
import { typed } from "../control.js";
import { DialogTitle, modal } from "../dialog.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";
import { Tile } from "./tile.js";

const opened = modal();

/** Choice of the lineage whose favourites are listed. */
function Filter() {
  const of = favouritesStore.openOf.value ?? ALL;
  const listed = lineageStore.lineages.value
    .filter((one) => one.favourites > 0 || one.id === of)
    .sort((a, b) => a.name.localeCompare(b.name));
  const isUnlisted = of !== ALL && !lineageOf(of);
  return html`
    <select aria-label="Lineage" data-testid="favourites-filter" value=${of} onChange=${(/** @type {Event} */ event) => openFavourites(typed(event))}>
      <option value=${ALL}>All lineages</option>
      ${isUnlisted && html`<option value=${of}>${favouritesStore.items.value?.[0] ? lineageName(favouritesStore.items.value[0]) : "another lineage"}</option>`}
      ${listed.map((one) => html`<option key=${one.id} value=${one.id}>${one.name} (${one.favourites})</option>`)}
    </select>
  `;
}

/** Name of the file: of the lineage if all are from one. @param {Favourite[]} of */
function archiveName(of) {
  const names = new Set(of.map(lineageName));
  return `${names.size === 1 ? slug([...names][0]) : "favourites"}-${of.length}.zip`;
}

/** Actions on the chosen favourites. @param {{of: Favourite[], chosen: Favourite[]}} props */
function Tools({ of, chosen }) {
  const all = of.length > 0 && chosen.length === of.length;
  return html`
    <div class="row tools" role="group" aria-label="Chosen favourites">
      <${Filter} />
      <button type="button" data-testid="favourites-all" disabled=${of.length === 0} onClick=${() => chooseAll(!all)}>${all ? "Choose none" : "Choose all"}</button>
      <span class="small grow" data-testid="favourites-count">${chosen.length > 0 ? `${chosen.length} chosen` : ""}</span>
      <button type="button" data-testid="favourites-compare" title=${`Pictures, differences, curves and figures of ${FEWEST} to ${MOST}`} disabled=${chosen.length < FEWEST || chosen.length > MOST} onClick=${compareFavourites}>Compare side by side</button>
      <${Archive} id="archive" title="Save as ZIP" members=${{ individuals: chosen.map(({ id }) => id) }} count=${chosen.length} what=${String(chosen.length)} name=${archiveName(chosen)} place="favourites" />
    </div>
  `;
}

const Empty = () => html`
  <div class="empty">
    <p>${favouritesStore.openOf.value === ALL ? "No favourites yet." : "This lineage has no favourites."}</p>
    <p class="small">Mark a material with the star on its frame, or with F. It is then kept here, whatever you breed next.</p>
  </div>
`;

export function Favourites() {
  if (favouritesStore.openOf.value === null) return null;
  const of = favouritesStore.items.value;
  return html`
    <dialog class="inspector favourites" data-testid="favourites-dialog" ref=${opened} aria-labelledby="favourites-all-title" onClose=${closeFavourites}>
      <${DialogTitle} name="favourites" title="Favourites" labelId="favourites-all-title" />
      <${Tools} of=${of ?? []} chosen=${favouritesStore.chosen.value} />
      <${ProblemBox} place="favourites" />
      <div class="beside">
        ${of === null && html`<p class="small" role="status">Loading …</p>`}
        ${of?.length === 0 && html`<${Empty} />`}
        ${of !== null && of.length > 0 && html`<ul class="tiles" aria-label="Favourites, newest first">${of.map((one) => html`<${Tile} key=${one.id} of=${one} />`)}</ul>`}
        ${favouritesStore.nextCursor.value !== null && html`<button type="button" class="start" data-testid="favourites-more" onClick=${loadMoreFavourites}>Show earlier favourites</button>`}
      </div>
    </dialog>
  `;
}
