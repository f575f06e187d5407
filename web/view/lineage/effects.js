/**
 * Tables of the effects of a painted genome: each parameter with its value, its colours and its
 * lock.
 *
 * @import { Effect, Parameter } from "../../model.js"
 */
import { codesOf, plainName } from "../../lineage/layers.js";
import { hasEffectParameter, toggleEffect, toggleEffectParameter } from "../../lineage/locks.js";
import { lineageStore } from "../../lineage/store.js";
import { amount } from "../../page/format.js";
import { html } from "../html.js";
import { Lock } from "./locks.js";

/** Swatches of colours, or the value in words. @param {{of: Parameter}} props */
function Value({ of }) {
  const codes = codesOf(of);
  if (codes.length === 0) return typeof of.value === "string" ? of.value : of.value.map((one) => amount(one)).join(" ");
  return codes.map((code, at) => html`<span key=${at} class="swatch" role="img" aria-label=${code} title=${code} style=${{ background: code }}></span>`);
}

/** @param {{of: Parameter, effect: string}} props */
function Row({ of, effect }) {
  const locks = lineageStore.locks.value;
  const name = plainName(of.name);
  const title = typeof of.value === "string" ? of.value : of.value.join(" ");
  return html`
    <tr data-parameter=${of.name}>
      <td><${Lock} name=${`${name} of ${effect}`} on=${hasEffectParameter(locks, effect, of.name)} held=${locks.effects.includes(effect) ? "its effect is locked" : ""} onClick=${() => toggleEffectParameter(effect, of.name)} /></td>
      <th scope="row">${name}</th>
      <td class="value" title=${title}><${Value} of=${of} /></td>
    </tr>
  `;
}

/** @param {{of: Effect}} props */
const Table = ({ of: { effect, parameters } }) => html`
  <table class="layer" data-effect=${effect}>
    <caption><span>
      <${Lock} name=${effect} on=${lineageStore.locks.value.effects.includes(effect)} held="" onClick=${() => toggleEffect(effect)} />
      <span>${effect}</span>
    </span></caption>
    <tbody>${parameters.map((one) => html`<${Row} key=${one.name} of=${one} effect=${effect} />`)}</tbody>
  </table>
`;

/** @param {{of: Effect[]}} props */
export const Effects = ({ of }) => html`
  <div class="layers" data-testid="effects">${of.map((one) => html`<${Table} key=${one.effect} of=${one} />`)}</div>
`;
