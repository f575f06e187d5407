/**
 * A problem told in words where it happened. Owns the wording of lines and columns; what went wrong comes from the state.
 *
 * @import { Place, Problem } from "../types.js"
 */
import { html } from "../html.js";
import { forget, troubles } from "../state.js";

/**
 * @param {Problem} problem
 * @returns {string}
 */
export function inWords(problem) {
  const at = problem.line === undefined ? "" : `Line ${problem.line}${problem.column === undefined ? "" : `, column ${problem.column}`}: `;
  const told = problem.detail || problem.title;
  // Some answers carry the line in their words already.
  return problem.line !== undefined && told.includes(`line ${problem.line}`) ? told : at + told;
}

/** Whether the same request may fare better later; a refused one has to be changed first. @param {number} status */
const mayPass = (status) => status === 0 || status >= 500 || [401, 409, 412, 429].includes(status);

/** A problem told below the edge of a pane would not be read. @param {HTMLElement|null} element */
const inSight = (element) => element?.scrollIntoView({ block: "nearest" });

/** @param {{place: Place}} props */
export function Trouble({ place }) {
  const trouble = troubles.value[place];
  if (!trouble) return null;
  const { problem, retry } = trouble;
  return html`
    <div class="trouble" role="alert" data-testid="error" data-place=${place} ref=${inSight}>
      <p><strong>${problem.title}.</strong> ${inWords(problem)}</p>
      <div class="row">
        ${retry && mayPass(problem.status) && html`<button type="button" onClick=${retry}>Try again</button>`}
        <button type="button" onClick=${() => forget(place)}>Dismiss</button>
      </div>
    </div>
  `;
}
