/**
 * Distance to the server: pictures are requested as WebP, which is lossy and has a sixth of the
 * bytes, only where PNG would be slow. Near the server they are exact.
 */

/** Time from request to answer from which on the server is far; on a local network it is below. */
const FAR_MS = 60;
/** Bytes per millisecond below which the connection is slow: 8 Mbit/s. */
const SLOW = 1000;
/** Fewer bytes than this are no measure of the rate. */
const MEASURED_BYTES = 20_000;

const THUMBNAIL = /^(\/v1\/thumbnails\/[0-9a-f]+)\.(png|webp)$/;

/**
 * True if the server answered every request late, or sent nothing large fast. One good answer is
 * enough to be near: a busy server or browser is late at times.
 * @param {{requestStart: number, responseStart: number, responseEnd: number, transferSize:
 *   number}[]} timings of the page and its files
 */
export function isFar(timings) {
  // Both are 0 for an answer from the browser's cache.
  const sent = timings.filter((one) => one.requestStart > 0 && one.transferSize > 0);
  const large = sent.filter(({ transferSize }) => transferSize > MEASURED_BYTES);
  const isLate = sent.every((one) => one.responseStart - one.requestStart > FAR_MS);
  const isSlow = large.every((one) => one.transferSize < SLOW * (one.responseEnd - one.responseStart));
  return (sent.length > 0 && isLate) || (large.length > 0 && isSlow);
}

/** True if this page was loaded from far away. @type {boolean|null} */
let measured = null;

/** Measures once, when the first picture is requested: the page has loaded then. */
function isServerFar() {
  measured ??= isFar(
    /** @type {PerformanceResourceTiming[]} */ ([
      ...performance.getEntriesByType("navigation"),
      ...performance.getEntriesByType("resource").filter(({ name }) => name.includes("/web/")),
    ]),
  );
  return measured;
}

/**
 * Address from which a picture is loaded.
 * @param {string} url a picture's address in the API
 */
export const pictureSource = (url) => (isServerFar() ? url.replace(THUMBNAIL, "$1.webp") : url);

/**
 * A picture's address in the API, by which the page keeps its state.
 * @param {string} source
 */
export const pictureOfSource = (source) => source.replace(THUMBNAIL, "$1.png");
