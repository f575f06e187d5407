/**
 * Controls for the parameters of the centre's models: sliders with number fields, colours, choices.
 *
 * @import { Edit, Layer, Parameter, ParameterInfo } from "../../model.js"
 */
import {
  CHANNEL_NAMES, chooseWord, fieldKey, leaveField, makeChild, pickColor, presentEdit, resetEdit,
  slideValue, toggleEditing, typeValue,
} from "../../lineage/edit.js";
import { plainName } from "../../lineage/layers.js";
import {
  isPicked, pickerColor, positionOf, shownChannel, shownValue,
} from "../../lineage/parameters.js";
import { lineageStore } from "../../lineage/store.js";
import { typed } from "../control.js";
import { html } from "../html.js";
import { ProblemBox } from "../problem.js";

/** Step of a slider: 200 from end to end. */
const STEP = 0.005;

/** Description of a parameter with its range and unit. @param {ParameterInfo} of */
const aboutOf = ({ about, range: [low, high], unit, kind }) => kind === "choice" ? about : `${about}; ${low} to ${high}${unit && ` ${unit}`}`;

/**
 * @typedef {{edit: Edit, of: ParameterInfo, layer: number, channel: number, value: number, name:
 *   string}} NumberProps `name`: for screen readers and messages
 */

/** Text field of a number. @param {NumberProps} props */
function Field({ edit, of, layer, channel, value, name }) {
  const key = fieldKey(layer, of.name, channel);
  const wrong = edit.wrong.has(key);
  const leave = () => leaveField(of, layer, channel, name);
  return html`
    <input type="text" inputmode="decimal" autocomplete="off" data-testid=${`field-${key}`} aria-label=${name} aria-invalid=${wrong ? "true" : undefined} aria-describedby=${wrong ? `wrong-${key}` : undefined}
      value=${edit.typed.get(key) ?? (isPicked(of) ? shownChannel : shownValue)(value)} title=${value}
      onInput=${(/** @type {Event} */ event) => typeValue(of, layer, channel, typed(event))} onBlur=${leave} onKeyDown=${(/** @type {KeyboardEvent} */ event) => event.key === "Enter" && leave()} />
  `;
}

/** Slider of a number. @param {NumberProps} props */
function Slide({ of, layer, channel, value, name }) {
  return html`
    <input type="range" data-testid=${`slide-${fieldKey(layer, of.name, channel)}`} aria-label=${`${name}, slider`} min="0" max="1" step=${STEP}
      value=${positionOf(of, value)} aria-valuetext=${`${shownValue(value)}${of.unit && ` ${of.unit}`}`}
      onInput=${(/** @type {Event} */ event) => slideValue(of, layer, channel, Number(typed(event)))} />
  `;
}

/** Reasons why texts of a parameter are not valid. @param {{edit: Edit, keys: string[]}} props */
const Wrong = ({ edit, keys }) => keys.flatMap((key) => {
  const words = edit.wrong.get(key);
  return words ? [html`<p key=${key} id=${`wrong-${key}`} class="wrong" role="alert" data-testid=${`wrong-${key}`}>${words}</p>`] : [];
});

/**
 * Name of a parameter or of one of its channels.
 * @param {string} name
 * @param {number} channel
 * @param {number} count
 */
const channelName = (name, channel, count) => count === 1 ? plainName(name) : `${CHANNEL_NAMES[channel]} of ${plainName(name)}`;

/** @param {{edit: Edit, of: ParameterInfo, layer: number, now: Parameter}} props */
function Control({ edit, of, layer, now: { value } }) {
  const title = aboutOf(of);
  const name = plainName(of.name);
  if (typeof value === "string") {
    return html`
      <span class="name" title=${title}>${name}</span>
      <select data-testid=${`choice-${fieldKey(layer, of.name, 0)}`} aria-label=${name} onChange=${(/** @type {Event} */ event) => chooseWord(of, layer, typed(event))}>
        ${of.words.map((word) => html`<option key=${word} value=${word} selected=${word === value}>${word}</option>`)}
      </select>
    `;
  }
  const props = value.map((one, channel) => ({ edit, of, layer, channel, value: one, name: channelName(of.name, channel, value.length) }));
  if (value.length === 1) return html`<span class="name" title=${title}>${name}</span><${Slide} ...${props[0]} /><${Field} ...${props[0]} />`;
  if (isPicked(of)) {
    return html`
      <span class="name" title=${title}>${name}</span>
      <span class="channels">
        <input type="color" data-testid=${`color-${fieldKey(layer, of.name, 0)}`} aria-label=${`${name}, colour`} value=${pickerColor(value)} onInput=${(/** @type {Event} */ event) => pickColor(of, layer, typed(event))} />
        ${props.map((one) => html`<${Field} key=${one.channel} ...${one} />`)}
      </span>
    `;
  }
  return html`
    <span class="name alone" title=${title}>${name}</span>
    ${props.map((one) => html`<span class="name channel" key=${`n${one.channel}`}>${CHANNEL_NAMES[one.channel]}</span><${Slide} key=${`s${one.channel}`} ...${one} /><${Field} key=${`f${one.channel}`} ...${one} />`)}
  `;
}

/** @param {{edit: Edit, of: Layer, at: number}} props */
function Model({ edit, of, at }) {
  const known = lineageStore.models.value.get(of.model);
  return html`
    <fieldset data-layer=${at}>
      <legend title=${known?.about}>${of.model}<span class="unseen">, model ${at + 1}</span></legend>
      ${of.parameters.map((now) => {
        const info = known?.parameters.find((one) => one.name === now.name);
        const keys = CHANNEL_NAMES.map((_, channel) => fieldKey(at, now.name, channel));
        return info && html`<div class="parameter" key=${now.name} data-parameter=${now.name}><${Control} edit=${edit} of=${info} layer=${at} now=${now} /><${Wrong} edit=${edit} keys=${keys} /></div>`;
      })}
    </fieldset>
  `;
}

/** Controls of the centre's models; nothing until its genome is read. */
export function Editor() {
  const edit = presentEdit();
  return edit && html`<div class="editor" data-testid="editor">${edit.layers.map((of, at) => html`<${Model} key=${at} edit=${edit} of=${of} at=${at} />`)}</div>`;
}

/** Buttons that begin and end an edit. */
export function EditButtons() {
  const edit = presentEdit();
  const isChanged = lineageStore.draft.value !== null || (edit?.wrong.size ?? 0) > 0;
  const rest = isChanged ? undefined : "true";
  return html`
    <div class=${edit ? "row edit-buttons on" : "row edit-buttons"}>
      <button type="button" key="toggle" data-testid="edit" aria-expanded=${lineageStore.editing.value} title="Sliders, colours and numbers for the parameters of the models" onClick=${toggleEditing}>${lineageStore.editing.value ? "Close" : "Edit the parameters"}</button>
      ${edit && html`
        <button type="button" key="reset" data-testid="edit-reset" aria-disabled=${rest} title="Brings the stored parameters back" onClick=${() => isChanged && resetEdit()}>Reset</button>
        <button type="button" key="child" class=${isChanged ? "on" : ""} data-testid="edit-child" aria-disabled=${rest} title="Stores the edited material as a child of this one" onClick=${() => isChanged && makeChild()}>Make a child</button>
      `}
    </div>
    <${ProblemBox} place="edit" />
  `;
}
