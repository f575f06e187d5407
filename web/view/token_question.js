/**
 * The question for a token, asked when the server wants one. Owns the dialog and nothing of the token.
 */
import { html } from "../html.js";
import { asking, decline, give, refusal } from "../token.js";
import { modal } from "./dialog.js";
import { inWords } from "./trouble.js";

const opened = modal();

/** @param {Event} event */
function submit(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  void give(String(new FormData(form).get("token") ?? "").trim());
}

export function TokenQuestion() {
  if (!asking.value) return null;
  return html`
    <dialog ref=${opened} aria-labelledby="token-title" onCancel=${decline}>
      <h2 id="token-title">This server asks for a token</h2>
      <p>Whoever runs it makes one with <code>brood token add</code>. It is kept as a cookie of this browser.</p>
      <form class="row" onSubmit=${submit}>
        <input type="password" name="token" aria-label="Token" autocomplete="current-password" required data-testid="token" />
        <button type="submit">Enter</button>
        <button type="button" onClick=${decline}>Cancel</button>
      </form>
      ${refusal.value && html`<div class="trouble" role="alert" data-testid="error"><p><strong>${refusal.value.title}.</strong> ${inWords(refusal.value)}</p></div>`}
    </dialog>
  `;
}
