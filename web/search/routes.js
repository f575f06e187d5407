/**
 * The server's routes of targets and searches as functions.
 *
 * @import { Found, Spread, Job, LogLine, Target } from "../model.js"
 */
import { read, request } from "../api/request.js";
import { sendingBy } from "../api/upload.js";

/**
 * Uploads a target, with its parts by their names.
 * @param {unknown} spec
 * @param {Record<string, Blob>} parts
 * @param {{progress: (sent: number, whole: number) => void, signal: AbortSignal}} how
 * @returns {Promise<Target>}
 */
export function createTarget(spec, parts, how) {
  const body = new FormData();
  body.append("spec", JSON.stringify(spec));
  for (const [name, part] of Object.entries(parts)) body.append(name, part);
  return request("POST", "/v1/targets", { body, send: sendingBy(how) });
}

/** The newest targets. @returns {Promise<Target[]>} */
export const listTargets = async () => (await request("GET", "/v1/targets?limit=100")).items;

/** @param {string} id @returns {Promise<Target>} */
export const getTarget = (id) => request("GET", `/v1/targets/${id}`);

/** @param {string} id */
export const deleteTarget = (id) => request("DELETE", `/v1/targets/${id}`);

/** @param {unknown} json @returns {Promise<Job>} */
export const createJob = (json) => request("POST", "/v1/jobs", { json });

/**
 * A page of searches, newest first.
 * @param {string|null} cursor
 * @returns {Promise<{items: Job[], next: string|null}>}
 */
export const listJobs = (cursor) =>
  request("GET", `/v1/jobs?limit=30${cursor ? `&cursor=${encodeURIComponent(cursor)}` : ""}`);

/**
 * Searches whose results are born in a lineage, newest first.
 * @param {string} lineage
 * @returns {Promise<Job[]>}
 */
export const listJobsOf = async (lineage) =>
  (await request("GET", `/v1/jobs?limit=100&lineage=${lineage}`)).items;

/** @param {string} id @returns {Promise<Job>} */
export const getJob = (id) => request("GET", `/v1/jobs/${id}`);

/** @param {string} id @param {"pause"|"resume"|"cancel"} how @returns {Promise<Job>} */
export const changeJob = (id, how) => request("POST", `/v1/jobs/${id}/${how}`);

/** @param {string} id @returns {Promise<{items: Found[], spread?: Spread|null}>} */
export const getFront = (id) => request("GET", `/v1/jobs/${id}/front`);

/**
 * Log lines after a generation.
 * @param {string} id
 * @param {number} after
 * @returns {Promise<LogLine[]>}
 */
export async function getLog(id, after) {
  const text = await (await read(`/v1/jobs/${id}/log?after=${after}`)).text();
  return text
    .split("\n")
    .filter((line) => line !== "")
    .map((line) => JSON.parse(line));
}

/** @param {string} id */
export const jobEventsUrl = (id) => `/v1/jobs/${id}/events`;

/**
 * An individual in its own lineage's scene.
 * @param {string} id
 * @param {number} size
 * @param {number|null} light_deg null for the scene's own
 */
export const ownPictureUrl = (id, size, light_deg) =>
  `/v1/individuals/${id}/render.png?size=${size}${light_deg === null ? "" : `&light_deg=${light_deg}`}`;

/**
 * One of the pictures of a target.
 * @param {string} id
 * @param {number} view
 * @param {"picture"|"scene"|"pixels"|"mask"} what
 */
export const viewUrl = (id, view, what) => `/v1/targets/${id}/views/${view}/${what}.png`;

/**
 * A measured target on a sphere, in the server's default scene.
 * @param {string} id
 * @param {number} size
 * @param {number} light_deg
 */
export const measuredUrl = (id, size, light_deg) =>
  `/v1/targets/${id}/render.png?size=${size}&light_deg=${light_deg}`;

/** One of the pictures of a target, as it was uploaded. @param {string} id @param {number} view */
export const targetViewUrl = (id, view) => `/v1/targets/${id}/render.png?view=${view}`;

/**
 * An individual rendered like one of the target's pictures.
 * @param {string} id
 * @param {string} target
 * @param {number} view
 */
export const inViewUrl = (id, target, view) =>
  `/v1/individuals/${id}/render.png?target=${target}&view=${view}`;

/** @param {string} scene @param {number} size @param {number|null} light_deg */
const under = (scene, size, light_deg) =>
  `size=${size}&scene=${scene}${light_deg === null ? "" : `&light_deg=${light_deg}`}`;

/**
 * A measured target in a scene.
 * @param {string} id
 * @param {string} scene
 * @param {number} size
 * @param {number|null} light_deg null for the scene's own
 */
export const targetUrl = (id, scene, size, light_deg) =>
  `/v1/targets/${id}/render.png?${under(scene, size, light_deg)}`;

/**
 * An individual at the exposure of the target's picture in the same scene.
 * @param {string} id
 * @param {string} target
 * @param {string} scene
 * @param {number} size
 * @param {number|null} light_deg
 */
export const besideTargetUrl = (id, target, scene, size, light_deg) =>
  `/v1/individuals/${id}/render.png?target=${target}&${under(scene, size, light_deg)}`;
