/**
 * Tables of the effects of a painted genome: each parameter with its value, its colours and its
 * lock, and each image with its share.
 *
 * @import { Effect, EffectImage, Parameter } from "../../model.js"
 */
import { imageName, percent, placeInWords } from "../../lineage/images.js";
import { codesOf, plainName } from "../../lineage/layers.js";
import { hasEffectParameter, toggleEffect, toggleEffectParameter } from "../../lineage/locks.js";
import { lineageStore } from "../../lineage/store.js";
import { amount } from "../../page/format.js";
import { html } from "../html.js";
import { Thumbnail } from "./images.js";
import { Lock } from "./locks.js";

/** Swatches of colours, or the value in words. @param {{of: Parameter}} props */
function Value({ of }) {
  const codes = codesOf(of);
  if (codes.length === 0) return typeof of.value === "string" ? of.value : of.value.map((one) => amount(one)).join(" ");
  return codes.map((code, at) => html`<span key=${at} class="swatch" role="img" aria-label=${code} title=${code} style=${{ background: code }}></span>`);
}

/**
 * Lock of a part of an effect.
 * @param {{part: string, name: string, effect: string}} props `part`: name in the genome; `name`:
 *   in words
 */
function PartLock({ part, name, effect }) {
  const locks = lineageStore.locks.value;
  const held = locks.effects.includes(effect) ? "its effect is locked" : "";
  return html`
    <${Lock} name=${`${name} of ${effect}`} on=${hasEffectParameter(locks, effect, part)} held=${held}
      onClick=${() => toggleEffectParameter(effect, part)} />
  `;
}

/** @param {{of: Parameter, effect: string}} props */
function Row({ of, effect }) {
  const name = plainName(of.name);
  const title = typeof of.value === "string" ? of.value : of.value.join(" ");
  return html`
    <tr data-parameter=${of.name}>
      <td><${PartLock} part=${of.name} name=${name} effect=${effect} /></td>
      <th scope="row">${name}</th>
      <td class="value" title=${title}><${Value} of=${of} /></td>
    </tr>
  `;
}

/** @param {{of: EffectImage, effect: string}} props */
function ImageRow({ of, effect }) {
  const name = imageName(of.name);
  return html`
    <tr data-image=${of.name}>
      <td><${PartLock} part=${of.name} name=${name} effect=${effect} /></td>
      <th scope="row">${name}</th>
      <td class="value" title=${`share ${of.share}`}>
        <${Thumbnail} image=${of.image} name=${placeInWords({ effect, name: of.name })} /> ${percent(of.share)}
      </td>
    </tr>
  `;
}

/** @param {{of: Effect}} props */
const Table = ({ of: { effect, parameters, images } }) => html`
  <table class="layer" data-effect=${effect}>
    <caption><span>
      <${Lock} name=${effect} on=${lineageStore.locks.value.effects.includes(effect)} held="" onClick=${() => toggleEffect(effect)} />
      <span>${effect}</span>
    </span></caption>
    <tbody>
      ${images.map((one) => html`<${ImageRow} key=${`image ${one.name}`} of=${one} effect=${effect} />`)}
      ${parameters.map((one) => html`<${Row} key=${one.name} of=${one} effect=${effect} />`)}
    </tbody>
  </table>
`;

/** @param {{of: Effect[]}} props */
export const Effects = ({ of }) => html`
  <div class="layers" data-testid="effects">${of.map((one) => html`<${Table} key=${one.effect} of=${one} />`)}</div>
`;
