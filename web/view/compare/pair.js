/**
 * Two pictures beside each other and over each other, to flip and blend.
 *
 * @import { Pair as PairState } from "../../compare/pair.js"
 */
import { flipHandlers } from "../../compare/flip_key.js";
import { Slider } from "../control.js";
import { html } from "../html.js";

/**
 * @typedef {{name: string, words: string, url: string|null, coming?: boolean, lost?:
 *   boolean}} Side `name`: caption; `words`: alternative text.
 */

/** @param {{of: Side, placeholder: string}} props */
function Picture({ of, placeholder }) {
  if (of.url === null) return html`<p class="small hollow">${of.lost ? "This picture cannot be drawn." : placeholder}</p>`;
  return html`<img src=${of.url} class=${of.coming ? "coming" : ""} alt=${of.words} draggable=${false} />`;
}

/** @param {{name: string, on: boolean}} props */
const Name = ({ name, on }) => html`<span class=${on ? "on" : ""}>${name}</span>`;

/**
 * @param {{id: string, upper: Side, lower: Side, state: PairState, placeholder: string, hint?:
 *   string}} props `upper`: the picture to reproduce, also shown alone; `lower`: the
 *   picture compared with it
 */
export function Pair({ id, upper, lower, state, placeholder, hint }) {
  const seen = state.seen.value;
  const both = upper.url !== null && lower.url !== null;
  const percent = Math.round(100 * seen);
  const hold = flipHandlers(state.key);
  return html`
    <div class="pair" data-testid=${id} aria-busy=${Boolean(upper.coming || lower.coming)}>
      <figure class="square still">
        <div class="paper"><${Picture} of=${upper} placeholder=${placeholder} /></div>
        <figcaption>${upper.name}</figcaption>
      </figure>
      <figure class="square">
        <div class="paper" data-seen=${percent}>
          <${Picture} of=${lower} placeholder=${placeholder} />
          ${both && html`<img class="over" src=${upper.url} alt="" aria-hidden="true" draggable=${false} style=${{ opacity: seen }} />`}
        </div>
        <figcaption class="flips"><${Name} name=${lower.name} on=${both && seen < 1} />${both && html`<${Name} name=${upper.name} on=${seen > 0} />`}</figcaption>
      </figure>
      ${both && html`
        <div class="blend">
          <${Slider} id=${`${id}-blend`} name="blend" value=${Math.round(100 * state.share.value)} min=${0} max=${100} step=${5} shown=${percent === 0 ? lower.name : percent === 100 ? upper.name : `${percent} %`}
            title=${`How much of ${upper.name} lies over ${lower.name}`} onInput=${(/** @type {number} */ to) => {
              state.flipped.value = false;
              state.share.value = to / 100;
            }} />
          <button type="button" class="hold" data-testid=${`${id}-flip`} aria-pressed=${state.flipped.value} title=${`${upper.words} in place of the other: tap to flip, hold to glance (X)`} ...${hold}>Flip</button>
        </div>
        <p class="small says">${hint ?? "Tap Flip or X to change from one to the other; hold it to glance."}</p>
      `}
    </div>
  `;
}
