/**
 * Drags over a photograph: the crop by its corners and edges, the circle by its middle and its rim,
 * the spot of the light. One drag at a time, with mouse, pen or finger.
 *
 * @import { Camera } from "../model.js"
 * @import { PictureDraft } from "../search/views.js"
 * @import { Area, Circle, Point } from "./placement.js"
 * @import { Placed } from "./setup.js"
 */
import { dragged, fromDegrees, toDegrees } from "../scene/rotation.js";
import { searchStore } from "../search/store.js";
import { cropOf } from "../search/views.js";
import { setCircle, setCrop, setRotation, setSpot, settle } from "./edit.js";
import { BALL, wholeOf } from "./setup.js";
import { photoStore } from "./store.js";

/** Axes of every photograph: its camera looks along -z. @type {Camera} */
const FRONT = { eye: [0, 0, 1], target: [0, 0, 0], up: [0, 1, 0] };
/** Longest movement of a click, in pixels of the screen. */
const CLICK_PX = 4;

/**
 * @typedef {{pointer: number, grip: string, key: number, from: Point, screen: Point, placed:
 *   Placed, crop: Area, moved: boolean}} Drag `from`: in the picture; `placed` and `crop`: at the
 *   start of the drag.
 */

/** @type {Drag|null} */
let drag = null;

/** Position of an event in the picture. @param {SVGSVGElement} svg @param {PointerEvent} event */
function pointIn(svg, event) {
  const matrix = svg.getScreenCTM();
  const point = new DOMPoint(event.clientX, event.clientY);
  const { x, y } = matrix ? point.matrixTransform(matrix.inverse()) : point;
  return { x, y };
}

/**
 * The crop after a drag at one of its corners or edges, or at its middle.
 * @param {Area} crop
 * @param {string} grip points of the compass
 * @param {number} dx
 * @param {number} dy
 * @returns {Area}
 */
export function draggedCrop({ x, y, width, height }, grip, dx, dy) {
  let [left, top, right, below] = [x, y, x + width, y + height];
  if (grip.includes("w")) left = Math.min(left + dx, right - 8);
  if (grip.includes("e")) right = Math.max(right + dx, left + 8);
  if (grip.includes("n")) top = Math.min(top + dy, below - 8);
  if (grip.includes("s")) below = Math.max(below + dy, top + 8);
  return { x: left, y: top, width: right - left, height: below - top };
}

/** @param {PictureDraft} of @returns {(event: PointerEvent) => void} */
export const pressed = (of) => (event) => {
  const svg = /** @type {SVGSVGElement} */ (event.currentTarget);
  const target = event.target instanceof Element ? event.target.closest("[data-grip]") : null;
  const grip = target?.getAttribute("data-grip");
  if (!grip || !of.placed || event.button !== 0 || drag) return;
  event.preventDefault();
  svg.setPointerCapture(event.pointerId);
  drag = {
    pointer: event.pointerId,
    grip: grip === "object" && turns(of.placed, event) ? "turn" : grip,
    key: of.key,
    from: pointIn(svg, event),
    screen: { x: event.clientX, y: event.clientY },
    placed: of.placed,
    crop: cropOf(of) ?? wholeOf(of.placed.size),
    moved: false,
  };
};

/** True if a drag on the object turns it. @param {Placed} placed @param {PointerEvent} event */
const turns = (placed, event) =>
  placed.mesh !== BALL && (event.altKey || photoStore.dragMode.value === "turn");

/** @param {PointerEvent} event */
export function moved(event) {
  if (!drag || event.pointerId !== drag.pointer) return;
  const { screen, from, grip, key, placed, crop } = drag;
  if (Math.hypot(event.clientX - screen.x, event.clientY - screen.y) > CLICK_PX) drag.moved = true;
  if (!drag.moved) return;
  const to = pointIn(/** @type {SVGSVGElement} */ (event.currentTarget), event);
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const { circle } = placed;
  if (grip === "object") return setCircle(key, { ...circle, x: circle.x + dx, y: circle.y + dy });
  if (grip === "rim") return setCircle(key, { ...circle, radius: distance(to, circle) });
  if (grip === "spot") return setSpot(key, to);
  if (grip === "turn") {
    const degrees = 90 / circle.radius;
    const start = fromDegrees(placed.rotation_deg);
    return setRotation(key, toDegrees(dragged(start, FRONT, dx * degrees, dy * degrees)));
  }
  setCrop(key, draggedCrop(crop, grip, dx, dy));
}

/** @param {Point} a @param {Circle} b */
const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

/** Ends a drag; a click on the object puts the spot there. @param {PointerEvent} event */
export function released(event) {
  if (!drag || event.pointerId !== drag.pointer) return;
  const { key, grip, from } = drag;
  const isClick = !drag.moved && event.type === "pointerup";
  drag = null;
  if (isClick && (grip === "object" || grip === "turn") && isOpen(key)) setSpot(key, from);
  settle(key);
}

/** @param {number} key */
const isOpen = (key) => searchStore.draft.value.views.some((one) => one.key === key);
