/**
 * Pictures of known scenes as targets: the scene of each picture, and the upload that they make.
 *
 * @import { PixelCounts, Refine, Scene } from "../model.js"
 * @import { Area } from "../photo/placement.js"
 * @import { Placed } from "../photo/setup.js"
 */
import { isWhole, sceneOfPlaced, wholeOf } from "../photo/setup.js";

/**
 * @typedef {"placed"|"open"|"default"|"given"} SceneFrom Object and light that were placed on the
 *   picture, the open lineage's scene, the server's default, or what was pasted.
 *
 * @typedef {{key: number, file: File, mask: File|null, from: SceneFrom, text: string, light:
 *   string, samples: string, gain: boolean, held_out: boolean, clip_from: unknown, refine:
 *   Refine|undefined, crop: Area|null, placed: Placed|null, fromByHand: boolean}} PictureDraft
 *   `text`: the scene that was pasted;
 *   `light`: degrees to which it is turned, as typed; `clip_from`: the setting of a list, undefined
 *   without one; `refine`: uncertainties of the scene, undefined if it is exact; `crop`: null
 *   for the whole picture; `placed`: null until the picture is shown; `fromByHand`: true if the
 *   scene was chosen by hand.
 *
 * @typedef {{id: string, scene: Scene}} OpenScene
 *
 * @typedef {{spec: Record<string, unknown>, parts: Record<string, File>}} Upload
 *
 * @typedef {{view: number|null, field: string, wrong: string}} Wrong Mistake, with the number of
 *   the picture and the field that it is in; null if it is in no picture.
 */

/** Largest number of pictures of a target. */
export const MOST_PICTURES = 16;
/** Options for rays per pixel, with examples. */
export const SAMPLINGS = [
  { value: "adaptive", name: "adaptive", words: "more at edges, as in brood's own pictures" },
  { value: "1", name: "1", words: "no antialiasing" },
  { value: "4", name: "4", words: "a little antialiased" },
  { value: "16", name: "16", words: "well antialiased" },
  { value: "64", name: "64", words: "photographs and other renderers" },
];

/**
 * How well the scene of a picture is known, with the standard deviations that this stands for.
 * @type {{value: string, name: string, words: string, refine: Refine|undefined}[]}
 */
export const UNCERTAINTIES = [
  {
    value: "exact",
    name: "exactly",
    words: "rendered, or measured well",
    refine: undefined,
  },
  {
    value: "nearly",
    name: "nearly",
    words: "light within 2°, camera within 1°, distances within 2 %",
    refine: { light_deg: 2, light_distance: 0.02, camera_deg: 1, camera_distance: 0.02, fov: 0.01 },
  },
  {
    value: "roughly",
    name: "roughly",
    words: "light within 6°, camera within 3°, distances within 10 %",
    refine: { light_deg: 6, light_distance: 0.1, camera_deg: 3, camera_distance: 0.1, fov: 0.03 },
  },
];

/** Setting of uncertainties; null for those of a list. @param {Refine|undefined} refine */
export const uncertaintyOf = (refine) =>
  UNCERTAINTIES.find((of) => JSON.stringify(of.refine) === JSON.stringify(refine)) ?? null;

let lastKey = 0;

/**
 * Creates a picture of the form. Settings are copied from the picture before, which is mostly of
 * the same object.
 * @param {File} file
 * @param {PictureDraft|undefined} before
 * @param {boolean} isOpenUsable true if the scene of the open lineage can be searched in
 * @returns {PictureDraft}
 */
export function newPicture(file, before, isOpenUsable) {
  lastKey += 1;
  const { from, text, light, samples, gain, refine, crop, placed, fromByHand } = before ?? {
    from: isOpenUsable ? "open" : "default",
    text: "",
    light: "",
    samples: "adaptive",
    gain: false,
    refine: undefined,
    crop: null,
    placed: null,
    fromByHand: false,
  };
  return {
    key: lastKey,
    file,
    mask: null,
    from: /** @type {SceneFrom} */ (from),
    text,
    light,
    samples,
    gain,
    held_out: false,
    clip_from: undefined,
    refine,
    crop,
    placed,
    fromByHand,
  };
}

