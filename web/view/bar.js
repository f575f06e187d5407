/**
 * The bar at the top: lineage, undo, redo, re-roll, start afresh, status, link. Owns its words; the deeds are elsewhere.
 */
import { signal } from "../vendor/signals-core.js";
import { afresh, reroll } from "../breed.js";
import { away } from "../events.js";
import { html } from "../html.js";
import { redoTarget, undoTarget } from "../history.js";
import { redo, undo } from "../lineage.js";
import { twinsInWords } from "../locks.js";
import { loaded } from "../pictures.js";
import { busy, openSearches } from "../searches.js";
import {
  FRAMES, announcement, breeding, descent, detailsOpen, elapsed, generation, knobsOpen, lineage, lineagesOpen, presetsOpen, sceneBusy,
  shown, system, trail,
} from "../state.js";

/** The address, shown to be copied by hand where the browser gives no clipboard. @type {import("../vendor/signals-core.js").Signal<string|null>} */
const link = signal(null);
const copied = signal(false);

async function share() {
  try {
    await navigator.clipboard.writeText(location.href);
    copied.value = true;
    announcement.value = "The link is copied.";
    setTimeout(() => {
      copied.value = false;
    }, 2000);
  } catch {
    link.value = location.href;
  }
}

function status() {
  const of = generation.value;
  const unheard = away.value ? ["the server is not heard, asking again"] : [];
  if (!of) return breeding.value ? "the first brood is being made" : unheard.join();
  const framed = of.individuals.filter((one) => one.slot < FRAMES);
  const there = framed.filter((one) => loaded.value.has(one.thumbnail)).length;
  const parts = [...unheard, `generation ${of.index}`, `${there} of ${framed.length}`];
  const twins = twinsInWords(of);
  if (twins) parts.push(twins);
  if (breeding.value) parts.push("breeding");
  else if (sceneBusy.value) parts.push("drawing");
  else if (elapsed.value !== null) parts.push(`${Math.round(elapsed.value)} ms`);
  const backend = system.value?.backend;
  if (backend) parts.push(`${backend.name} ${backend.adapter}`.trim() + (backend.exact ? ", bit-exact" : ", not exact"));
  return parts.join(" · ");
}

/** @param {{id: string, sign: string, name: string, keys?: string, disabled?: boolean, does: () => unknown}} props */
function Deed({ id, sign, name, keys, disabled, does }) {
  return html`
    <button type="button" data-testid=${id} disabled=${disabled} aria-label=${name} title=${keys ? `${name} (${keys})` : name} onClick=${does}>
      <span aria-hidden="true">${sign}</span><span class="word" aria-hidden="true"> ${name}</span>
    </button>
  `;
}

export function Bar() {
  const can = { undo: undoTarget(trail.value, descent.value, shown.value), redo: redoTarget(trail.value, descent.value, shown.value) };
  return html`
    <header class="bar">
      <h1>brood</h1>
      <button type="button" class="lineage" data-testid="lineage-menu" aria-haspopup="dialog" onClick=${() => (lineagesOpen.value = true)}>
        <span class="cut">${lineage.value?.name ?? "lineages"}</span> ${lineage.value?.dialect.length === 0 && html`<span class="kind">models</span>`} <span aria-hidden="true">▾</span>
      </button>
      <div class="deeds" role="group" aria-label="History and breeding">
        <${Deed} id="undo" sign="↶" name="Undo" keys="Ctrl+Z" disabled=${!can.undo} does=${undo} />
        <${Deed} id="redo" sign="↷" name="Redo" keys="Ctrl+Shift+Z" disabled=${!can.redo} does=${redo} />
        <${Deed} id="reroll" sign="⟳" name="Re-roll" disabled=${!generation.value} does=${reroll} />
        <${Deed} id="presets" sign="◐" name="Presets" does=${() => (presetsOpen.value = true)} />
        <${Deed} id="searches" sign="◎" name=${busy.value > 0 ? `Searches · ${busy.value}` : "Searches"} keys="S" does=${() => openSearches()} />
        <${Deed} id="afresh" sign="✳" name="Start afresh" disabled=${!lineage.value} does=${afresh} />
      </div>
      <p class="status" data-testid="status" title=${system.value?.backend?.reason ?? ""}>${status()}</p>
      <div class="deeds" role="group" aria-label="View">
        ${link.value === null
          ? html`<button type="button" data-testid="share" disabled=${!shown.value} onClick=${share}>${copied.value ? "Copied" : "Share"}</button>`
          : html`<input type="text" class="link" readonly aria-label="Link to this state" value=${link.value} onFocus=${selectAll} onBlur=${() => (link.value = null)} />`}
        <button type="button" data-testid="knobs-toggle" aria-pressed=${knobsOpen.value} onClick=${() => (knobsOpen.value = !knobsOpen.value)}>Knobs</button>
        <button type="button" data-testid="details-toggle" aria-pressed=${detailsOpen.value} onClick=${() => (detailsOpen.value = !detailsOpen.value)}>Details</button>
      </div>
    </header>
  `;
}

/** @param {FocusEvent} event */
function selectAll(event) {
  if (event.target instanceof HTMLInputElement) event.target.select();
}
