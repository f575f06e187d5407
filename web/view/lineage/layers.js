/**
 * Tables of a genome's models: each parameter with its value, its colour and its lock.
 *
 * @import { Layer, Parameter } from "../../model.js"
 */
import { colorOf, parameterKeptBy, plainName } from "../../lineage/layers.js";
import { hasParameter, toggleLock, toggleParameter } from "../../lineage/locks.js";
import { lineageStore } from "../../lineage/store.js";
import { amount } from "../../page/format.js";
import { html } from "../html.js";
import { Lock } from "./locks.js";

/** A value in words, three digits per number. @param {Parameter} of */
const valueInWords = ({ value }) => (typeof value === "string" ? value : value.map((one) => amount(one)).join(" "));

/** @param {{of: Parameter}} props */
function Swatch({ of }) {
  const color = colorOf(of);
  return color && html`<span class="swatch" style=${{ background: color }}></span>`;
}

/** @param {{of: Parameter, at: number, lockable: boolean}} props */
function Row({ of, at, lockable }) {
  const on = lockable && hasParameter(lineageStore.locks.value, at, of.name);
  const name = plainName(of.name);
  return html`
    <tr data-parameter=${of.name}>
      ${lockable && html`<td><${Lock} name=${`${name} of model ${at + 1}`} on=${on} held=${parameterKeptBy(lineageStore.locks.value, at, of)} onClick=${() => toggleParameter(at, of.name)} /></td>`}
      <th scope="row">${name}</th>
      <td class="value" title=${typeof of.value === "string" ? undefined : of.value.join(" ")}><${Swatch} of=${of} />${valueInWords(of)}</td>
    </tr>
  `;
}

/** @param {{of: Layer, at: number, lockable: boolean}} props */
const Table = ({ of, at, lockable }) => html`
  <table class="layer" data-layer=${at}>
    <caption><span>
      ${lockable && html`<${Lock} name=${`model ${at + 1}, ${of.model}`} on=${lineageStore.locks.value.layers.includes(at)} held="" onClick=${() => toggleLock("layers", at)} />`}
      <span>${of.model}</span>
    </span></caption>
    <tbody>${of.parameters.map((one) => html`<${Row} key=${one.name} of=${one} at=${at} lockable=${lockable} />`)}</tbody>
  </table>
`;

/** @param {{of: Layer[], lockable: boolean}} props */
export const Layers = ({ of, lockable }) => html`
  <div class="layers" data-testid="layers">${of.map((one, at) => html`<${Table} key=${at} of=${one} at=${at} lockable=${lockable} />`)}</div>
`;
