/**
 * Hands on the frames: which movement of mouse, pen or finger means breed, mate, rotate or scale. Owns the pointers between
 * down and up; what they lead to is done elsewhere.
 *
 * @import { Cell } from "./types.js"
 */
import { cancelMate, pick, toggleMate } from "./breed.js";
import { changeScene } from "./scene.js";
import { focused, mate, scene, turning } from "./state.js";
import { dragged, fromDegrees, toDegrees } from "./turn.js";

/** A movement up to this far is a click. */
const CLICK_PX = 4;
const LONG_PRESS_MS = 500;
/** The wheel rests this long before the new scale is drawn. */
const WHEEL_REST_MS = 250;
const SCALE_LIMITS = [0.05, 20];

/**
 * @typedef {{x: number, y: number, startX: number, startY: number, cell: Cell|null, touch: boolean,
 *   means: "rotate"|"scale"|"mate"|"none", dragging: boolean}} Hand
 *
 * @typedef {{rotation: number[], scale: number}} Pose
 */

/** How the object stood when the movement began. @type {Pose} */
let base = { rotation: fromDegrees([0, 0, 0]), scale: 1 };

/** @type {Map<number, Hand>} */
const hands = new Map();
/** @type {number|null} */
let pinchStart = null;
/** A click that ends a drag or a long press is not a click. */
let swallowClick = false;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let longPress;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let wheelRest;

/**
 * @param {EventTarget|null} target
 * @returns {Cell|null}
 */
export function cellOf(target) {
  const found = target instanceof Element ? target.closest("[data-cell]") : null;
  const name = found instanceof HTMLElement ? found.dataset.cell : undefined;
  if (name === undefined) return null;
  return name === "centre" ? "centre" : Number(name);
}

/** @param {EventTarget|null} target */
const onButton = (target) => target instanceof Element && target.closest("button") !== null;

/**
 * @param {PointerEvent} event
 * @param {Cell|null} cell
 * @returns {Hand["means"]}
 */
function meaning(event, cell) {
  if (event.button === 1) return event.ctrlKey ? "scale" : "rotate";
  if (event.button === 2) return "mate";
  if (event.button === 0 && (event.altKey || cell === "centre")) return "rotate";
  return "none";
}

/** @param {PointerEvent} event */
function down(event) {
  const cell = cellOf(event.target);
  if (cell === null || onButton(event.target)) return;
  const touch = event.pointerType === "touch";
  swallowClick = false;
  const hand = { x: event.clientX, y: event.clientY, startX: event.clientX, startY: event.clientY, cell, touch, means: meaning(event, cell), dragging: false };
  if (hands.size === 0) base = pose();
  hands.set(event.pointerId, hand);
  clearTimeout(longPress);
  if (hands.size === 2) return beginPinch();
  if (!touch) return;
  longPress = setTimeout(() => {
    if (hand.dragging || hands.size !== 1) return;
    swallowClick = true;
    hands.delete(event.pointerId);
    toggleMate(cell);
  }, LONG_PRESS_MS);
}

function spread() {
  const [a, b] = [...hands.values()];
  return Math.max(1, Math.hypot(a.x - b.x, a.y - b.y));
}

function beginPinch() {
  pinchStart = spread();
  swallowClick = true;
}

/** @param {PointerEvent} event */
function move(event) {
  const hand = hands.get(event.pointerId);
  if (!hand) return;
  hand.x = event.clientX;
  hand.y = event.clientY;
  if (pinchStart !== null && hands.size === 2) return preview("scale", 0, 0, spread() / pinchStart);
  const x = hand.x - hand.startX;
  const y = hand.y - hand.startY;
  if (!hand.dragging && Math.hypot(x, y) > CLICK_PX) {
    hand.dragging = true;
    swallowClick = true;
    clearTimeout(longPress);
    // Also where the drag means nothing: its end has to be heard of, wherever that is.
    if (event.currentTarget instanceof Element) event.currentTarget.setPointerCapture(event.pointerId);
  }
  if (!hand.dragging) return;
  if (hand.means === "rotate") preview("rotate", x, y, 1);
  if (hand.means === "scale") preview("scale", 0, 0, 2 ** (-y / 150));
}

