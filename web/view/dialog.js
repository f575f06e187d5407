/** Modal dialogs: title, opening, closing, and the focus before and after. */
import { html } from "./html.js";

/**
 * A ref that opens a dialog when it appears, and returns the focus when it disappears.
 * @param {() => void} [begin] called each time it opens
 * @returns {(dialog: HTMLDialogElement|null) => void}
 */
export function modal(begin = () => {}) {
  /** @type {Element|null} */
  let from = null;
  return (dialog) => {
    if (dialog?.open) return;
    if (dialog) {
      from = document.activeElement;
      dialog.showModal();
      begin();
      return;
    }
    const back = from;
    from = null;
    // Deferred until the dialog is gone: nothing below it takes the focus before. A dialog that was
    // closed has returned the focus already.
    queueMicrotask(() => {
      if (
        document.activeElement === document.body &&
        back instanceof HTMLElement &&
        back.isConnected
      )
        back.focus();
    });
  };
}

/** Closes the dialog that a button is in. @param {Event} event */
export const shut = (event) =>
  event.target instanceof Element && event.target.closest("dialog")?.close();

/**
 * Title of a dialog beside the button that closes it.
 * @param {{name: string, title: string, labelId: string}} properties `name`: start of the button's
 *   test id; `labelId`: id of the heading, which labels the dialog
 */
export const DialogTitle = ({ name, title, labelId }) => html`
  <div class="row title">
    <h2 id=${labelId}>${title}</h2>
    <span class="grow"></span>
    <button type="button" data-testid=${`${name}-close`} onClick=${shut}>Close</button>
  </div>
`;
