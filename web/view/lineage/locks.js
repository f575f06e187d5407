/**
 * Locks outside of the listing: section of the left pane, sign under the frames, and the padlock
 * buttons.
 *
 * @import { Channel } from "../../model.js"
 */
import {
  CHANNELS, CHANNEL_WORDS, anyLocked, locksInWords, onlyTwinsInWords, toggleBumpLock, toggleChannel,
  unlockAll,
} from "../../lineage/locks.js";
import { lineageStore } from "../../lineage/store.js";
import { pageStore } from "../../page/store.js";
import { Switch } from "../control.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";

/** A padlock, closed or open. @param {{shut: boolean}} props */
const Padlock = ({ shut }) => html`
  <svg class="padlock" viewBox="0 0 12 14" aria-hidden="true"><path class="body" d="M2 6.5h8v6h-8z" /><path class="bow" d=${shut ? "M3.5 6.5v-2a2.5 2.5 0 0 1 5 0v2" : "M3.5 6.5v-2.6a2.5 2.5 0 0 1 4.9 -0.7"} /></svg>
`;

/**
 * Padlock button of an instruction, a constant, a model or a parameter.
 * @param {{name: string, on: boolean, held: string, onClick: () => void}} props `held`: what else
 *   keeps it, in words
 */
export const Lock = ({ name, on, held, onClick }) => html`
  <button type="button" class=${`lock ${on ? "on" : ""} ${held ? "held" : ""}`} aria-pressed=${on} aria-label=${`Lock ${name}`}
    title=${held && !on ? `Already kept: ${held}` : on ? `Unlock ${name}` : `Lock ${name}`} onClick=${onClick}><${Padlock} shut=${on || held !== ""} /></button>
`;

/** @param {{prefix: string}} props */
export const ChannelLocks = ({ prefix }) => html`
  <div class="chips" role="group" aria-label="Locked channels">
    ${CHANNELS.map((/** @type {Channel} */ channel) => html`
      <${Switch} key=${channel} id=${`${prefix}-${channel}`} name=${CHANNEL_WORDS[channel]} label=${`Lock ${CHANNEL_WORDS[channel]}`} on=${lineageStore.locks.value.channels.includes(channel)}
        title=${`Children keep all that determines their ${CHANNEL_WORDS[channel]}`} onInput=${() => toggleChannel(channel)} />
    `)}
  </div>
`;

/** Summary of the locks with a button that removes them. @param {{prefix: string}} props */
export const LockCount = ({ prefix }) => anyLocked(lineageStore.locks.value) && html`
  <div class="row locked">
    <span class="grow small" data-testid=${`${prefix}-count`}>${locksInWords(lineageStore.locks.value)} locked</span>
    <button type="button" data-testid=${`${prefix}-unlock`} onClick=${unlockAll}>Unlock all</button>
  </div>
`;

export const Locks = () => html`
  <section aria-labelledby="locks-title" id="locks" data-testid="locks">
    <h2 id="locks-title">Locks</h2>
    <${ChannelLocks} prefix="lock" />
    <div class="chips"><${Switch} id="lock-bumps" name="bumps" label="Lock bumps" on=${lineageStore.locks.value.bump} title="Children keep the bumps, or that there are none" onInput=${toggleBumpLock} /></div>
    <${LockCount} prefix="locks" />
    ${!anyLocked(lineageStore.locks.value) && html`<p class="small">Children keep locked parts. Inspect a genome (I) to lock single parts.</p>`}
    <${ProblemBox} place="locks" />
  </section>
`;

function showLocks() {
  pageStore.knobsOpen.value = true;
  // After the pane has been drawn.
  requestAnimationFrame(() => document.getElementById("locks")?.scrollIntoView({ block: "nearest" }));
}

/** Warning that the next brood would be twins of the centre, before it is bred. */
export function TwinsWarning() {
  const { mutation, recombination, painting } = lineageStore.knobs.value;
  const of = lineageStore.centre.value;
  const genome = of ? (lineageStore.genomes.value.get(of.hash) ?? null) : null;
  const words = onlyTwinsInWords({ mutation, recombination, hasMate: lineageStore.mate.value !== null, locks: lineageStore.locks.value, genome, recoloured: lineageStore.painted.value && painting !== null });
  return words && html`<p class="lock-sign warning" role="status" data-testid="twins-warning">${words}</p>`;
}

/** Sign under the frames that explains why children resemble their parent. */
export const LockSign = () => anyLocked(lineageStore.locks.value) && html`
  <p class="lock-sign"><button type="button" data-testid="lock-sign" title="Children keep locked parts; opens the locks" onClick=${showLocks}><${Padlock} shut=${true} /> ${locksInWords(lineageStore.locks.value)} locked</button></p>
`;
