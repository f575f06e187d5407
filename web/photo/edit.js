/**
 * Changes of a photograph in the form: its crop, the place of the object and the light. What the
 * user has not set is guessed again when something else changes.
 *
 * @import { Vec3 } from "../model.js"
 * @import { PictureDraft } from "../search/views.js"
 * @import { Surface } from "./highlight.js"
 * @import { Area, Circle, Point } from "./placement.js"
 * @import { Placed, Size } from "./setup.js"
 */
import { ProblemError, getBytes } from "../api/request.js";
import { readGeometry } from "../live/geometry.js";
import { setEntry } from "../page/entry.js";
import { updateDraft } from "../search/draft.js";
import { searchStore } from "../search/store.js";
import { cropOf } from "../search/views.js";
import { changeView } from "../search/target.js";
import { guessCircle } from "./circle_guess.js";
import { decodePhoto } from "./decode.js";
import { greyOf } from "./pixels.js";
import { fovOfLens } from "./placement.js";
import {
  BALL, BALL_EXTENT, LENSES, cameraOfPlaced, cropAround, fittingCrop, lightOfPlaced, middleCircle,
  wholeOf,
} from "./setup.js";
import { guessSpot } from "./spot_guess.js";
import { photoStore } from "./store.js";

/** Keys of pictures whose decoding was begun. @type {Set<number>} */
const begun = new Set();

/** @param {number} key */
const viewOf = (key) => searchStore.draft.value.views.find((one) => one.key === key);

/**
 * Decodes a picture of the form and places object and light on it, once.
 * @param {PictureDraft} of
 */
export async function showPhoto({ key, file }) {
  if (begun.has(key)) return;
  begun.add(key);
  try {
    const { file: upright, shown, size, codes, focal_mm } = await decodePhoto(file);
    if (!viewOf(key)) return;
    setEntry(photoStore.shown, key, { url: URL.createObjectURL(shown), codes });
    const before = viewOf(key);
    if (!before) return;
    const isSame = before.placed && sameSize(before.placed.size, size);
    const isRead = searchStore.upload.value !== null || searchStore.draft.value.target !== null;
    const from = before.fromByHand || isRead ? before.from : "placed";
    // A picture of the same size is mostly of the same object, under another light.
    // A list of pictures has crops of its own.
    const isListed = before.placed === null && before.crop !== null;
    const placed =
      isSame && before.placed
        ? before.placed
        : { ...placedBy(key, size, focal_mm), cropByHand: isListed };
    const crop = isSame || isListed ? before.crop : null;
    change(key, { file: upright, from, placed, crop });
    settle(key);
  } catch (error) {
    const from = viewOf(key)?.from === "placed" ? "default" : viewOf(key)?.from;
    if (viewOf(key)?.placed) change(key, { placed: null, crop: null, from });
    const reason = error instanceof ProblemError ? ` ${error.problem.detail}.` : "";
    const advice =
      "Use a PNG, JPEG, HDR or EXR picture to place object and light on it, or give a scene file.";
    setEntry(photoStore.shown, key, `${file.name} cannot be shown.${reason} ${advice}`);
  }
}

/** @param {Size} a @param {Size} b */
const sameSize = (a, b) => a.width === b.width && a.height === b.height;

/**
 * First placement on a picture.
 * @param {number} key
 * @param {Size} size
 * @param {number|null} focal_mm
 * @returns {Placed}
 */
function placedBy(key, size, focal_mm) {
  const circle = circleIn(key, size);
  return {
    size,
    mesh: BALL,
    extent: BALL_EXTENT,
    circle: circle ?? middleCircle(size),
    rotation_deg: [0, 0, 0],
    fov_y_deg: fovOfLens(size, focal_mm ?? LENSES[0].focal_mm),
    surface: "glossy",
    spot: circle ?? middleCircle(size),
    light: null,
    spotByHand: false,
    cropByHand: false,
    found: circle !== null,
  };
}

/** Pixels of a shown picture; null if it is not shown. @param {number} key */
function codesOf(key) {
  const shown = photoStore.shown.value.get(key);
  return shown && typeof shown !== "string" ? shown.codes : null;
}

/**
 * The circle of a ball in a picture; null if there is none.
 * @param {number} key
 * @param {Size} size
 * @returns {Circle|null}
 */
function circleIn(key, size) {
  const codes = codesOf(key);
  const found = codes && guessCircle(codes);
  return found && tenths(scaledBy(found, size.width / codes.width));
}

/** @param {Circle} of @param {number} factor @returns {Circle} */
const scaledBy = ({ x, y, radius }, factor) => ({
  x: x * factor,
  y: y * factor,
  radius: radius * factor,
});

/** @param {number} value */
const tenth = (value) => Math.round(10 * value) / 10;

/** @param {Circle} of @returns {Circle} */
const tenths = ({ x, y, radius }) => ({ x: tenth(x), y: tenth(y), radius: tenth(radius) });

/**
 * The spot of the light on a ball; null if there is none.
 * @param {number} key
 * @param {Placed} placed
 * @param {Area} crop
 * @returns {{spot: Point, surface: Surface}|null}
 */
function spotIn(key, placed, crop) {
  const codes = codesOf(key);
  if (!codes || placed.mesh !== BALL) return null;
  const factor = codes.width / placed.size.width;
  const circle = scaledBy(placed.circle, factor);
  const area = {
    x: crop.x * factor,
    y: crop.y * factor,
    width: crop.width * factor,
    height: crop.height * factor,
  };
  const camera = cameraOfPlaced(placed, crop);
  const found = guessSpot(greyOf(codes), circle, camera, area, placed.extent);
  if (!found) return null;
  const { spot, surface } = found;
  return { spot: { x: tenth(spot.x / factor), y: tenth(spot.y / factor) }, surface };
}

