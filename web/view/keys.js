/**
 * The keyboard: moving over the frames, and the actions of the mouse.
 *
 * @import { Cell } from "../model.js"
 */
import { flipKeyB, pinCell, unpin } from "../compare/ab.js";
import { openComparison } from "../compare/comparison.js";
import { compareStore } from "../compare/store.js";
import { openFavourites } from "../favourites/list.js";
import { nameOf, pick, toggleFavourite, toggleMate } from "../lineage/breed.js";
import { redo, undo } from "../lineage/generations.js";
import { inspectCell } from "../lineage/inspector.js";
import { pageStore } from "../page/store.js";
import { flipKeyTarget, showTarget } from "../search/active_target.js";
import { openSearches } from "../search/searches.js";
import { NEW, searchStore } from "../search/store.js";
import { cancelGestures, cellOf } from "./gestures.js";

/** Row and column of each slot: row by row around the 4 x 4 centre. */
export const PLACES = [...Array(36).keys()]
  .map((at) => /** @type {[number, number]} */ ([Math.floor(at / 6), at % 6]))
  .filter(([row, column]) => row % 5 === 0 || column % 5 === 0);

/**
 * Where the cursor entered the centre, so that it leaves in the same row or column.
 * @type {[number, number]}
 */
let cursor = [1, 1];

/** @type {Record<string, [number, number]>} */
const STEPS = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

/**
 * Neighbour of a cell; the cell itself at the border.
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
  return inCentre(row, column)
    ? "centre"
    : PLACES.findIndex((place) => place[0] === row && place[1] === column);
}

/** @param {number} row @param {number} column */
const inCentre = (row, column) => row > 0 && row < 5 && column > 0 && column < 5;

/** @param {Cell} cell */
function focus(cell) {
  pageStore.focusedCell.value = cell;
  const found = document.querySelector(`[data-cell="${cell}"]`);
  if (found instanceof HTMLElement) found.focus();
}

/** True for a letter without modifiers. @param {KeyboardEvent} event @param {string} letter */
export const isPlain = (event, letter) =>
  event.key.toLowerCase() === letter && !event.ctrlKey && !event.metaKey && !event.altKey;

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

/** True if letters go into a text field. @param {EventTarget|null} target */
const takesText = (target) =>
  target instanceof HTMLTextAreaElement ||
  target instanceof HTMLSelectElement ||
  (target instanceof HTMLInputElement && ["text", "password"].includes(target.type));

/**
 * The dialog in which a key is pressed; without focus, the open one.
 * @param {EventTarget|null} target
 */
const dialogOf = (target) =>
  target instanceof Element
    ? (target.closest("dialog") ?? document.querySelector("dialog[open]"))
    : null;

/**
 * True inside a dialog: keys must not change the page behind it.
 * @param {EventTarget|null} target
 */
const inDialog = (target) => dialogOf(target) !== null;

/**
 * The pictures that a pressed key flips.
 * @type {{key: string, of: {down: (now: number) => void, up: (now: number) => void}}|null}
 */
let held = null;

/** The pictures that a letter flips in the present place. @param {KeyboardEvent} event */
function flipsBy(event) {
  const over = dialogOf(event.target);
  if (isPlain(event, "x") && over?.classList.contains("searches"))
    return searchStore.openView.value === NEW
      ? searchStore.understoodPair.key
      : searchStore.foundPair.key;
  if (over) return null;
  if (isPlain(event, "x") && compareStore.pinned.value) return flipKeyB;
  return isPlain(event, "t") && searchStore.activeTarget.value ? flipKeyTarget : null;
}

/** True if the page is higher than its window, so that arrow keys scroll it. */
const scrolls = () =>
  document.documentElement.scrollHeight > document.documentElement.clientHeight;

/**
 * Moves from the last focused frame by an arrow key while nothing has the focus.
 * @param {KeyboardEvent} event
 */
function enterFrames(event) {
  const step = STEPS[event.key];
  const isFree = event.target === document.body && !event.altKey && !inDialog(event.target);
  if (!step || !isFree || scrolls()) return;
  focus(neighbour(pageStore.focusedCell.value, step));
  event.preventDefault();
}

/** @param {KeyboardEvent} event */
function keyAlone(event) {
  enterFrames(event);
  if (isPlain(event, "c") && !event.repeat && !inDialog(event.target) && !takesText(event.target)) {
    openComparison();
    event.preventDefault();
  }
  if (isPlain(event, "v") && !event.repeat && !inDialog(event.target) && !takesText(event.target)) {
    openFavourites();
    event.preventDefault();
  }
  if (isPlain(event, "s") && !event.repeat && !inDialog(event.target) && !takesText(event.target)) {
    openSearches();
    event.preventDefault();
  }
  if (event.key === "?" && !event.repeat && !inDialog(event.target) && !takesText(event.target)) {
    pageStore.helpOpen.value = true;
    event.preventDefault();
  }
  if (event.key === "Escape" && !inDialog(event.target) && !cancelGestures()) {
    if (compareStore.targetInCentre.value) showTarget(false);
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
  // By the position of the key on keyboards without Latin letters.
  const key = /^[a-z]$/i.test(event.key)
    ? event.key.toLowerCase()
    : event.code.replace("Key", "").toLowerCase();
  if (event.repeat && (key === "z" || key === "y")) return event.preventDefault();
  if (key === "z") void (event.shiftKey ? redo() : undo());
  else if (key === "y") void redo();
  else return;
  event.preventDefault();
}
