/**
 * Requests to the server: headers, retries, and problems as errors. Independent of the page's
 * state, except that a 401 opens the question for an access token.
 *
 * @import { Problem } from "../model.js"
 */
import { askForToken } from "./token.js";
import { wasStopped } from "./upload.js";

/** Title of the problem that no answer came. */
const UNREACHABLE = "The server cannot be reached";

/** Problem of a request without a complete answer. */
const unreachable = () =>
  new ProblemError({
    title: UNREACHABLE,
    status: 0,
    detail: "Nothing is lost; try again when it is back.",
  });

/** True if no answer came, or a proxy answered in place of the server. @param {Problem} problem */
export const isUnreachable = ({ title, status }) =>
  (status === 0 && title === UNREACHABLE) || status === 502 || status === 504;

/**
 * True if a request failed because the server could not answer, and may succeed later.
 * @param {Problem} problem
 */
export const isOutage = (problem) => isUnreachable(problem) || problem.status === 503;

/** Resolves when the server answers again. */
export async function whenReachable() {
  for (;;) {
    await pause(PROBE_MS);
    try {
      if ((await fetch("/healthz")).ok) return;
    } catch {
      // Not yet.
    }
  }
}

/** Interval of probes of a server that does not answer. */
const PROBE_MS = 2000;

/** Number of attempts of one request. */
const TRIES = 5;

/** Number of attempts within EARLY_MS of the first: a server that is away refuses fast. */
const EARLY_TRIES = 9;

/** Time in which more attempts are made, in milliseconds. */
const EARLY_MS = 10_000;

/** Longest wait for another attempt that a server can ask for, in seconds. */
const MOST_SECONDS = 5;

/**
 * Wait before the next attempt in milliseconds: a second at most, because a person who breeds
 * waits for the rest of it when the server is back.
 * @param {number} tried number of attempts so far
 */
const backoff = (tried) => Math.min(250 * 2 ** tried, 1000);

/** Type of the problem while the server still executes an earlier attempt of a POST. */
const STILL_RUNNING = "/problems/still-running";

/** An answer that is not a success, or no answer at all (status 0). */
export class ProblemError extends Error {
  /** @param {Problem} problem */
  constructor(problem) {
    super(problem.detail || problem.title);
    /** @type {Problem} */
    this.problem = problem;
  }
}

/**
 * Problem to show for an error: the server's, or a generic one.
 * @param {unknown} error
 * @returns {Problem}
 */
export function problemOf(error) {
  if (error instanceof ProblemError) return error.problem;
  return {
    title: "Error in the page",
    status: 0,
    detail: error instanceof Error ? error.message : String(error),
  };
}

/**
 * Waits, but not longer than until `signal` is aborted.
 * @param {number} ms
 * @param {AbortSignal} [signal]
 */
const pause = (ms, signal) =>
  new Promise((done) => {
    setTimeout(done, ms);
    signal?.addEventListener("abort", done, { once: true });
  });

/**
 * Reads the problem in a refusal; a generic one if the body is not JSON.
 * @param {Response} response
 * @returns {Promise<Problem>}
 */
async function readProblem(response) {
  const fallback = {
    title: response.statusText || "Request refused",
    status: response.status,
    detail: "",
  };
  try {
    return { ...fallback, ...(await response.json()) };
  } catch {
    return {
      ...fallback,
      detail: `The server answered ${response.status} without an explanation.`,
    };
  }
}

/**
 * @typedef {{json?: unknown, body?: Blob|FormData, type?: string, accept?: string, version?:
 *   number, asks?: boolean, send?: (path: string, init: RequestInit) => Promise<Response>, signal?:
 *   AbortSignal}} Options `version`: sent as If-Match; `asks`: false if a 401 must not ask for a
 *   token; `send`: replaces fetch.
 */

/**
 * Sends one request, and repeats it after failures that may pass. A repeated POST is executed once,
 * because all its attempts carry one Idempotency-Key. A repeated DELETE that finds nothing
 * succeeds, because an attempt before may have removed it.
 * @param {string} method
 * @param {string} path
 * @param {Options} options
 * @returns {Promise<Response>} a success
 */