/** True for files that hold a scene. @param {string} name */
export const isScene = (name) => /\.json$/i.test(name);

/** True for files that may be pictures; an EXR may also be a slice. @param {string} name */
export const isPicture = (name) => /\.(png|jpe?g|hdr|exr)$/i.test(name);

/** @param {string} text @returns {{scene: Record<string, unknown>|string}|{wrong: string}} */
export function readScene(text) {
  const pasted = text.trim();
  if (pasted === "") return { wrong: "Paste the scene's JSON here, or choose its file." };
  if (/^[\w-]{8,}$/.test(pasted)) return { scene: pasted };
  /** @type {any} */
  let found;
  try {
    found = JSON.parse(pasted);
  } catch (error) {
    return {
      wrong: `The scene is not valid JSON: ${error instanceof Error ? error.message : error}`,
    };
  }
  if (typeof found !== "object" || found === null || Array.isArray(found))
    return { wrong: 'A scene is a JSON object, like {"mesh": "sphere"}.' };
  const { id: _, ...scene } = found;
  return { scene };
}

/**
 * Scene of a picture in the request; none for the server's default.
 * @param {PictureDraft} of
 * @param {OpenScene|null} open
 * @returns {{scene?: unknown}|{field: string, wrong: string}}
 */
function sceneOf({ from, text, light, placed, crop }, open) {
  if (from === "placed") {
    if (!placed)
      return {
        field: "scene",
        wrong: "The picture is not shown yet. Wait, or choose another scene.",
      };
    if (!placed.light)
      return {
        field: "spot",
        wrong: "The spot of the light is not on the object. Drag it to the highlight, or to where the object is brightest.",
      };
    return { scene: sceneOfPlaced(placed, placed.light, crop ?? wholeOf(placed.size)) };
  }
  const degrees = light.trim() === "" ? null : Number(light.replace(",", ".").replace("°", ""));
  if (degrees !== null && !Number.isFinite(degrees))
    return { field: "light", wrong: "The light angle must be a number of degrees, or empty." };
  if (from === "default") return degrees === null ? {} : { scene: { light_deg: degrees } };
  if (from === "open") {
    if (!open) return { field: "scene", wrong: "No lineage is open, so its scene cannot be used." };
    if (degrees === null) return { scene: open.id };
    const { id: _, ...scene } = open.scene;
    return { scene: { ...scene, light_deg: degrees } };
  }
  const read = readScene(text);
  if ("wrong" in read) return { field: "scene", wrong: read.wrong };
  if (degrees === null) return read;
  if (typeof read.scene === "string")
    return {
      field: "light",
      wrong: "To change the light angle, give the scene as JSON and not by its id.",
    };
  return { scene: { ...read.scene, light_deg: degrees } };
}

/**
 * Builds the upload of pictures, or returns the error in their settings.
 * @param {PictureDraft[]} views
 * @param {OpenScene|null} open
 * @returns {Upload|Wrong}
 */
export function buildUpload(views, open) {
  if (views.length === 0) return { view: null, field: "picture", wrong: "Choose a picture first." };
  if (views.every(({ held_out }) => held_out))
    return {
      view: 0,
      field: "held_out",
      wrong: "Every picture is held out; at least one must be fitted.",
    };
  /** @type {Record<string, File>} */
  const parts = {};
  /** @type {Record<string, unknown>[]} */
  const said = [];
  for (const [view, of] of views.entries()) {
    const scene = sceneOf(of, open);
    if ("wrong" in scene) return { view, ...scene };
    const [picture, mask] = [`picture-${view}`, `mask-${view}`];
    parts[picture] = of.file;
    if (of.mask) parts[mask] = of.mask;
    said.push({
      picture,
      ...(of.mask ? { mask } : {}),
      ...scene,
      samples: of.samples === "adaptive" ? "adaptive" : Number(of.samples),
      // The strength of a light that was placed by hand is unknown.
      ...(of.gain || of.from === "placed" ? { gain: true } : {}),
      ...(of.held_out ? { held_out: true } : {}),
      ...(of.clip_from === undefined ? {} : { clip_from: of.clip_from }),
      ...(of.refine === undefined ? {} : { refine: of.refine }),
      ...croppedBy(of),
    });
  }
  return { spec: { kind: "image", name: stem(views[0].file.name), views: said }, parts };
}

