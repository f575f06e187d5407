/**
 * The server's routes as functions. Owns headers, retries and the reading of problems; knows nothing of the page's state.
 *
 * @import { Dialect, ExportFormat, Generation, Individual, Inspection, Knobs, Lineage, Locks, MeshAnswer, Preset, Problem, Scene, SystemAnswer } from "./types.js"
 */

import { wasStopped } from "./upload.js";

const TRIES = 5;

/** An answer that was not a success, or none at all (status 0). */
export class ProblemError extends Error {
  /** @param {Problem} problem */
  constructor(problem) {
    super(problem.detail || problem.title);
    /** @type {Problem} */
    this.problem = problem;
  }
}

/** Asks the person for a token; answers whether there is a new one. @type {() => Promise<boolean>} */
let askForToken = async () => false;

/** @param {() => Promise<boolean>} ask */
export function setTokenAsker(ask) {
  askForToken = ask;
}

/**
 * @param {unknown} error
 * @returns {Problem}
 */
export function problemOf(error) {
  if (error instanceof ProblemError) return error.problem;
  return { title: "The page failed", status: 0, detail: error instanceof Error ? error.message : String(error) };
}

/** @param {number} ms */
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/**
 * @param {Response} response
 * @returns {Promise<Problem>}
 */
async function readProblem(response) {
  const fallback = { title: response.statusText || "Refused", status: response.status, detail: "" };
  try {
    return { ...fallback, ...(await response.json()) };
  } catch {
    return { ...fallback, detail: `The server answered ${response.status} without words.` };
  }
}

/**
 * @typedef {{json?: unknown, body?: Blob|FormData, type?: string, accept?: string, version?: number, asks?: boolean, settled?: boolean,
 *   send?: (path: string, init: RequestInit) => Promise<Response>}} Options
 *   `settled`: a conflict is an answer, and no reason to ask again; `send`: what sends it, fetch unless said
 */

/**
 * One request, sent again where that is safe: a POST carries one Idempotency-Key through all its tries.
 * @param {string} method
 * @param {string} path
 * @param {Options} options
 * @returns {Promise<Response>} a success
 */
async function answered(method, path, options) {
  /** @type {Record<string, string>} */
  const headers = { Accept: options.accept ?? "application/json, application/problem+json" };
  if (method === "POST") headers["Idempotency-Key"] = newKey();
  if (options.version !== undefined) headers["If-Match"] = `"${options.version}"`;
  if (options.type) headers["Content-Type"] = options.type;
  else if (options.json !== undefined) headers["Content-Type"] = "application/json";
  const send = options.send ?? fetch;
  const body = options.body ?? (options.json === undefined ? undefined : JSON.stringify(options.json));
  for (let tried = 1; ; tried += 1) {
    let response;
    try {
      // What is being kept as the page is left is kept all the same.
      response = await send(path, { method, headers, body, credentials: "same-origin", keepalive: method === "PATCH" });
    } catch (error) {
      if (wasStopped(error)) throw error;
      if (tried < TRIES) {
        await pause(250 * 2 ** tried);
        continue;
      }
      throw new ProblemError({
        title: "The server cannot be reached",
        status: 0,
        detail: "Nothing is lost; try again when it is back.",
      });
    }
    if (response.ok) return response;
    if (response.status === 401 && options.asks !== false && (await askForToken())) continue;
    const later = response.status === 503 || response.status === 429 || (response.status === 409 && method === "POST" && !options.settled);
    if (later && tried < TRIES) {
      const seconds = Number(response.headers.get("Retry-After") ?? Number.NaN);
      await pause(Number.isFinite(seconds) ? Math.min(seconds, 5) * 1000 : 250 * 2 ** tried);
      continue;
    }
    throw new ProblemError(await readProblem(response));
  }
}

/**
 * What answers in JSON, or in nothing.
 * @param {string} method
 * @param {string} path
 * @param {Options} [options]
 * @returns {Promise<any>}
 */
export async function request(method, path, options = {}) {
  const response = await answered(method, path, options);
  return response.status === 204 ? null : response.json();
}

/**
 * What is no JSON.
 * @param {string} path
 * @param {string} [accept]
 */
