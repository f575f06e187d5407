/**
 * Uploads with progress and a way to stop them. Uses XMLHttpRequest, which alone reports progress
 * of a body, and answers as fetch does.
 */

/** Statuses whose answers must not have a body. */
const EMPTY = [204, 205, 304];

/**
 * Returns a function in place of fetch.
 * @param {{progress: (sent: number, whole: number) => void, signal: AbortSignal}} how `progress`:
 *   called with bytes
 * @returns {(path: string, init: RequestInit) => Promise<Response>}
 */
export const sendingBy =
  ({ progress, signal }) =>
  (path, { method = "POST", headers, body }) =>
    new Promise((resolve, reject) => {
      const stopped = () => new DOMException("The upload was stopped.", "AbortError");
      if (signal.aborted) return reject(stopped());
      const sent = new XMLHttpRequest();
      const stop = () => sent.abort();
      sent.open(method, path);
      sent.responseType = "blob";
      for (const [name, value] of Object.entries(headers ?? {})) sent.setRequestHeader(name, value);
      sent.upload.addEventListener("progress", ({ loaded, total }) => progress(loaded, total));
      sent.addEventListener("load", () =>
        resolve(
          new Response(EMPTY.includes(sent.status) ? null : sent.response, {
            status: sent.status,
            statusText: sent.statusText,
            headers: headersOf(sent),
          }),
        ),
      );
      sent.addEventListener("error", () => reject(new TypeError("The server cannot be reached.")));
      sent.addEventListener("abort", () => reject(stopped()));
      sent.addEventListener("loadend", () => signal.removeEventListener("abort", stop));
      signal.addEventListener("abort", stop);
      sent.send(/** @type {XMLHttpRequestBodyInit} */ (body));
    });

/** @param {XMLHttpRequest} of */
function headersOf(of) {
  const lines = of
    .getAllResponseHeaders()
    .trim()
    .split(/\r?\n/)
    .filter((line) => line.includes(":"));
  return new Headers(
    lines.map(
      (line) =>
        /** @type {[string, string]} */ ([
          line.slice(0, line.indexOf(":")),
          line.slice(line.indexOf(":") + 1).trim(),
        ]),
    ),
  );
}

/** True if the user stopped the upload or download. @param {unknown} error */
export const wasStopped = (error) => error instanceof DOMException && error.name === "AbortError";
