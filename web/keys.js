/**
 * The keyboard: moving over the frames, and the same deeds as by hand. Owns which key does what; knows nothing of drawing
 * beyond the frame that is to have the focus.
 *
 * @import { Cell } from "./types.js"
 */
import { nameOf, pick, toggleFavourite, toggleMate } from "./breed.js";
import { keyOfB, pinCell, pinned, targetSeen, unpin } from "./compare.js";
import { openComparison } from "./comparison.js";
import { cellOf, letGo } from "./hands.js";
import { inspectCell } from "./inspector.js";
import { redo, undo } from "./lineage.js";
import { besideFound, understood } from "./pair.js";
import { NEW, looking, openSearches } from "./searches.js";
import { keyOfTarget, showTarget, sought } from "./sought.js";
import { focused } from "./state.js";

/** Row and column of the frames by slot: row by row around the 4 x 4 centre. */
export const PLACES = [...Array(36).keys()]
  .map((at) => /** @type {[number, number]} */ ([Math.floor(at / 6), at % 6]))
  .filter(([row, column]) => row % 5 === 0 || column % 5 === 0);

/** Where the cursor entered the centre, so that leaving it goes straight on. @type {[number, number]} */
let cursor = [1, 1];

/** @type {Record<string, [number, number]>} */
const STEPS = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

/**
 * The neighbour of a cell; the cell itself at the rim.
 * @param {Cell} from
 * @param {[number, number]} by rows and columns
 * @returns {Cell}
 */
export function neighbour(from, [rows, columns]) {
  let [row, column] = from === "centre" ? cursor : PLACES[from];
  do {
    row += rows;
    column += columns;
  } while (from === "centre" && inCentre(row, column));
  if (row < 0 || row > 5 || column < 0 || column > 5) return from;
  cursor = [row, column];
  return inCentre(row, column) ? "centre" : PLACES.findIndex((place) => place[0] === row && place[1] === column);
}

/** @param {number} row @param {number} column */
const inCentre = (row, column) => row > 0 && row < 5 && column > 0 && column < 5;

/** @param {Cell} cell */
function focus(cell) {
  focused.value = cell;
  const found = document.querySelector(`[data-cell="${cell}"]`);
  if (found instanceof HTMLElement) found.focus();
}

/** Whether it is this letter and nothing else. @param {KeyboardEvent} event @param {string} letter */
export const isPlain = (event, letter) => event.key.toLowerCase() === letter && !event.ctrlKey && !event.metaKey && !event.altKey;

/** @param {KeyboardEvent} event */
export function keyOnFrames(event) {
  const cell = cellOf(event.target);
  const inside = event.target instanceof HTMLElement && event.target.dataset.cell === undefined;
  if (cell === null || inside || event.ctrlKey || event.metaKey || event.altKey) return;
  const step = STEPS[event.key];
  if (step) focus(neighbour(cell, step));
  else if (event.key === "Home") focus(0);
  else if (event.key === "End") focus(19);
  // A key that is held down moves on, and does nothing else twice.
  else if (event.repeat) return event.preventDefault();
  else if (event.key === "Enter" || event.key === " ") void pick(cell);
  else if (event.key.toLowerCase() === "m") toggleMate(cell);
  else if (event.key.toLowerCase() === "f") void toggleFavourite(cell);
  else if (event.key.toLowerCase() === "b") pinCell(cell, nameOf(cell));
  else if (event.key.toLowerCase() === "i") inspectCell(cell, nameOf(cell));
  else return;
  event.preventDefault();
}

/** Whether letters go into a field. @param {EventTarget|null} target */
const takesText = (target) =>
  target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && ["text", "password"].includes(target.type));

/** The dialog that a key is pressed in; the open one where nothing has the focus. @param {EventTarget|null} target */
const dialogOf = (target) => (target instanceof Element ? (target.closest("dialog") ?? document.querySelector("dialog[open]")) : null);

/** What lies below a dialog does not change unseen. @param {EventTarget|null} target */
const inDialog = (target) => dialogOf(target) !== null;

/** What a key that is down flips. @type {{key: string, of: {down: (now: number) => void, up: (now: number) => void}}|null} */
let held = null;

/** What a letter flips between two pictures where the hand is. @param {KeyboardEvent} event */
function flipsBy(event) {
  const over = dialogOf(event.target);
  if (isPlain(event, "x") && over?.classList.contains("searches")) return looking.value === NEW ? understood.key : besideFound.key;
  if (over) return null;
  if (isPlain(event, "x") && pinned.value) return keyOfB;
  return isPlain(event, "t") && sought.value ? keyOfTarget : null;
}

/** @param {KeyboardEvent} event */
function keyAlone(event) {
  if (isPlain(event, "c") && !event.repeat && !inDialog(event.target) && !takesText(event.target)) {
    openComparison();
    event.preventDefault();
  }
  if (isPlain(event, "s") && !event.repeat && !inDialog(event.target) && !takesText(event.target)) {
    openSearches();
    event.preventDefault();
  }
  if (event.key === "Escape" && !inDialog(event.target) && !letGo()) {
    if (targetSeen.value) showTarget(false);
    else unpin();
  }
  if (event.repeat || takesText(event.target)) return;
  const of = flipsBy(event);
  if (!of) return;
  held = { key: event.key.toLowerCase(), of };
  of.down(event.timeStamp);
  event.preventDefault();
}

/** @param {KeyboardEvent} event */
export function keyUpAnywhere(event) {
  if (event.key.toLowerCase() !== held?.key) return;
  held.of.up(event.timeStamp);
  held = null;
}

/** @param {KeyboardEvent} event */
export function keyAnywhere(event) {
  if (!(event.ctrlKey || event.metaKey)) return keyAlone(event);
  if (takesText(event.target) && !(event.target instanceof HTMLSelectElement)) return;
  if (inDialog(event.target)) return;
  // By where the key is, where letters are not Latin.
  const key = /^[a-z]$/i.test(event.key) ? event.key.toLowerCase() : event.code.replace("Key", "").toLowerCase();
  if (event.repeat && (key === "z" || key === "y")) return event.preventDefault();
  if (key === "z") void (event.shiftKey ? redo() : undo());
  else if (key === "y") void redo();
  else return;
  event.preventDefault();
}