export const read = (path, accept = "*/*") => answered("GET", path, { accept });

/** @param {string} path */
export const getText = async (path) => (await read(path)).text();

/** @param {string} hash */
export const getGenomeText = async (hash) => (await read(`/v1/genomes/${hash}`, "text/x-brood")).text();

/** @param {string} path */
export const getBytes = async (path) => (await read(path)).arrayBuffer();

/**
 * The first bytes of something large; the rest stays where it is.
 * @param {string} path
 * @param {number} bytes
 */
export async function getBeginning(path, bytes) {
  const reader = (await read(path)).body?.getReader();
  const found = new Uint8Array(bytes);
  for (let at = 0; at < bytes; ) {
    const { value } = (await reader?.read()) ?? {};
    if (!value) throw new ProblemError({ title: "The server's answer is too short", status: 0, detail: path });
    found.set(value.subarray(0, bytes - at), at);
    at += value.length;
  }
  await reader?.cancel();
  return found.buffer;
}

/** crypto.randomUUID exists only in secure contexts; a page served by address over plain HTTP has none. */
function newKey() {
  if (globalThis.isSecureContext) return crypto.randomUUID();
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

/**
 * Reads a list to its end.
 * @param {string} path
 * @returns {Promise<any[]>}
 */
async function readAll(path) {
  const items = [];
  let cursor = null;
  do {
    const query = cursor ? `?limit=200&cursor=${encodeURIComponent(cursor)}` : "?limit=200";
    const answer = await request("GET", path + query);
    items.push(...answer.items);
    cursor = answer.next;
  } while (cursor);
  return items;
}

/**
 * Changes a thing by its version, once more with the present version where someone else was faster.
 * @param {string} path
 * @param {number} version
 * @param {unknown} json
 */
async function patch(path, version, json) {
  try {
    return await request("PATCH", path, { json, version });
  } catch (error) {
    if (problemOf(error).status !== 412) throw error;
    const present = await request("GET", path);
    return request("PATCH", path, { json, version: present.version });
  }
}

/** @returns {Promise<SystemAnswer>} */
export const getSystem = () => request("GET", "/v1/system");

/** @param {string} token */
export const makeSession = (token) => request("POST", "/v1/session", { json: { token }, asks: false });

export const endSession = () => request("DELETE", "/v1/session", { asks: false });

/** @returns {Promise<Lineage[]>} */
export const listLineages = () => readAll("/v1/lineages");

/** @param {string} id @returns {Promise<Lineage>} */
export const getLineage = (id) => request("GET", `/v1/lineages/${id}`);

/** @param {{name: string, scene?: string, thumbnail_px: number, saturation: number, dialect?: Partial<Dialect>}} json @returns {Promise<Lineage>} */
export const createLineage = (json) => request("POST", "/v1/lineages", { json });

/**
 * @param {Lineage} of
 * @param {{name?: string, scene?: string, saturation?: number, energy_limit?: boolean}} json
 * @returns {Promise<Lineage>}
 */
export const patchLineage = (of, json) => patch(`/v1/lineages/${of.id}`, of.version, json);

/**
 * Gives a lineage another scene, if nobody has changed it meanwhile: else it is a conflict, 412.
 * @param {Lineage} of
 * @param {string} scene
 * @returns {Promise<Lineage>}
 */
export const putScene = (of, scene) => request("PATCH", `/v1/lineages/${of.id}`, { json: { scene }, version: of.version });

/** @param {Lineage} of */
export async function hideLineage(of) {
  const path = `/v1/lineages/${of.id}`;
  const present = await request("GET", path);
  return request("DELETE", path, { version: present.version });
}

/** @param {string} lineageId @returns {Promise<Generation[]>} */
export const listGenerations = (lineageId) => readAll(`/v1/lineages/${lineageId}/generations`);

/** @param {string} id @returns {Promise<Generation>} */
export const getGeneration = (id) => request("GET", `/v1/generations/${id}`);

/**
 * @param {string} lineageId
 * @param {{parents: string[], knobs: Knobs, locks?: Locks, count: number}} how locks only with parents
 * @returns {Promise<Generation>}
 */
export const breed = (lineageId, { parents, knobs, locks, count }) =>
  request("POST", `/v1/lineages/${lineageId}/generations`, {
    json: {
      parents,
      count,
      mutation: knobs.mutation,
      recombination: knobs.recombination,
      saturation: knobs.saturation,
      energy_limit: knobs.energy_limit,
      locks,
      curation: "diverse",
      constraints: { isotropic: knobs.isotropic, homogeneous: knobs.homogeneous },
    },
  });

/** @returns {Promise<Preset[]>} */
export const listPresets = () => request("GET", "/v1/presets");

/** @returns {Promise<ExportFormat[]>} */
export const listExports = () => request("GET", "/v1/exports");

/**
 * Brings genomes into a lineage as they are.
 * @param {string} lineageId
 * @param {{genomes?: string[], presets?: string[]}} json
 * @returns {Promise<Generation>}
 */
export const adopt = (lineageId, json) => request("POST", `/v1/lineages/${lineageId}/adoptions`, { json });

/** @param {Blob} file text or JSON @returns {Promise<{hash: string}>} */
export async function createGenome(file) {
  const text = await file.text();
  const type = text.trimStart().startsWith("{") ? "application/json" : "text/x-brood";
  return request("POST", "/v1/genomes", { body: new Blob([text]), type });
}

/** @param {Blob} file a lineage's whole history @returns {Promise<Lineage>} */
export const importLineage = (file) => request("POST", "/v1/lineages/import", { body: file, type: "application/json" });

/** @param {string} hash @returns {Promise<{dialect: Dialect}>} */
export const getGenome = (hash) => request("GET", `/v1/genomes/${hash}`);

/** @param {string} id @returns {Promise<Individual>} */
export const getIndividual = (id) => request("GET", `/v1/individuals/${id}`);

/** @param {string} id @returns {Promise<Inspection>} */
export const getInspection = (id) => request("GET", `/v1/individuals/${id}/inspection`);

/** @param {Individual} of @param {{favourite?: boolean, note?: string}} json @returns {Promise<Individual>} */
export const patchIndividual = (of, json) => patch(`/v1/individuals/${of.id}`, of.version, json);

/** @param {string} id @returns {Promise<Scene>} */
export const getScene = (id) => request("GET", `/v1/scenes/${id}`);

/** @param {Scene} scene @returns {Promise<Scene>} */
export function createScene(scene) {
  const { id: _, ...json } = scene;
  return request("POST", "/v1/scenes", { json });
}

/** @param {string} id @returns {Promise<import("./types.js").MeshAnswer>} */
export const getMesh = (id) => request("GET", `/v1/meshes/${id}`);

/** @param {Blob} file @returns {Promise<MeshAnswer>} */
export const createMesh = (file) => request("POST", "/v1/meshes", { body: file, type: "model/obj" });

/** @param {File} file @returns {Promise<{id: string}>} */
export const createProfile = (file) => request("POST", "/v1/profiles", { body: file, type: "application/x-ies" });

/** @param {File} file @returns {Promise<{id: string}>} */
export const createEnvironment = (file) => request("POST", "/v1/environments", { body: file, type: /\.exr$/i.test(file.name) ? "image/x-exr" : "image/vnd.radiance" });

/** @param {string} id @param {string} sceneId @param {number} size @param {number} [light_deg] the scene's own unless said */
export const pictureUrl = (id, sceneId, size, light_deg) => `/v1/individuals/${id}/render.png?size=${size}&scene=${sceneId}${light_deg === undefined ? "" : `&light_deg=${light_deg}`}`;

/**
 * Materials side by side.
 * @param {string[]} materials individuals by id, genomes by hash
 * @param {string} sceneId
 * @param {number} size
 * @returns {Promise<import("./types.js").Comparison>}
 */
export const compare = (materials, sceneId, size) => request("GET", `/v1/comparison?materials=${materials.join()}&scene=${sceneId}&size=${size}`);

/** @param {string} id @param {number} size */
export const sliceUrl = (id, size) => `/v1/individuals/${id}/slice.png?size=${size}`;

/** @param {string} lineageId */
export const eventsUrl = (lineageId) => `/v1/lineages/${lineageId}/events`;
