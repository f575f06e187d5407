/**
 * Dialogs that keep hands and keys from what lies below them. Owns how one opens, is shut, and gives the focus back; knows
 * nothing of what is in it.
 */

/**
 * A ref that opens a dialog, and gives the focus back to where it was, however the dialog goes.
 * @param {() => void} [begin] done each time it opens
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
    // Once the dialog is gone: until then nothing below it takes the focus. One that was shut has given it back by itself.
    queueMicrotask(() => {
      if (document.activeElement === document.body && back instanceof HTMLElement && back.isConnected) back.focus();
    });
  };
}

/** Shuts the dialog that a button is in. @param {Event} event */
export const shut = (event) => event.target instanceof Element && event.target.closest("dialog")?.close();
