/**
 * Two pictures beside each other and one over the other, to be flipped and blended. Owns their arrangement and words; how much is seen
 * is pair.js's.
 *
 * @import { Pair as PairState } from "../pair.js"
 */
import { holdable } from "../flip_key.js";
import { html } from "../html.js";
import { Slider } from "./control.js";

/**
 * @typedef {{name: string, words: string, url: string|null, coming?: boolean, lost?: boolean}} Side
 *   `name`: what is written below it; `words`: what it shows, for those who do not see it.
 */

/** @param {{of: Side, waits: string}} props */
function Picture({ of, waits }) {
  if (of.url === null) return html`<p class="small hollow">${of.lost ? "This picture cannot be drawn." : waits}</p>`;
  return html`<img src=${of.url} class=${of.coming ? "coming" : ""} alt=${of.words} draggable=${false} />`;
}

/** @param {{name: string, on: boolean}} props */
const Name = ({ name, on }) => html`<span class=${on ? "on" : ""}>${name}</span>`;

/**
 * @param {{id: string, upper: Side, lower: Side, state: PairState, waits: string, hint?: string}} props
 *   `upper`: what is looked for, also seen alone beside; `lower`: what is held against it
 */
export function Pair({ id, upper, lower, state, waits, hint }) {
  const seen = state.seen.value;
  const both = upper.url !== null && lower.url !== null;
  const percent = Math.round(100 * seen);
  const hold = holdable(state.key);
  return html`
    <div class="pair" data-testid=${id} aria-busy=${Boolean(upper.coming || lower.coming)}>
      <figure class="square still">
        <div class="paper"><${Picture} of=${upper} waits=${waits} /></div>
        <figcaption>${upper.name}</figcaption>
      </figure>
      <figure class="square">
        <div class="paper" data-seen=${percent}>
          <${Picture} of=${lower} waits=${waits} />
          ${both && html`<img class="over" src=${upper.url} alt="" aria-hidden="true" draggable=${false} style=${{ opacity: seen }} />`}
        </div>
        <figcaption class="flips"><${Name} name=${lower.name} on=${both && seen < 1} />${both && html`<${Name} name=${upper.name} on=${seen > 0} />`}</figcaption>
      </figure>
      ${both && html`
        <div class="blend">
          <${Slider} id=${`${id}-blend`} name="blend" value=${Math.round(100 * state.share.value)} min=${0} max=${100} step=${5} shown=${percent === 0 ? lower.name : percent === 100 ? upper.name : `${percent} %`}
            title=${`How much of ${upper.name} lies over ${lower.name}`} turns=${(/** @type {number} */ to) => {
              state.flipped.value = false;
              state.share.value = to / 100;
            }} />
          <button type="button" class="hold" data-testid=${`${id}-flip`} aria-pressed=${state.flipped.value} title=${`${upper.words} in the place of the other: tap to flip, hold to glance (X)`} ...${hold}>Flip</button>
        </div>
        <p class="small says">${hint ?? "Tap Flip or X to change from one to the other; hold it to glance."}</p>
      `}
    </div>
  `;
}