/**
 * Changes the placement of a picture, and computes its light.
 * @param {number} key
 * @param {Partial<Placed>} to
 * @param {Area} [crop]
 */
function changePlaced(key, to, crop) {
  const of = viewOf(key);
  if (!of?.placed) return;
  const placed = { ...of.placed, ...to };
  const area = crop ?? cropOf(of) ?? wholeOf(placed.size);
  const arrays = photoStore.meshes.value.get(placed.mesh);
  const mesh = arrays && typeof arrays !== "string" ? arrays : null;
  placed.light = lightOfPlaced(placed, area, mesh);
  change(key, { placed, crop: area });
}

/**
 * Changes a picture of the form. What the server has read stays valid if the upload would be the
 * same.
 * @param {number} key
 * @param {Partial<PictureDraft>} to
 */
function change(key, to) {
  const before = viewOf(key);
  if (!before) return;
  const after = { ...before, ...to };
  const isSame =
    after.from !== "placed" &&
    after.from === before.from &&
    after.file === before.file &&
    JSON.stringify(cropOf(after)) === JSON.stringify(cropOf(before));
  if (!isSame) return changeView(key, to);
  const { views } = searchStore.draft.value;
  updateDraft({ views: views.map((one) => (one.key === key ? after : one)) });
}

/**
 * Guesses again what the user has not set, after a change is complete.
 * @param {number} key
 */
export function settle(key) {
  const of = viewOf(key);
  if (!of?.placed) return;
  const { placed } = of;
  const isGuessed = of.from === "placed" && placed.found && !placed.cropByHand;
  const crop = isGuessed
    ? cropAround(placed.circle, placed.size)
    : (cropOf(of) ?? wholeOf(placed.size));
  const found = placed.spotByHand ? null : spotIn(key, placed, crop);
  changePlaced(key, found ?? {}, crop);
}

/** @param {number} key @param {Area} crop */
export function setCrop(key, crop) {
  const size = viewOf(key)?.placed?.size;
  if (size) changePlaced(key, { cropByHand: true }, fittingCrop(crop, size));
}

/** Uses the whole picture. @param {number} key */
export function uncrop(key) {
  const size = viewOf(key)?.placed?.size;
  if (size) setCrop(key, wholeOf(size));
}

/**
 * Moves the object; a spot that was not set by hand moves with it.
 * @param {number} key
 * @param {Circle} circle
 */
export function setCircle(key, circle) {
  const placed = viewOf(key)?.placed;
  if (!placed) return;
  const radius = Math.max(4, circle.radius);
  const next = tenths({ x: circle.x, y: circle.y, radius });
  const ratio = next.radius / placed.circle.radius;
  const spot = placed.spotByHand
    ? placed.spot
    : {
        x: tenth(next.x + (placed.spot.x - placed.circle.x) * ratio),
        y: tenth(next.y + (placed.spot.y - placed.circle.y) * ratio),
      };
  changePlaced(key, { circle: next, spot, found: true });
}

/** @param {number} key @param {Point} spot */
export const setSpot = (key, { x, y }) =>
  changePlaced(key, { spot: { x: tenth(x), y: tenth(y) }, spotByHand: true });

/** @param {number} key @param {Surface} surface */
export const setSurface = (key, surface) => changePlaced(key, { surface, spotByHand: true });

/** @param {number} key @param {Vec3} rotation_deg */
export const setRotation = (key, rotation_deg) => changePlaced(key, { rotation_deg });

/** @param {number} key @param {number} fov_y_deg */
export function setFov(key, fov_y_deg) {
  changePlaced(key, { fov_y_deg: Math.max(0.2, Math.min(150, fov_y_deg)) });
  settle(key);
}

/** @param {number} key @param {string} lens */
export function setLens(key, lens) {
  const size = viewOf(key)?.placed?.size;
  const known = LENSES.find(({ value }) => value === lens);
  if (size && known) setFov(key, fovOfLens(size, known.focal_mm));
}

/** Searches for the ball again. @param {number} key */
export function findCircle(key) {
  const placed = viewOf(key)?.placed;
  if (!placed) return;
  const circle = circleIn(key, placed.size);
  changePlaced(key, circle ? { circle, found: true } : { found: false });
  settle(key);
}

/** Searches for the spot of the light again. @param {number} key */
export function findSpot(key) {
  changePlaced(key, { spotByHand: false });
  settle(key);
}

/**
 * Chooses the object, and requests its mesh for the outline.
 * @param {number} key
 * @param {string} mesh
 */
export async function chooseObject(key, mesh) {
  if (mesh === BALL) {
    changePlaced(key, { mesh, extent: BALL_EXTENT });
    return settle(key);
  }
  try {
    const known = photoStore.meshes.value.get(mesh);
    const arrays =
      known && typeof known !== "string"
        ? known
        : readGeometry(await getBytes(`/v1/meshes/${mesh}/geometry`));
    setEntry(photoStore.meshes, mesh, arrays);
    changePlaced(key, { mesh, extent: arrays.extent });
  } catch {
    setEntry(photoStore.meshes, mesh, "The object could not be loaded. Choose it again.");
  }
}
