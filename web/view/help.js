/** The list of keys and gestures, at the key "?". */
import { pageStore } from "../page/store.js";
import { modal, shut } from "./dialog.js";
import { html } from "./html.js";

const opened = modal();

/** By group: keys or gestures, and what they do. @type {[string, [string[], string][]][]} */
const GROUPS = [
  ["On a frame", [
    [["click", "Enter"], "breed from it; with a mate, recombine both"],
    [["right click", "long press", "M"], "mark it as the mate"],
    [["F"], "keep it as a favourite"],
    [["B"], "compare it with the centre, as B"],
    [["I"], "inspect it: code, reflectance, locks, exports"],
    [["arrows", "Home", "End"], "move to another frame"],
  ]],
  ["Object", [
    [["drag the centre", "middle drag", "Alt drag"], "turn it"],
    [["wheel", "Ctrl middle drag", "pinch"], "scale it"],
    [["double click the centre"], "reset rotation, scale and the angle of a resting light"],
  ]],
  ["Anywhere", [
    [["Ctrl Z", "Ctrl Shift Z"], "undo, redo"],
    [["X"], "flip between A and B, or result and target; hold to glance"],
    [["T"], "flip between the centre and the target of a search"],
    [["C"], "compare materials side by side, measured"],
    [["V"], "favourites of all lineages"],
    [["S"], "searches"],
    [["Esc"], "cancel a gesture, the mate, the comparison"],
    [["?"], "this list"],
  ]],
];

/** @param {[string[], string]} row */
const Row = ([keys, what]) => html`
  <tr><th scope="row">${keys.map((key, order) => html`${order > 0 && " or "}<kbd>${key}</kbd>`)}</th><td>${what}</td></tr>
`;

export function Help() {
  if (!pageStore.helpOpen.value) return null;
  return html`
    <dialog class="middling help" ref=${opened} data-testid="help" aria-labelledby="help-title" onClose=${() => (pageStore.helpOpen.value = false)}>
      <h2 id="help-title">Keys and gestures</h2>
      ${GROUPS.map(([name, rows]) => html`
        <h3 key=${name}>${name}</h3>
        <table><tbody>${rows.map(Row)}</tbody></table>
      `)}
      <div class="row end"><button type="button" data-testid="help-close" onClick=${shut}>Close</button></div>
    </dialog>
  `;
}
