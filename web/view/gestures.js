/**
 * Gestures of mouse, pen and fingers on the frames: breed, mark the mate, rotate, scale.
 *
 * @import { Cell } from "../model.js"
 */
import { compareStore } from "../compare/store.js";
import { cancelMate, pick, toggleMate } from "../lineage/breed.js";
import { lineageStore } from "../lineage/store.js";
import { pageStore } from "../page/store.js";
import { changeScene, resetView } from "../scene/edit.js";
import { dragged, fromDegrees, toDegrees } from "../scene/rotation.js";
import { sceneStore } from "../scene/store.js";

/** Longest movement of a click. */
const CLICK_PX = 4;
const LONG_PRESS_MS = 500;
/** Pause of the wheel after which the new scale is committed. */
const WHEEL_REST_MS = 250;
/** Longest time between the clicks of a double click on the centre. */
const DOUBLE_MS = 300;
const SCALE_LIMITS = [0.05, 20];

/**
 * @typedef {{x: number, y: number, startX: number, startY: number, cell: Cell|null, touch: boolean,
 *   action: "rotate"|"scale"|"mate"|"none", dragging: boolean}} ActivePointer
 *
 * @typedef {{rotation: number[], scale: number}} Pose
 */

/** Pose of the object when the gesture began. @type {Pose} */
let startPose = { rotation: fromDegrees([0, 0, 0]), scale: 1 };

/** @type {Map<number, ActivePointer>} */
const pointers = new Map();
/** Distance of the fingers at the start of a pinch; null outside of one. @type {number|null} */
let pinchStart = null;
/** True if the click that ends a drag or a long press is to be ignored. */
let swallowClick = false;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let longPress;
/** @type {ReturnType<typeof setTimeout>|undefined} */
let wheelRest;
/**
 * A click on the centre that waits, because it may become a double click.
 * @type {ReturnType<typeof setTimeout>|null}
 */
let centreClick = null;
/** True if the last press came while a click on the centre waited. */
let isDouble = false;

/**
 * Frame that an element is in.
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
 * @returns {ActivePointer["action"]}
 */
function actionOf(event, cell) {
  if (event.button === 1) return event.ctrlKey ? "scale" : "rotate";
  if (event.button === 2) return "mate";
  if (event.button === 0 && (event.altKey || cell === "centre")) return "rotate";
  return "none";
}

/** @param {PointerEvent} event */
function down(event) {
  const cell = cellOf(event.target);
  if (cell === null || onButton(event.target)) return;
  isDouble = centreClick !== null;
  dropCentreClick();
  const touch = event.pointerType === "touch";
  swallowClick = false;
  const pointer = {
    x: event.clientX,
    y: event.clientY,
    startX: event.clientX,
    startY: event.clientY,
    cell,
    touch,
    action: actionOf(event, cell),
    dragging: false,
  };
  if (pointers.size === 0) startPose = pose();
  pointers.set(event.pointerId, pointer);
  clearTimeout(longPress);
  if (pointers.size === 2) return beginPinch();
  if (!touch) return;
  longPress = setTimeout(() => {
    if (pointer.dragging || pointers.size !== 1) return;
    swallowClick = true;
    pointers.delete(event.pointerId);
    toggleMate(cell);
  }, LONG_PRESS_MS);
}

/** Distance of the two fingers of a pinch, in pixels. */
function spread() {
  const [a, b] = [...pointers.values()];
  return Math.max(1, Math.hypot(a.x - b.x, a.y - b.y));
}

function beginPinch() {
  pinchStart = spread();
  swallowClick = true;
}

/** @param {PointerEvent} event */
function move(event) {
  const pointer = pointers.get(event.pointerId);
  if (!pointer) return;
  pointer.x = event.clientX;
  pointer.y = event.clientY;
  if (pinchStart !== null && pointers.size === 2)
    return preview("scale", 0, 0, spread() / pinchStart);
  const x = pointer.x - pointer.startX;
  const y = pointer.y - pointer.startY;
  if (!pointer.dragging && Math.hypot(x, y) > CLICK_PX) {
    pointer.dragging = true;
    swallowClick = true;
    clearTimeout(longPress);
    // Captured for drags without a meaning too, because their end may be outside.
    if (event.currentTarget instanceof Element)
      event.currentTarget.setPointerCapture(event.pointerId);
  }
  if (!pointer.dragging) return;
  if (pointer.action === "rotate") preview("rotate", x, y, 1);
  if (pointer.action === "scale") preview("scale", 0, 0, 2 ** (-y / 150));
}

/** Present pose of the object, including a drag that is not rendered yet. @returns {Pose} */
function pose() {
  const { rotation_deg, scale } = sceneStore.scene.value ?? {
    rotation_deg: /** @type {import("../model.js").Vec3} */ ([0, 0, 0]),
    scale: 1,
  };
  return sceneStore.draggedPose.value ?? { rotation: fromDegrees(rotation_deg), scale };
}

