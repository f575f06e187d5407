/**
 * The controls of the panes: a slider with its value, a colour, a switch. Owns their look and names; what they change is the caller's.
 */
import { html } from "../html.js";

/** @param {Event} event */
const valueOf = (event) => Number(/** @type {HTMLInputElement} */ (event.target).value);
/** @param {Event} event */
const checkedIn = (event) => /** @type {HTMLInputElement} */ (event.target).checked;

/**
 * @param {{id: string, name: string, value: number, min: number, max: number, step: number, shown: string, dim?: boolean,
 *   disabled?: boolean, title?: string, turns: (value: number) => void, rests?: (value: number) => void}} props
 */
export function Slider({ id, name, value, min, max, step, shown, dim, disabled, title, turns, rests }) {
  return html`
    <div class=${dim ? "slider dim" : "slider"} title=${title}>
      <label for=${id}>${name}</label>
      <input type="range" id=${id} data-testid=${id} min=${min} max=${max} step=${step} value=${value} disabled=${disabled} aria-valuetext=${shown}
        onInput=${(/** @type {Event} */ event) => turns(valueOf(event))} onChange=${(/** @type {Event} */ event) => rests?.(valueOf(event))} />
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

/** @param {{id: string, name: string, on: boolean, turns: (on: boolean) => void, title?: string}} props */
export function Switch({ id, name, on, turns, title }) {
  return html`
    <label class=${on ? "chip on" : "chip"} title=${title}>
      <input type="checkbox" role="switch" data-testid=${id} checked=${on} onChange=${(/** @type {Event} */ event) => turns(checkedIn(event))} />
      <span>${name}</span>
    </label>
  `;
}