/**
 * Crop of a picture; null for the whole picture. A crop that was guessed around the object does not
 * apply to another scene.
 * @param {PictureDraft} of
 * @returns {Area|null}
 */
export function cropOf({ crop, placed, from }) {
  if (!crop || (placed && isWhole(crop, placed.size))) return null;
  return placed && !placed.cropByHand && from !== "placed" ? null : crop;
}

/** Crop of a picture in the request; nothing for the whole picture. @param {PictureDraft} of */
function croppedBy(of) {
  const crop = cropOf(of);
  return crop ? { crop: [crop.x, crop.y, crop.width, crop.height] } : {};
}

/**
 * A crop of a list; null for the whole picture.
 * @param {unknown} crop
 * @returns {Area|null}
 */
function readCrop(crop) {
  if (!Array.isArray(crop) || crop.length !== 4) return null;
  const [x, y, width, height] = crop.map(Number);
  return { x, y, width, height };
}

/**
 * Pictures of a JSON list in the format of the command line, with the files that came with it.
 * @param {string} text of the list
 * @param {File[]} files
 * @returns {Promise<PictureDraft[]|{wrong: string}|null>} null if it is not a list
 */
export async function picturesFromList(text, files) {
  /** @type {any} */
  let list;
  try {
    list = JSON.parse(text);
  } catch {
    return null;
  }
  if (!Array.isArray(list?.views)) return null;
  /** @type {PictureDraft[]} */
  const views = [];
  for (const of of list.views) {
    const [picture, mask] = [named(files, of.picture), named(files, of.mask)];
    if (!picture) return { wrong: `${of.picture} is in the list, but was not chosen with it.` };
    if (of.mask && !mask)
      return {
        wrong: `${of.mask} is the mask of ${of.picture}, but was not chosen with the list.`,
      };
    if (of.mesh)
      return {
        wrong: `${of.picture} shows the object ${of.mesh}: upload that first, and use its id as the mesh of the scene.`,
      };
    const scene = typeof of.scene === "string" ? named(files, of.scene) : null;
    if (typeof of.scene === "string" && !scene)
      return {
        wrong: `${of.scene} is the scene of ${of.picture}, but was not chosen with the list.`,
      };
    const said = scene ? await scene.text() : JSON.stringify(of.scene ?? {}, null, 1);
    const samples = String(of.samples ?? "adaptive");
    views.push({
      ...newPicture(picture, undefined, false),
      from: "given",
      text: said,
      mask,
      samples,
      gain: of.gain === true,
      held_out: of.held_out === true,
      clip_from: of.clip_from,
      refine: of.refine,
      crop: readCrop(of.crop),
      fromByHand: true,
    });
  }
  return views;
}

/** @param {File[]} files @param {string|undefined} path */
const named = (files, path) =>
  files.find(({ name }) => path !== undefined && name === path.split("/").at(-1)) ?? null;

/** Longest name that the server accepts. */
const NAME_CHARS = 200;

/** Name of a target from its file: without its extension. @param {string} name */
export const stem = (name) =>
  [...name.replace(/\.[^.]*$/, "").replace(/\p{Cc}/gu, " ")].slice(0, NAME_CHARS).join("");

/** Fields of a picture in the form. */
const FIELDS = ["picture", "mask", "scene", "samples", "gain", "held_out", "crop", "refine"];

/**
 * Picture and field that a refusal names.
 * @param {string|undefined|null} pointer
 * @returns {{view: number|null, field: string}|null}
 */
export function pointedView(pointer) {
  const parts = (pointer ?? "").split("/").slice(1);
  const numbered = parts[0] === "views" && /^\d+$/.test(parts[1] ?? "");
  const field = numbered ? parts[2] : parts[0];
  if (!numbered && !FIELDS.includes(field ?? "") && field !== "file") return null;
  return {
    view: numbered ? Number(parts[1]) : 0,
    field: FIELDS.includes(field ?? "") ? field : "picture",
  };
}

