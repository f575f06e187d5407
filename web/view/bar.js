/**
 * The bar at the top: lineage, undo, redo, re-roll, presets, favourites, searches, status, link,
 * panes.
 */
import { breedRandom, reroll } from "../lineage/breed.js";
import { redo, redoId, undo, undoId } from "../lineage/generations.js";
import { kindInWords } from "../lineage/layers.js";
import { twinsInWords } from "../lineage/locks.js";
import { FRAMES, lineageStore } from "../lineage/store.js";
import { pageStore } from "../page/store.js";
import { sceneStore } from "../scene/store.js";
import { openFavourites } from "../favourites/list.js";
import { openSearches } from "../search/searches.js";
import { searchStore } from "../search/store.js";
import { html } from "./html.js";
import { viewStore } from "./store.js";

/** Copies the address, or shows it where the browser has no clipboard. */
async function share() {
  try {
    await navigator.clipboard.writeText(location.href);
    viewStore.linkCopied.value = true;
    pageStore.announcement.value = "Link copied.";
    setTimeout(() => {
      viewStore.linkCopied.value = false;
    }, 2000);
  } catch {
    viewStore.link.value = location.href;
  }
}

/** Text of the status line. */
function status() {
  const of = lineageStore.generation.value;
  const lostWords = pageStore.connectionLost.value ? ["Connection lost, retrying..."] : [];
  if (!of) return lineageStore.breeding.value ? "breeding the first brood" : lostWords.join();
  const framed = of.individuals.filter((one) => one.slot < FRAMES);
  const there = framed.filter((one) => lineageStore.loadedPictures.value.has(one.thumbnail)).length;
  const parts = [...lostWords, `generation ${of.index}`, `${there} of ${framed.length}`];
  const twins = twinsInWords(of);
  if (twins) parts.push(twins);
  if (lineageStore.breeding.value) parts.push("breeding");
  else if (sceneStore.busy.value) parts.push("drawing");
  else if (lineageStore.elapsed_ms.value !== null) parts.push(`${Math.round(lineageStore.elapsed_ms.value)} ms`);
  const backend = pageStore.serverInfo.value?.backend;
  if (backend) parts.push(`${backend.name} ${backend.adapter}`.trim() + (backend.exact ? ", bit-exact" : ", not exact"));
  return parts.join(" · ");
}

/**
 * @param {{id: string, sign: string, name: string, keys?: string, known?: boolean, disabled?:
 *   boolean, onClick: () => unknown}} props `known`: true if the sign says enough where room is
 *   short
 */
function ActionButton({ id, sign, name, keys, known = false, disabled, onClick }) {
  return html`
    <button type="button" class=${known ? "sign" : undefined} data-testid=${id} disabled=${disabled} aria-label=${name} title=${keys ? `${name} (${keys})` : name} onClick=${onClick}>
      <span aria-hidden="true">${sign}</span><span class="word" aria-hidden="true"> ${name}</span>
    </button>
  `;
}

export function Bar() {
  const can = { undo: undoId(), redo: redoId() };
  const kind = lineageStore.lineage.value ? kindInWords(lineageStore.lineage.value) : "";
  return html`
    <header class="bar">
      <h1>brood</h1>
      <button type="button" class="lineage" data-testid="lineage-menu" aria-haspopup="dialog" onClick=${() => (pageStore.lineagesOpen.value = true)}>
        <span class="cut">${lineageStore.lineage.value?.name ?? "lineages"}</span> ${kind && html`<span class="kind">${kind}</span>`} <span aria-hidden="true">▾</span>
      </button>
      <div class="actions" role="group" aria-label="History and breeding">
        <${ActionButton} id="undo" sign="↶" name="Undo" keys="Ctrl+Z" known disabled=${!can.undo} onClick=${undo} />
        <${ActionButton} id="redo" sign="↷" name="Redo" keys="Ctrl+Shift+Z" known disabled=${!can.redo} onClick=${redo} />
        <${ActionButton} id="reroll" sign="⟳" name="Re-roll" known disabled=${!lineageStore.generation.value} onClick=${reroll} />
        <${ActionButton} id="presets" sign="◐" name="Presets" onClick=${() => (pageStore.presetsOpen.value = true)} />
        <${ActionButton} id="favourites" sign="★" name="Favourites" keys="V" onClick=${() => openFavourites()} />
        <${ActionButton} id="searches" sign="◎" name=${searchStore.runningCount.value > 0 ? `Searches · ${searchStore.runningCount.value}` : "Searches"} keys="S" onClick=${() => openSearches()} />
        <${ActionButton} id="afresh" sign="✳" name="New random brood" disabled=${!lineageStore.lineage.value} onClick=${breedRandom} />
      </div>
      <p class="status" data-testid="status" title=${pageStore.serverInfo.value?.backend?.reason ?? ""}>${status()}</p>
      <div class="actions" role="group" aria-label="View">
        ${viewStore.link.value === null
          ? html`<button type="button" data-testid="share" disabled=${!lineageStore.shownId.value} onClick=${share}>${viewStore.linkCopied.value ? "Copied" : "Share"}</button>`
          : html`<input type="text" class="link" readonly aria-label="Link to this state" value=${viewStore.link.value} onFocus=${selectAll} onBlur=${() => (viewStore.link.value = null)} />`}
        <button type="button" data-testid="help-open" aria-label="Keys and gestures" title="Keys and gestures (?)" onClick=${() => (pageStore.helpOpen.value = true)}>?</button>
        <button type="button" data-testid="knobs-toggle" aria-pressed=${pageStore.knobsOpen.value} onClick=${() => (pageStore.knobsOpen.value = !pageStore.knobsOpen.value)}>Knobs</button>
        <button type="button" data-testid="details-toggle" aria-pressed=${pageStore.detailsOpen.value} onClick=${() => (pageStore.detailsOpen.value = !pageStore.detailsOpen.value)}>Details</button>
      </div>
    </header>
  `;
}

/** @param {FocusEvent} event */
function selectAll(event) {
  if (event.target instanceof HTMLInputElement) event.target.select();
}
