/**
 * The controls of the panes: a slider with its value, a switch. Owns their look and names; what they change is the caller's.
 */
import { html } from "../html.js";

/** @param {Event} event */
const valueOf = (event) => Number(/** @type {HTMLInputElement} */ (event.target).value);
/** @param {Event} event */
const checkedIn = (event) => /** @type {HTMLInputElement} */ (event.target).checked;

/**
 * @param {{id: string, name: string, value: number, min: number, max: number, step: number, shown: string, dim?: boolean,
 *   turns: (value: number) => void, rests?: (value: number) => void}} props
 */
export function Slider({ id, name, value, min, max, step, shown, dim, turns, rests }) {
  return html`
    <div class=${dim ? "slider dim" : "slider"}>
      <label for=${id}>${name}</label>
      <input type="range" id=${id} data-testid=${id} min=${min} max=${max} step=${step} value=${value} aria-valuetext=${shown}
        onInput=${(/** @type {Event} */ event) => turns(valueOf(event))} onChange=${(/** @type {Event} */ event) => rests?.(valueOf(event))} />
      <output for=${id}>${shown}</output>
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
