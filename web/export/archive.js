/**
 * Files of several materials: what they contain, their addresses, and reasons why they cannot be
 * made.
 *
 * @import { ExportFormat } from "../model.js"
 */
import { SIDE_PX } from "../page/size.js";
import { exportStore } from "./store.js";

/** Most materials and most pixels of a file; the server's limits. */
export const MOST_FILES = 256;
const MOST_PIXELS = 2 ** 25;
/** Most binary tables that are made while the page waits; more become a job. */
const MOST_AT_ONCE = 4;
/** Formats that are pictures. */
const PICTURES = ["png", "exr"];

/**
 * Materials of a file: individuals, the children of a generation, or the front of a search.
 * @typedef {{individuals: string[]}|{generation: string}|{job: string}} Members
 */

/**
 * Content of a file.
 * @typedef {{formats: string[], side: string, limited: boolean}} Content `side`: of the pictures,
 *   as typed; `limited`: true for source code under the energy limit
 */

/** @param {string} format @param {boolean} on */
export function setFormat(format, on) {
  const others = exportStore.formats.value.filter((one) => one !== format);
  exportStore.formats.value = on ? [...others, format] : others;
}

/**
 * Reason why a file cannot be made; empty if it can.
 * @param {number} count
 * @param {string[]} formats
 * @param {string} side as typed
 */
export function archiveProblem(count, formats, side) {
  if (count > MOST_FILES) return `At most ${MOST_FILES} fit into one file.`;
  if (formats.length === 0) return "Choose a format.";
  const pictures = formats.filter((one) => PICTURES.includes(one)).length;
  if (pictures === 0) return "";
  const px = Number(side);
  if (!Number.isInteger(px) || px < SIDE_PX.min || px > SIDE_PX.max)
    return `The side must be ${SIDE_PX.min} to ${SIDE_PX.max} pixels.`;
  if (count * pictures * px * px > MOST_PIXELS)
    return `The pictures are too large together: at most ${Math.floor(Math.sqrt(MOST_PIXELS / (count * pictures)))} pixels each.`;
  return "";
}

/**
 * True if a job makes the file, because of its number of tables.
 * @param {number} count
 * @param {string[]} formats
 * @param {ExportFormat[]} known
 */
export function isLarge(count, formats, known) {
  const tables = known.filter(
    (one) => formats.includes(one.name) && one.media_type === "application/octet-stream",
  );
  return count * tables.length > MOST_AT_ONCE;
}

/** @param {string[]} formats */
const hasPictures = (formats) => formats.some((one) => PICTURES.includes(one));

/**
 * Address of a file.
 * @param {Members} members
 * @param {Content} content
 */
export function archivePath(members, { formats, side, limited }) {
  const [[name, of]] = Object.entries(members);
  return (
    `/v1/exports.zip?${name}=${Array.isArray(of) ? of.join() : of}&formats=${formats.join()}` +
    (hasPictures(formats) ? `&size=${Number(side)}` : "") +
    `&energy_limit=${limited}`
  );
}

/**
 * Request for a job that makes a file.
 * @param {Members} members
 * @param {Content} content
 */
export const jobRequest = (members, { formats, side, limited }) => ({
  ...members,
  formats,
  ...(hasPictures(formats) && { size: Number(side) }),
  energy_limit: limited,
});

/** Name of what is exported, under which its job is remembered. @param {Members} members */
export function keyOf(members) {
  const [[name, of]] = Object.entries(members);
  return Array.isArray(of) ? name : `${name}-${of}`;
}
