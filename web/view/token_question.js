/** The dialog that asks for an access token. */
import { signIn } from "../api/session.js";
import { answerTokenQuestion } from "../api/token.js";
import { pageStore } from "../page/store.js";
import { modal } from "./dialog.js";
import { html } from "./html.js";
import { problemText } from "./problem.js";

const opened = modal();

const decline = () => answerTokenQuestion(false);

/** @param {Event} event */
function submit(event) {
  event.preventDefault();
  const form = /** @type {HTMLFormElement} */ (event.target);
  void signIn(String(new FormData(form).get("token") ?? "").trim());
}

export function TokenQuestion() {
  if (!pageStore.tokenAsked.value) return null;
  return html`
    <dialog ref=${opened} aria-labelledby="token-title" onCancel=${decline}>
      <h2 id="token-title">This server asks for a token</h2>
      <p>Its administrator creates tokens with <code>brood token add</code>. The browser keeps the token as a cookie.</p>
      <form class="row" onSubmit=${submit}>
        <input type="password" name="token" aria-label="Token" autocomplete="current-password" required data-testid="token" />
        <button type="submit">Enter</button>
        <button type="button" onClick=${decline}>Cancel</button>
      </form>
      ${pageStore.tokenRefusal.value && html`<div class="trouble" role="alert" data-testid="error"><p><strong>${pageStore.tokenRefusal.value.title}.</strong> ${problemText(pageStore.tokenRefusal.value)}</p></div>`}
    </dialog>
  `;
}
