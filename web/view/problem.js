/**
 * A problem in words, at the place where it happened.
 *
 * @import { Place, Problem } from "../model.js"
 */
import { clearProblems } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { html } from "./html.js";

/**
 * @param {Problem} problem
 * @returns {string}
 */
export function problemText(problem) {
  const { line, column } = problem;
  const text = problem.detail || problem.title;
  // Some answers name the line in their text already.
  if (typeof line !== "number" || text.includes(`line ${line}`)) return text;
  return `Line ${line}${typeof column === "number" ? `, column ${column}` : ""}: ${text}`;
}

/**
 * True if the same request may succeed later; a refused one has to be changed first.
 * @param {number} status
 */
const mayRetry = (status) => status === 0 || status >= 500 || [401, 409, 412, 429].includes(status);

/**
 * Scrolls to a problem that is outside of its pane's visible part.
 * @param {HTMLElement|null} element
 */
const scrollToProblem = (element) => element?.scrollIntoView({ block: "nearest" });

/** @param {{place: Place}} props */
export function ProblemBox({ place }) {
  const shown = pageStore.problems.value[place];
  if (!shown) return null;
  const { problem, retry } = shown;
  return html`
    <div class="trouble" role="alert" data-testid="error" data-place=${place} ref=${scrollToProblem}>
      <p><strong>${problem.title}.</strong> ${problemText(problem)}</p>
      <div class="row">
        ${retry && mayRetry(problem.status) && html`<button type="button" onClick=${retry}>Try again</button>`}
        <button type="button" onClick=${() => clearProblems(place)}>Dismiss</button>
      </div>
    </div>
  `;
}
