/**
 * The controls of the panes: a slider with its value, a colour, a switch, a choice. Owns their look and names; what they change is the caller's.
 */
import { html } from "../html.js";

/** @param {Event} event */
const valueOf = (event) => Number(/** @type {HTMLInputElement} */ (event.target).value);
/** @param {Event} event */
const checkedIn = (event) => /** @type {HTMLInputElement} */ (event.target).checked;

/** Keys that move a slider. */
const SLIDES = /^(Arrow|Page|Home|End)/;
/** Id of the slider on which a key is down, and whether it has moved by that key: it rests when the key is let go. */
const byKey = { id: "", moved: false };

/**
 * @param {{id: string, name: string, value: number, min: number, max: number, step: number, shown: string, dim?: boolean,
 *   disabled?: boolean, title?: string, turns: (value: number) => void, rests?: (value: number) => void}} props
 */
export function Slider({ id, name, value, min, max, step, shown, dim, disabled, title, turns, rests }) {
  /** @param {Event} event */
  const change = (event) => {
    if (byKey.id === id) byKey.moved = true;
    else rests?.(valueOf(event));
  };
  /** @param {Event} event */
  const letGo = (event) => {
    const moved = byKey.id === id && byKey.moved;
    Object.assign(byKey, { id: "", moved: false });
    if (moved) rests?.(valueOf(event));
  };
  /** @param {KeyboardEvent} event */
  const press = (event) => {
    if (byKey.id !== id && SLIDES.test(event.key)) Object.assign(byKey, { id, moved: false });
  };
  return html`
    <div class=${dim ? "slider dim" : "slider"} title=${title}>
      <label for=${id}>${name}</label>
      <input type="range" id=${id} data-testid=${id} min=${min} max=${max} step=${step} value=${value} disabled=${disabled} aria-valuetext=${shown}
        onInput=${(/** @type {Event} */ event) => turns(valueOf(event))} onChange=${change} onKeyDown=${press} onKeyUp=${letGo} onBlur=${letGo} />
      <output for=${id}>${shown}</output>
    </div>
  `;
}

/**
 * @param {{id: string, name: string, value: string, disabled?: boolean, turns: (value: string) => void, rests: () => void, children?: unknown}} props
 */
export function Colour({ id, name, value, disabled, turns, rests, children }) {
  return html`
    <div class="slider">
      <label for=${id}>${name}</label>
      <input type="color" id=${id} data-testid=${id} value=${value} disabled=${disabled}
        onInput=${(/** @type {Event} */ event) => turns(/** @type {HTMLInputElement} */ (event.target).value)} onChange=${rests} />
      ${children}
    </div>
  `;
}

/** @param {{id: string, name: string, on: boolean, turns: (on: boolean) => void, title?: string, label?: string}} props `label`: the whole name, where `name` alone says too little */
export function Switch({ id, name, on, turns, title, label }) {
  return html`
    <label class=${on ? "chip on" : "chip"} title=${title}>
      <input type="checkbox" role="switch" data-testid=${id} aria-label=${label} checked=${on} onChange=${(/** @type {Event} */ event) => turns(checkedIn(event))} />
      <span>${name}</span>
    </label>
  `;
}

/**
 * One of a few, all in sight.
 * @param {{id: string, name: string, options: {value: string, name: string, title?: string}[], value: string, turns: (value: string) => void}} props
 */
export function Choice({ id, name, options, value, turns }) {
  return html`
    <div class="choice" role="radiogroup" aria-label=${name} data-testid=${id}>
      ${options.map((option) => html`
        <label key=${option.value} class=${option.value === value ? "chip on" : "chip"} title=${option.title}>
          <input type="radio" name=${id} value=${option.value} checked=${option.value === value} onChange=${() => turns(option.value)} />
          <span>${option.name}</span>
        </label>
      `)}
    </div>
  `;
}