/** How the object stands, counting what was let go but is not drawn yet. @returns {Pose} */
function pose() {
  const { rotation_deg, scale } = scene.value ?? { rotation_deg: /** @type {import("./types.js").Vec3} */ ([0, 0, 0]), scale: 1 };
  return turning.value ?? { rotation: fromDegrees(rotation_deg), scale };
}

/**
 * @param {"rotate"|"scale"} kind
 * @param {number} x pixels dragged to the right
 * @param {number} y pixels dragged down
 * @param {number} factor
 */
function preview(kind, x, y, factor) {
  const present = scene.value;
  if (!present) return;
  const side = document.querySelector("[data-cell=centre]")?.clientWidth || 400;
  turning.value = {
    kind,
    rotation: dragged(base.rotation, present.camera, (180 * x) / side, (180 * y) / side),
    scale: limited(base.scale * factor),
  };
}

/** @param {number} scale */
const limited = (scale) => Math.max(SCALE_LIMITS[0], Math.min(SCALE_LIMITS[1], scale));

/** Has the object drawn as it was left. */
function commit() {
  const left = turning.value;
  if (!left) return;
  const done = changeScene("stage", () => ({
    rotation_deg: toDegrees(left.rotation),
    scale: Number(left.scale.toPrecision(4)),
  }));
  void done.finally(() => {
    if (turning.value === left) turning.value = null;
  });
}

/** @param {PointerEvent} event */
function up(event) {
  const hand = hands.get(event.pointerId);
  hands.delete(event.pointerId);
  clearTimeout(longPress);
  if (pinchStart !== null) {
    pinchStart = null;
    hands.clear();
    return commit();
  }
  if (!hand) return;
  if (hand.dragging && (hand.means === "rotate" || hand.means === "scale")) return commit();
  if (hand.means === "mate" && !hand.dragging && hand.cell !== null && cellOf(event.target) === hand.cell) toggleMate(hand.cell);
}

/** @param {PointerEvent} event */
function cancel(event) {
  clearTimeout(longPress);
  if (!hands.delete(event.pointerId)) return;
  pinchStart = null;
  turning.value = null;
}

/** @param {MouseEvent} event */
function click(event) {
  if (swallowClick) {
    swallowClick = false;
    return;
  }
  const cell = cellOf(event.target);
  // The second click of two falls on a brood that nobody has looked at.
  if (cell === null || onButton(event.target) || event.detail > 1) return;
  focused.value = cell;
  void pick(cell);
}

/** @param {WheelEvent} event */
function wheel(event) {
  if (cellOf(event.target) === null || hands.size > 0) return;
  event.preventDefault();
  // Sideways only. Asked for before the mode, which makes Firefox tell pixels.
  if (event.deltaY === 0) return;
  const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1;
  base = pose();
  preview("scale", 0, 0, 2 ** ((-event.deltaY * lines) / 500));
  clearTimeout(wheelRest);
  wheelRest = setTimeout(commit, WHEEL_REST_MS);
}

/** Keys that stop what hands have begun; answers whether anything was. */
export function letGo() {
  const begun = hands.size > 0 || turning.value !== null || mate.value !== null;
  hands.clear();
  pinchStart = null;
  turning.value = null;
  clearTimeout(wheelRest);
  cancelMate();
  return begun;
}

/**
 * Listens on the element that holds the frames. The context menu and the middle button's autoscroll are kept from the
 * frames and from nothing else.
 * @param {HTMLElement} frames
 */
export function listenToHands(frames) {
  frames.addEventListener("pointerdown", down);
  frames.addEventListener("pointermove", move);
  frames.addEventListener("pointerup", up);
  frames.addEventListener("pointercancel", cancel);
  frames.addEventListener("click", click);
  frames.addEventListener("wheel", wheel, { passive: false });
  frames.addEventListener("contextmenu", (event) => {
    if (cellOf(event.target) !== null) event.preventDefault();
  });
  frames.addEventListener("mousedown", (event) => {
    if (event.button === 1 && cellOf(event.target) !== null) event.preventDefault();
  });
  frames.addEventListener("dragstart", (event) => event.preventDefault());
}