/**
 * Changes the pose that is shown, without committing it.
 * @param {"rotate"|"scale"} kind
 * @param {number} x pixels dragged to the right
 * @param {number} y pixels dragged down
 * @param {number} factor
 */
function preview(kind, x, y, factor) {
  const present = sceneStore.scene.value;
  if (!present) return;
  const side = document.querySelector("[data-cell=centre]")?.clientWidth || 400;
  sceneStore.draggedPose.value = {
    kind,
    rotation: dragged(startPose.rotation, present.camera, (180 * x) / side, (180 * y) / side),
    scale: clampScale(startPose.scale * factor),
  };
}

/** @param {number} scale */
const clampScale = (scale) => Math.max(SCALE_LIMITS[0], Math.min(SCALE_LIMITS[1], scale));

/** Commits the dragged pose to the scene. */
function commit() {
  const left = sceneStore.draggedPose.value;
  if (!left) return;
  const done = changeScene("stage", () => ({
    rotation_deg: toDegrees(left.rotation),
    scale: Number(left.scale.toPrecision(4)),
  }));
  void done.finally(() => {
    if (sceneStore.draggedPose.value === left) sceneStore.draggedPose.value = null;
  });
}

/** @param {PointerEvent} event */
function up(event) {
  const pointer = pointers.get(event.pointerId);
  pointers.delete(event.pointerId);
  clearTimeout(longPress);
  if (pinchStart !== null) {
    pinchStart = null;
    pointers.clear();
    return commit();
  }
  if (!pointer) return;
  if (pointer.dragging && (pointer.action === "rotate" || pointer.action === "scale"))
    return commit();
  if (
    pointer.action === "mate" &&
    !pointer.dragging &&
    pointer.cell !== null &&
    cellOf(event.target) === pointer.cell
  )
    toggleMate(pointer.cell);
}

/** @param {PointerEvent} event */
function cancel(event) {
  clearTimeout(longPress);
  if (!pointers.delete(event.pointerId)) return;
  pinchStart = null;
  sceneStore.draggedPose.value = null;
}

/** @param {MouseEvent} event */
function click(event) {
  if (swallowClick) {
    swallowClick = false;
    return;
  }
  const cell = cellOf(event.target);
  // The second click of a double click would breed from a brood that the user has not seen.
  if (cell === null || onButton(event.target) || event.detail > 1) return;
  pageStore.focusedCell.value = cell;
  const isCovered = compareStore.flipped.value || compareStore.targetInCentre.value;
  if (cell !== "centre" || isCovered) return void pick(cell);
  const shown = lineageStore.shownId.value;
  centreClick = setTimeout(() => {
    centreClick = null;
    if (lineageStore.shownId.value === shown) void pick(cell);
  }, DOUBLE_MS);
}

/** Drops a click on the centre that waits. */
function dropCentreClick() {
  if (centreClick !== null) clearTimeout(centreClick);
  centreClick = null;
}

/** Resets the view in place of breeding from the centre. @param {MouseEvent} event */
function doubleClick(event) {
  if (isDouble && cellOf(event.target) === "centre" && !onButton(event.target)) resetView();
}

/** @param {WheelEvent} event */
function wheel(event) {
  if (cellOf(event.target) === null || pointers.size > 0) return;
  event.preventDefault();
  // 0: the wheel moved sideways only. `deltaY` is read before `deltaMode`: Firefox then reports
  // pixels.
  if (event.deltaY === 0) return;
  const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1;
  startPose = pose();
  preview("scale", 0, 0, 2 ** ((-event.deltaY * lines) / 500));
  clearTimeout(wheelRest);
  wheelRest = setTimeout(commit, WHEEL_REST_MS);
}

/** Cancels gestures and the mate. Returns false if there was nothing to cancel. */
export function cancelGestures() {
  const begun =
    pointers.size > 0 || sceneStore.draggedPose.value !== null || lineageStore.mate.value !== null;
  pointers.clear();
  pinchStart = null;
  sceneStore.draggedPose.value = null;
  clearTimeout(wheelRest);
  cancelMate();
  return begun;
}

/**
 * Listens on the element that holds the frames. Suppresses the context menu and the autoscroll of
 * the middle button on frames only.
 * @param {HTMLElement} frames
 */
export function listenToGestures(frames) {
  frames.addEventListener("pointerdown", down);
  frames.addEventListener("pointermove", move);
  frames.addEventListener("pointerup", up);
  frames.addEventListener("pointercancel", cancel);
  frames.addEventListener("click", click);
  frames.addEventListener("dblclick", doubleClick);
  frames.addEventListener("wheel", wheel, { passive: false });
  frames.addEventListener("contextmenu", (event) => {
    if (cellOf(event.target) !== null) event.preventDefault();
  });
  frames.addEventListener("mousedown", (event) => {
    if (event.button === 1 && cellOf(event.target) !== null) event.preventDefault();
  });
  frames.addEventListener("dragstart", (event) => event.preventDefault());
}
