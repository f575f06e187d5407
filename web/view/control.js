/** Controls of the panes (slider, colour, switch, choice), and parts that components share. */
import { html } from "./html.js";

/** @param {Event} event */
const valueOf = (event) => Number(/** @type {HTMLInputElement} */ (event.target).value);
/** @param {Event} event */
const checkedIn = (event) => /** @type {HTMLInputElement} */ (event.target).checked;

/** Keys that move a slider. */
const SLIDES = /^(Arrow|Page|Home|End)/;
/**
 * Id of the slider on which a key is down, and true once the key has moved it: releasing the key
 * commits.
 */
const byKey = { id: "", moved: false };

/**
 * @param {{id: string, name: string, value: number, min: number, max: number, step: number,
 *   shown: string, dim?: boolean, disabled?: boolean, title?: string, onInput: (value: number) =>
 *   void, onCommit?: (value: number) => void}} props
 */
export function Slider({ id, name, value, min, max, step, shown, dim, disabled, title, onInput, onCommit }) {
  /** @param {Event} event */
  const change = (event) => {
    if (byKey.id === id) byKey.moved = true;
    else onCommit?.(valueOf(event));
  };
  /** @param {Event} event */
  const release = (event) => {
    const moved = byKey.id === id && byKey.moved;
    Object.assign(byKey, { id: "", moved: false });
    if (moved) onCommit?.(valueOf(event));
  };
  /** @param {KeyboardEvent} event */
  const press = (event) => {
    if (byKey.id !== id && SLIDES.test(event.key)) Object.assign(byKey, { id, moved: false });
  };
  return html`
    <div class=${dim ? "slider dim" : "slider"} title=${title}>
      <label for=${id}>${name}</label>
      <input type="range" id=${id} data-testid=${id} min=${min} max=${max} step=${step} value=${value} disabled=${disabled} aria-valuetext=${shown}
        onInput=${(/** @type {Event} */ event) => onInput(valueOf(event))} onChange=${change} onKeyDown=${press} onKeyUp=${release} onBlur=${release} />
      <output for=${id}>${shown}</output>
    </div>
  `;
}

/**
 * @param {{id: string, name: string, value: string, disabled?: boolean, onInput: (value: string)
 *   => void, onCommit: () => void, children?: unknown}} props
 */
export function Colour({ id, name, value, disabled, onInput, onCommit, children }) {
  return html`
    <div class="slider">
      <label for=${id}>${name}</label>
      <input type="color" id=${id} data-testid=${id} value=${value} disabled=${disabled}
        onInput=${(/** @type {Event} */ event) => onInput(/** @type {HTMLInputElement} */ (event.target).value)} onChange=${onCommit} />
      ${children}
    </div>
  `;
}

/**
 * @param {{id: string, name: string, on: boolean, onInput: (on: boolean) => void, title?: string,
 *   label?: string, disabled?: boolean}} props `label`: the whole name, where `name` alone says too
 *   little
 */
export function Switch({ id, name, on, onInput, title, label, disabled }) {
  return html`
    <label class=${`chip ${on ? "on" : ""} ${disabled ? "disabled" : ""}`} title=${title}>
      <input type="checkbox" role="switch" data-testid=${id} aria-label=${label} checked=${on} disabled=${disabled} onChange=${(/** @type {Event} */ event) => onInput(checkedIn(event))} />
      <span>${name}</span>
    </label>
  `;
}

/**
 * One of a few options, all visible.
 * @param {{id: string, name: string, options: {value: string, name: string, title?: string}[],
 *   value: string, onInput: (value: string) => void}} props
 */
export function Choice({ id, name, options, value, onInput }) {
  return html`
    <div class="choice" role="radiogroup" aria-label=${name} data-testid=${id}>
      ${options.map((option) => html`
        <label key=${option.value} class=${option.value === value ? "chip on" : "chip"} title=${option.title}>
          <input type="radio" name=${id} value=${option.value} checked=${option.value === value} onChange=${() => onInput(option.value)} />
          <span>${option.name}</span>
        </label>
      `)}
    </div>
  `;
}

/** A fact in a list of facts. @param {{name: string, value: unknown, title?: string}} props */
export const Fact = ({ name, value, title }) => html`<div title=${title}><dt>${name}</dt><dd>${value}</dd></div>`;

/** Text of a field. @param {Event} event */
export const typed = (event) => /** @type {HTMLInputElement} */ (event.target).value;
