/**
 * Locks as they are seen outside the listing: the section of the left pane, the three channels, the sign under the frames, and
 * the toggle that stands before a line. Owns their words and look; what is locked is locks.js's.
 *
 * @import { Channel } from "../types.js"
 */
import { html } from "../html.js";
import { CHANNELS, CHANNEL_WORDS, anyLocked, locksInWords, toggleChannel, unlockAll } from "../locks.js";
import { knobsOpen, locks } from "../state.js";
import { Switch } from "./control.js";
import { Trouble } from "./trouble.js";

/** A padlock, shut or open. @param {{shut: boolean}} props */
const Padlock = ({ shut }) => html`
  <svg class="padlock" viewBox="0 0 12 14" aria-hidden="true"><path class="body" d="M2 6.5h8v6h-8z" /><path class="bow" d=${shut ? "M3.5 6.5v-2a2.5 2.5 0 0 1 5 0v2" : "M3.5 6.5v-2.6a2.5 2.5 0 0 1 4.9 -0.7"} /></svg>
`;

/**
 * The toggle before an instruction, a constant, a model or a parameter.
 * @param {{name: string, on: boolean, held: string, does: () => void}} props `held`: what keeps it besides, in words
 */
export const Lock = ({ name, on, held, does }) => html`
  <button type="button" class=${`lock ${on ? "on" : ""} ${held ? "held" : ""}`} aria-pressed=${on} aria-label=${`Lock ${name}`}
    title=${held && !on ? `Kept already: ${held}` : on ? `Unlock ${name}` : `Lock ${name}`} onClick=${does}><${Padlock} shut=${on || held !== ""} /></button>
`;

/** @param {{prefix: string}} props */
export const ChannelLocks = ({ prefix }) => html`
  <div class="chips" role="group" aria-label="Locked channels">
    ${CHANNELS.map((/** @type {Channel} */ channel) => html`
      <${Switch} key=${channel} id=${`${prefix}-${channel}`} name=${CHANNEL_WORDS[channel]} label=${`Lock ${CHANNEL_WORDS[channel]}`} on=${locks.value.channels.includes(channel)}
        title=${`Children keep what makes their ${CHANNEL_WORDS[channel]}`} turns=${() => toggleChannel(channel)} />
    `)}
  </div>
`;

/** How much is locked, and the way out. @param {{prefix: string}} props */
export const LockCount = ({ prefix }) => anyLocked(locks.value) && html`
  <div class="row locked">
    <span class="grow small" data-testid=${`${prefix}-count`}>${locksInWords(locks.value)} locked</span>
    <button type="button" data-testid=${`${prefix}-unlock`} onClick=${unlockAll}>Unlock all</button>
  </div>
`;

export const Locks = () => html`
  <section aria-labelledby="locks-title" id="locks" data-testid="locks">
    <h2 id="locks-title">Locks</h2>
    <${ChannelLocks} prefix="lock" />
    <${LockCount} prefix="locks" />
    ${!anyLocked(locks.value) && html`<p class="small">Children keep what is locked. Inspect a genome (I) to lock single parts of it.</p>`}
    <${Trouble} place="locks" />
  </section>
`;

function showLocks() {
  knobsOpen.value = true;
  document.getElementById("locks")?.scrollIntoView({ block: "nearest" });
}

/** Under the frames, so that nobody wonders why children stay as they are. */
export const LockSign = () => anyLocked(locks.value) && html`
  <p class="lock-sign"><button type="button" data-testid="lock-sign" title="Children keep what is locked; opens the locks" onClick=${showLocks}><${Padlock} shut=${true} /> ${locksInWords(locks.value)} locked</button></p>
`;
