/**
 * One favourite: its picture in the light of its lineage, where it is from, and what can be done
 * with it.
 *
 * @import { Favourite } from "../../model.js"
 */
import { choose } from "../../favourites/chosen.js";
import { lineageName, lineageOf, nameOfFavourite, placeOf } from "../../favourites/list.js";
import { favouritesStore, largeUrl } from "../../favourites/store.js";
import {
  acceptsMate, keepFavourite, pinFavourite, showFavourite, startFromFavourite, toggleCover, useAsMate,
} from "../../favourites/uses.js";
import { modelsInWords, modelsOf } from "../../lineage/layers.js";
import { lineageStore } from "../../lineage/store.js";
import { html } from "../html.js";
import { Exports } from "../lineage/exports.js";
import { ServerPicture } from "../picture.js";

/**
 * Picture in the light of its lineage: the thumbnail first, then a larger one.
 * @param {{of: Favourite}} props
 */
const Large = ({ of }) => html`
  <span class="large">
    <${ServerPicture} url=${of.thumbnail} lazy />
    ${favouritesStore.large.value.has(of.id) && html`<${ServerPicture} url=${largeUrl(of.id)} name="over" />`}
  </span>
`;

/** A favourite whose mark was removed, which can be set again. @param {{of: Favourite}} props */
const Removed = ({ of }) => html`
  <div class="row uses"><span class="small">No longer a favourite.</span><button type="button" onClick=${() => keepFavourite(of, true)}>Undo</button></div>
`;

/** @param {{of: Favourite}} props */
function Uses({ of }) {
  const name = nameOfFavourite(of);
  const isOwn = of.lineage === lineageStore.lineage.value?.id;
  const accepted = acceptsMate(of);
  const elsewhere = accepted ? "Import it into the open lineage and mark it as the mate" : "Programs of this dialect do not fit the open lineage; Start makes one for it";
  const hint = isOwn ? "Mark it as the mate: the next click on a frame crosses both" : elsewhere;
  const isCover = lineageOf(of.lineage)?.cover_individual === of.id;
  return html`
    <div class="row uses">
      <button type="button" data-testid="favourite-mate" aria-label=${`Mate: ${name}`} title=${hint} disabled=${!accepted} onClick=${() => useAsMate(of)}>Mate</button>
      <button type="button" data-testid="favourite-start" aria-label=${`Start: ${name}`} title="Start a new lineage from it, in the same light" onClick=${() => startFromFavourite(of)}>Start</button>
      <button type="button" data-testid="favourite-pin" aria-label=${`A / B: ${name}`} title="Compare it with the centre, as B" onClick=${() => pinFavourite(of)}>A / B</button>
    </div>
    <details class="more" name="favourite-more" data-testid="favourite-more">
      <summary aria-label=${`More: ${name}`}>More</summary>
      <div class="sheet">
        <${Exports} of=${of} name=${lineageName(of)} place="favourites" isElsewhere=${!isOwn} />
        <div class="row">
          <button type="button" data-testid="favourite-cover" aria-pressed=${isCover} onClick=${() => toggleCover(of)}>Cover of its lineage</button>
          <button type="button" data-testid="favourite-remove" onClick=${() => keepFavourite(of, false)}>Remove from favourites</button>
        </div>
      </div>
    </details>
  `;
}

/** @param {{of: Favourite}} props */
export function Tile({ of }) {
  const name = nameOfFavourite(of);
  const isRemoved = favouritesStore.removed.value.has(of.id);
  const isChosen = favouritesStore.chosenIds.value.has(of.id);
  const models = modelsInWords(modelsOf(of));
  return html`
    <li class=${`tile${isRemoved ? " removed" : ""}${isChosen ? " chosen" : ""}`} data-testid=${`favourite-${of.id}`}>
      <label class="choose"><input type="checkbox" aria-label=${`Choose ${name}`} checked=${isChosen} onChange=${(/** @type {Event} */ event) => choose(of, /** @type {HTMLInputElement} */ (event.target).checked)} /></label>
      <button type="button" class="picture" data-testid="favourite-show" aria-label=${`Show ${name}`} title="Show it in its lineage" onClick=${() => showFavourite(of)}><${Large} of=${of} /></button>
      <p class="who"><span class="cut">${lineageName(of)}</span><span class="small cut">${placeOf(of)}${models && ` · ${models}`}</span>${of.note && html`<span class="small noted">${of.note}</span>`}</p>
      ${favouritesStore.busyId.value === of.id ? html`<p class="small uses" role="status">One moment …</p>` : isRemoved ? html`<${Removed} of=${of} />` : html`<${Uses} of=${of} />`}
    </li>
  `;
}