/**
 * Status of pixels, with the server's colours, in the order of the legend.
 * @type {{status: Exclude<keyof PixelCounts, "pixels">, name: string, color: string, words:
 *   string}[]}
 */
export const PIXEL_STATUSES = [
  {
    status: "used",
    name: "used",
    color: "#4caf50",
    words: "Used as samples: fitted, or held out for measuring",
  },
  { status: "masked", name: "masked", color: "#000000", words: "Excluded by the mask" },
  { status: "background", name: "background", color: "#30363d", words: "Outside of the object" },
  {
    status: "edge",
    name: "at edges",
    color: "#ffb300",
    words: "An edge of the object, or inside of it",
  },
  {
    status: "clipped",
    name: "clipped",
    color: "#e53935",
    words: "At the largest value that the picture can hold, or beside such pixels",
  },
  {
    status: "grazing",
    name: "grazing",
    color: "#8e24aa",
    words: "Light or eye is near the horizon",
  },
  {
    status: "outlier",
    name: "outliers",
    color: "#f06292",
    words: "Differs from its neighbours by more than noise, as dust does",
  },
  {
    status: "half_lit",
    name: "partly in shadow",
    color: "#1e88e5",
    words: "At the edge of a shadow",
  },
  {
    status: "several_lights",
    name: "lit from several directions",
    color: "#00acc1",
    words: "Several lights, a large light or an environment reach the pixel: models are fitted to it",
  },
  { status: "unlit", name: "unlit", color: "#6d4c41", words: "No light reaches the pixel" },
];

/** Statuses that occur, with their counts. @param {PixelCounts} of */
export const pixelStatuses = (of) =>
  PIXEL_STATUSES.flatMap((status) => {
    const count = of[status.status] ?? 0;
    return count > 0 ? [{ ...status, count }] : [];
  });

/** A share in percent; 0 and 100 only if exact. @param {number} part @param {number} whole */
export function share(part, whole) {
  const percent = whole > 0 ? (100 * part) / whole : 0;
  if (part > 0 && percent < 0.1) return "< 0.1 %";
  if (part < whole && percent > 99.9) return "> 99.9 %";
  return `${Number(percent.toFixed(percent < 10 ? 1 : 0))} %`;
}

/**
 * Name of a picture among several, from 0.
 * @param {{held_out: boolean}[]} views
 * @param {number} at
 */
export const nameOfView = (views, at) =>
  `${views.length > 1 ? `picture ${at + 1}` : "the picture"}${views[at]?.held_out ? ", held out" : ""}`;

/** Stated standard deviations above which a correction is doubtful. */
const FAR = 2;

/**
 * True if a correction is so large that the scene as stated is probably wrong in something else.
 * @param {{name: string, value: number, stated_deviation: number}} of
 */
export const isDoubtful = ({ name, value, stated_deviation }) =>
  Math.abs(name.endsWith("_deg") ? value : Math.log(value)) > FAR * stated_deviation;

/** Words for the numbers of a scene that a search corrects. @type {Record<string, string>} */
const CORRECTIONS = {
  right_deg: "to the right, degrees",
  up_deg: "upwards, degrees",
  aim_right_deg: "aim to the right, degrees",
  aim_up_deg: "aim upwards, degrees",
  roll_deg: "clockwise, degrees",
  distance: "distance, factor",
  fov: "field of view, factor",
};

/** Name of a corrected number in words. @param {string} name such as `lights/0/right_deg` */
export function correctionInWords(name) {
  const parts = name.split("/");
  const last = parts.at(-1) ?? "";
  if (parts[0] === "gain") return parts.length > 1 ? `brightness of ${last}, factor` : "brightness, factor";
  const of = parts[0] === "lights" ? `light ${Number(parts[1]) + 1}` : "camera";
  return `${of} ${CORRECTIONS[last] ?? last}`;
}
