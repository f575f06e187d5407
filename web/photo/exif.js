/**
 * Two facts that cameras write into JPEG files (Exif 2.3): how the picture is to be turned, and the
 * focal length. Reads bytes only.
 */

const START = 0xffd8;
const EXIF = 0xffe1;
const ORIENTATION = 0x0112;
const EXIF_FIELDS = 0x8769;
const FOCAL_35_MM = 0xa405;

/** @typedef {{orientation: number, focal_mm: number|null}} Exif 1 is upright. */

/**
 * Place of the TIFF structure in a JPEG file; null without one.
 * @param {DataView} bytes
 */
function tiffIn(bytes) {
  if (bytes.byteLength < 4 || bytes.getUint16(0) !== START) return null;
  for (let at = 2; at + 10 <= bytes.byteLength;) {
    const marker = bytes.getUint16(at);
    // Segments end where the picture's data begin.
    if (marker < 0xff00 || marker === 0xffda) return null;
    // "Exif" and two zeros.
    if (marker === EXIF && bytes.getUint32(at + 4) === 0x45786966) return at + 10;
    at += 2 + bytes.getUint16(at + 2);
  }
  return null;
}

/**
 * Value of a field of 16 or 32 bits; null if it is missing.
 * @param {DataView} bytes
 * @param {number} tiff
 * @param {number} directory offset in the TIFF structure
 * @param {number} tag
 * @param {boolean} little
 */
function field(bytes, tiff, directory, tag, little) {
  const from = tiff + directory;
  const count = bytes.getUint16(from, little);
  for (let entry = 0; entry < count; entry += 1) {
    const at = from + 2 + 12 * entry;
    if (bytes.getUint16(at, little) !== tag) continue;
    const isLong = bytes.getUint16(at + 2, little) === 4;
    return isLong ? bytes.getUint32(at + 8, little) : bytes.getUint16(at + 8, little);
  }
  return null;
}

/**
 * Reads the fields of a file; the defaults if it has none or is damaged.
 * @param {ArrayBuffer} file or its first 64 KiB
 * @returns {Exif}
 */
export function readExif(file) {
  const bytes = new DataView(file);
  const none = { orientation: 1, focal_mm: null };
  try {
    const tiff = tiffIn(bytes);
    if (tiff === null) return none;
    const little = bytes.getUint16(tiff) === 0x4949;
    const first = bytes.getUint32(tiff + 4, little);
    const orientation = field(bytes, tiff, first, ORIENTATION, little) ?? 1;
    const more = field(bytes, tiff, first, EXIF_FIELDS, little);
    const focal = more === null ? null : field(bytes, tiff, more, FOCAL_35_MM, little);
    return {
      orientation: orientation >= 1 && orientation <= 8 ? orientation : 1,
      focal_mm: focal || null,
    };
  } catch {
    // An offset beyond the end.
    return none;
  }
}