async function sendRequest(method, path, options) {
  /** @type {Record<string, string>} */
  const headers = { Accept: options.accept ?? "application/json, application/problem+json" };
  if (method === "POST") headers["Idempotency-Key"] = newKey();
  if (options.version !== undefined) headers["If-Match"] = `"${options.version}"`;
  if (options.type) headers["Content-Type"] = options.type;
  else if (options.json !== undefined) headers["Content-Type"] = "application/json";
  const send = options.send ?? fetch;
  const body =
    options.body ?? (options.json === undefined ? undefined : JSON.stringify(options.json));
  const start = performance.now();
  // True if the server may have executed an attempt that failed.
  let isUncertain = false;
  for (let tried = 1; ; tried += 1) {
    const isLast = () => tried >= (performance.now() - start < EARLY_MS ? EARLY_TRIES : TRIES);
    let response;
    try {
      // `keepalive`: a change that is being saved as the page is left still reaches the server.
      response = await send(path, {
        method,
        headers,
        body,
        credentials: "same-origin",
        signal: options.signal,
        keepalive: method === "PATCH",
      });
    } catch (error) {
      if (wasStopped(error)) throw error;
      if (isLast()) throw unreachable();
      isUncertain = true;
      await pause(backoff(tried), options.signal);
      continue;
    }
    if (response.ok) return response;
    if (response.status === 404 && method === "DELETE" && isUncertain)
      return new Response(null, { status: 204 });
    if (response.status === 401 && options.asks !== false && (await askForToken())) continue;
    const problem = await readProblem(response);
    const mayPass = [429, 502, 503, 504].includes(response.status) || problem.type === STILL_RUNNING;
    if (!mayPass || isLast()) throw new ProblemError(problem);
    isUncertain ||= isOutage(problem);
    const seconds = Number(response.headers.get("Retry-After") ?? Number.NaN);
    const ms = Number.isFinite(seconds) ? Math.min(seconds, MOST_SECONDS) * 1000 : backoff(tried);
    await pause(ms, options.signal);
  }
}

/**
 * Sends a request that is answered in JSON, or with 204 and nothing.
 * @param {string} method
 * @param {string} path
 * @param {Options} [options]
 * @returns {Promise<any>}
 */
export async function request(method, path, options = {}) {
  const response = await sendRequest(method, path, options);
  return response.status === 204 ? null : response.json();
}

/**
 * Reads something that is not JSON.
 * @param {string} path
 * @param {{accept?: string, signal?: AbortSignal}} [options]
 */
export const read = (path, { accept = "*/*", signal } = {}) =>
  sendRequest("GET", path, { accept, signal });

/**
 * Sends a body; the answer may be anything.
 * @param {string} path
 * @param {Options} options
 */
export const post = (path, options) => sendRequest("POST", path, options);

/**
 * Reads a body in parts.
 * @param {Response} response
 * @param {(part: Uint8Array<ArrayBuffer>) => void} take
 */
export async function readParts(response, take) {
  const reader = response.body?.getReader();
  try {
    for (let part = await reader?.read(); part && !part.done; part = await reader?.read())
      take(part.value);
  } catch (error) {
    throw wasStopped(error) ? error : unreachable();
  }
}

/** Statuses of refusals that may pass: no token, too early, too many requests. */
const PASSING = [401, 403, 408, 425, 429];

/**
 * Reads why the server refuses an address for good. Null if it answers, or may answer later.
 * @param {string} path
 * @returns {Promise<string|null>}
 */
export async function refusalOf(path) {
  try {
    const response = await fetch(path, { credentials: "same-origin" });
    const { status } = response;
    const isFinal = status >= 400 && status < 500 && !PASSING.includes(status);
    if (!isFinal) await response.body?.cancel();
    return isFinal ? (await readProblem(response)).detail : null;
  } catch {
    return null;
  }
}

/** @param {string} path */
export const getText = async (path) => (await read(path)).text();

/** @param {string} path */
export const getBytes = async (path) => (await read(path)).arrayBuffer();

/**
 * Reads the first bytes of something large, and cancels the rest.
 * @param {string} path
 * @param {number} bytes
 */
export async function getBeginning(path, bytes) {
  const reader = (await read(path)).body?.getReader();
  const found = new Uint8Array(bytes);
  for (let at = 0; at < bytes;) {
    const { value } = (await reader?.read()) ?? {};
    if (!value)
      throw new ProblemError({
        title: "The server's answer is too short",
        status: 0,
        detail: path,
      });
    found.set(value.subarray(0, bytes - at), at);
    at += value.length;
  }
  await reader?.cancel();
  return found.buffer;
}

/**
 * Random key. crypto.randomUUID exists only in secure contexts, which a page over plain HTTP is
 * not.
 */
function newKey() {
  if (globalThis.isSecureContext) return crypto.randomUUID();
  return [...crypto.getRandomValues(new Uint8Array(16))]
    .map((byte) => byte.toString(16).padStart(2, "0"))
    .join("");
}

/**
 * Reads all pages of a list.
 * @param {string} path
 * @param {string} [filter] more parameters, each after "&"
 * @returns {Promise<any[]>}
 */
export async function readAll(path, filter = "") {
  const items = [];
  let cursor = null;
  do {
    const query = cursor ? `?limit=200&cursor=${encodeURIComponent(cursor)}` : "?limit=200";
    const answer = await request("GET", path + query + filter);
    items.push(...answer.items);
    cursor = answer.next;
  } while (cursor);
  return items;
}

/**
 * Changes a resource of this version. If another client has changed it meanwhile, applies the
 * change once more, to the present version.
 * @param {string} path
 * @param {number} version
 * @param {unknown} json
 */
export async function patch(path, version, json) {
  try {
    return await request("PATCH", path, { json, version });
  } catch (error) {
    if (problemOf(error).status !== 412) throw error;
    const present = await request("GET", path);
    return request("PATCH", path, { json, version: present.version });
  }
}
