/**
 * Decoding of photographs by the browser, for showing them and measuring in them.
 *
 * @import { Codes } from "./pixels.js"
 * @import { Size } from "./setup.js"
 */
import { post } from "../api/request.js";
import { readExif } from "./exif.js";

/** Longest side that the server accepts. */
const MOST_PX = 4096;
/** Longest side of the copy in which circle and light are measured. */
const MEASURED_PX = 1280;
/** Part of a file that holds the Exif fields. */
const HEAD_BYTES = 128 * 1024;

/**
 * @typedef {{file: File, shown: Blob, size: Size, codes: Codes, focal_mm: number|null}} Decoded
 *   `file`: to upload; `shown`: what the browser shows of it; `codes`: of a smaller copy.
 */

/**
 * Formats of linear light, which the server develops for browsers.
 * @type {Record<string, string>}
 */
const LINEAR = { exr: "image/x-exr", hdr: "image/vnd.radiance" };

/** A picture that the browser can show. @param {File} file @returns {Promise<Blob>} */
async function showable(file) {
  const type = LINEAR[file.name.split(".").at(-1)?.toLowerCase() ?? ""];
  if (!type) return file;
  const accept = "image/png, application/problem+json";
  return (await post("/v1/develop.png", { body: file, type, accept })).blob();
}

/**
 * @param {number} width
 * @param {number} height
 * @param {ImageBitmap} bitmap
 */
function drawn(width, height, bitmap) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("the browser has no canvas");
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, 0, 0, width, height);
  return { canvas, context };
}

/**
 * Decodes a picture. The server ignores the orientation that cameras write into a file, and
 * refuses very large pictures: such files are replaced by an upright PNG that fits.
 * @param {File} file
 * @returns {Promise<{bitmap: ImageBitmap, file: File, shown: Blob, size: Size, focal_mm:
 *   number|null}>} `file`, `shown`, `size`, `focal_mm`: as of decoded photographs
 */
async function decodeUpright(file) {
  const exif = readExif(await file.slice(0, HEAD_BYTES).arrayBuffer());
  const shown = await showable(file);
  const bitmap = await createImageBitmap(shown);
  const fit = Math.min(1, MOST_PX / Math.max(bitmap.width, bitmap.height));
  const size = { width: Math.round(bitmap.width * fit), height: Math.round(bitmap.height * fit) };
  const isKept = exif.orientation === 1 && fit === 1;
  const upright = isKept ? file : await asPng(size, bitmap, file.name);
  return { bitmap, file: upright, shown: isKept ? shown : upright, size, focal_mm: exif.focal_mm };
}

/**
 * A picture to upload: the file, or an upright PNG in its place.
 * @param {File} file
 * @returns {Promise<File>}
 */
export async function uprightFile(file) {
  try {
    const { bitmap, file: upright } = await decodeUpright(file);
    bitmap.close();
    return upright;
  } catch {
    // The server's refusal says what is wrong with the file.
    return file;
  }
}

/**
 * Decodes a photograph, and measures in it.
 * @param {File} file
 * @returns {Promise<Decoded>}
 */
export async function decodePhoto(file) {
  const { bitmap, file: upright, shown, size, focal_mm } = await decodeUpright(file);
  const longer = Math.max(bitmap.width, bitmap.height);
  const less = Math.min(1, MEASURED_PX / longer);
  const { width, height } = {
    width: Math.max(1, Math.round(bitmap.width * less)),
    height: Math.max(1, Math.round(bitmap.height * less)),
  };
  const { context } = drawn(width, height, bitmap);
  const { data } = context.getImageData(0, 0, width, height);
  bitmap.close();
  return { file: upright, shown, size, codes: { width, height, data }, focal_mm };
}

/** @param {Size} size @param {ImageBitmap} bitmap @param {string} name @returns {Promise<File>} */
async function asPng({ width, height }, bitmap, name) {
  const { canvas } = drawn(width, height, bitmap);
  /** @type {Blob|null} */
  const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  if (!blob) throw new Error("the browser cannot encode the picture");
  return new File([blob], name.replace(/\.[^.]*$/, ".png"), { type: "image/png" });
}
