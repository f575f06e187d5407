/**
 * Listing of a genome: head, models, constants, instructions, each with its lock; or its scalar
 * code.
 *
 * @import { Channel, Inspection, Locks } from "../../model.js"
 * @import { Constant, Instruction, Listing } from "../../lineage/listing.js"
 */
import { channelsKeeping, constantsKept, listingOf, readConstants } from "../../lineage/listing.js";
import { CHANNELS, CHANNEL_WORDS, toggleLock } from "../../lineage/locks.js";
import { lineageStore, noLocks } from "../../lineage/store.js";
import { showProblem } from "../../page/problem.js";
import { pageStore } from "../../page/store.js";
import { Choice, Switch } from "../control.js";
import { html } from "../html.js";
import { viewStore } from "../store.js";
import { Layers } from "./layers.js";
import { ChannelLocks, Lock, LockCount } from "./locks.js";

/** @param {string} text */
async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    viewStore.codeCopied.value = true;
    pageStore.announcement.value = "Code copied.";
    setTimeout(() => (viewStore.codeCopied.value = false), 2000);
  } catch {
    showProblem("inspector", { problem: { title: "Nothing was copied", status: 400, detail: "Browsers allow no clipboard without HTTPS; Export saves the text as .brood." } });
  }
}

/** @param {Iterable<Channel>} channels */
const heldInWords = (channels) => [...channels].map((channel) => CHANNEL_WORDS[channel]).join(", ");

/**
 * Text that breaks between words only; browsers would break it after a minus too.
 * @param {{text: string}} props
 */
const Text = ({ text }) => html`<code>${text.includes("-") ? text.split(" ").map((word, at) => [at > 0 && " ", html`<span class="whole">${word}</span>`]) : text}</code>`;

/** Channels that depend on an instruction. @param {{channels: string}} props */
const Channels = ({ channels }) => html`
  <span class="channels">${CHANNELS.filter((one) => channels.includes(one)).map((one) => html`<abbr key=${one} class=${one} title=${`${CHANNEL_WORDS[one]} depends on this instruction`}>${one}</abbr>`)}</span>
`;

/** @param {{of: Constant, dead: boolean, held: string, lockable: boolean}} props */
const ConstantLine = ({ of, dead, held, lockable }) => html`
  <li class=${dead ? "dead" : ""} data-constant=${of.index}>
    ${lockable && html`<${Lock} name=${`constant ${of.index}`} on=${lineageStore.locks.value.constants.includes(of.index)} held=${held} onClick=${() => toggleLock("constants", of.index)} />`}
    <span class="index">C${of.index}</span><${Text} text=${of.text} />
  </li>
`;

/** @param {{of: Instruction, held: string, lockable: boolean}} props */
const InstructionLine = ({ of, held, lockable }) => html`
  <li class=${of.live ? "" : "dead"} data-instruction=${of.index}>
    ${lockable && html`<${Lock} name=${`instruction ${of.index}`} on=${lineageStore.locks.value.instructions.includes(of.index)} held=${held} onClick=${() => toggleLock("instructions", of.index)} />`}
    <span class="index">${of.index}</span><${Text} text=${of.text} /><${Channels} channels=${of.channels} />
  </li>
`;

/** @param {{of: Inspection, lockable: boolean}} props */
function Assembly({ of, lockable }) {
  const listing = listingOf(of);
  const kept = lockable ? lineageStore.locks.value : noLocks();
  const read = readConstants(listing);
  const held = constantsKept(listing, kept);
  // Locked instructions are always listed, so that they can be unlocked.
  const constants = listing.constants.filter((one) => read.has(one.index) || kept.constants.includes(one.index));
  const instructions = listing.instructions.filter((one) => !lineageStore.liveOnly.value || one.live || kept.instructions.includes(one.index));
  return html`
    <ul class="lines head">${listing.head.map((line) => html`<li><code>${line}</code></li>`)}</ul>
    ${listing.layers.length > 0 && listing.instructions.length > 0 && html`<h4>Models, added to the program</h4>`}
    ${listing.layers.length > 0 && html`<${Layers} of=${listing.layers} lockable=${lockable} />`}
    ${constants.length > 0 && html`<h4>Constants that live code reads</h4>`}
    <ul class="lines">${constants.map((one) => html`<${ConstantLine} key=${one.index} of=${one} dead=${!read.has(one.index)} lockable=${lockable} held=${heldInWords(held.get(one.index) ?? [])} />`)}</ul>
    ${listing.instructions.length > 0 && html`<h4>Instructions</h4>`}
    <ul class="lines">${instructions.map((one) => html`<${InstructionLine} key=${one.index} of=${one} lockable=${lockable} held=${heldInWords(channelsKeeping(one, kept))} />`)}</ul>
  `;
}

/** @param {{of: Inspection, lockable: boolean}} props */
export function Code({ of, lockable }) {
  const modelsOnly = of.counts.instructions === 0;
  const assembly = modelsOnly || lineageStore.codeKind.value === "assembly";
  return html`
    <section class="code" aria-labelledby="code-title">
      <div class="row tools">
        <h3 id="code-title" class=${modelsOnly ? "grow" : "unseen"}>${modelsOnly ? "Models" : "Code"}</h3>
        ${!modelsOnly && html`<${Choice} id="code-kind" name="Code" value=${lineageStore.codeKind.value} options=${[{ value: "assembly", name: "assembly" }, { value: "scalar", name: "scalar code", title: "The operations that run for each sample" }]}
          onInput=${(/** @type {any} */ to) => (lineageStore.codeKind.value = to)} />`}
        ${assembly && !modelsOnly && html`<${Switch} id="live-only" name="live code only" on=${lineageStore.liveOnly.value} title="Leaves out instructions that cannot change the result" onInput=${(/** @type {boolean} */ on) => (lineageStore.liveOnly.value = on)} />`}
        <button type="button" data-testid="copy-code" title=${assembly ? "Copies the whole genome" : "Copies the scalar code"} onClick=${() => copy(assembly ? of.source : of.code)}>${viewStore.codeCopied.value ? "Copied" : "Copy"}</button>
      </div>
      ${assembly && lockable && html`<div class="row tools"><span class="small">lock</span><${ChannelLocks} prefix="inspector-lock" /><${LockCount} prefix="inspector-locks" /></div>`}
      ${assembly && !lockable && html`<p class="small">This genome is of another lineage, so its parts cannot be locked here.</p>`}
      <div class="listing" data-testid="listing" role="region" aria-label=${modelsOnly ? "Parameters" : assembly ? "Assembly" : "Scalar code"} tabindex="0">
        ${assembly ? html`<${Assembly} of=${of} lockable=${lockable} />` : html`<pre>${of.code}</pre>`}
      </div>
    </section>
  `;
}
