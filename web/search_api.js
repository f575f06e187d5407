/**
 * The server's routes of targets and searches as functions. Owns their addresses and the reading of logs; knows nothing of the
 * page's state.
 *
 * @import { Found, Individual, Job, LogLine, Target, TargetKind } from "./types.js"
 */
import { read, request } from "./api.js";

/** @param {Blob} file @param {{kind: TargetKind, name?: string}} spec @returns {Promise<Target>} */
export function createTarget(file, spec) {
  const body = new FormData();
  body.append("spec", JSON.stringify(spec));
  body.append("file", file);
  return request("POST", "/v1/targets", { body });
}

/** The newest. @returns {Promise<Target[]>} */
export const listTargets = async () => (await request("GET", "/v1/targets?limit=100")).items;

/** @param {string} id @returns {Promise<Target>} */
export const getTarget = (id) => request("GET", `/v1/targets/${id}`);

/** @param {string} id */
export const deleteTarget = (id) => request("DELETE", `/v1/targets/${id}`);

/** @param {unknown} json @returns {Promise<Job>} */
export const createJob = (json) => request("POST", "/v1/jobs", { json, settled: true });

/** A page of searches, newest first. @param {string|null} cursor @returns {Promise<{items: Job[], next: string|null}>} */
export const listJobs = (cursor) => request("GET", `/v1/jobs?limit=30${cursor ? `&cursor=${encodeURIComponent(cursor)}` : ""}`);

/** @param {string} id @returns {Promise<Job>} */
export const getJob = (id) => request("GET", `/v1/jobs/${id}`);

/** @param {string} id @param {"pause"|"resume"|"cancel"} how @returns {Promise<Job>} */
export const changeJob = (id, how) => request("POST", `/v1/jobs/${id}/${how}`, { settled: true });

/** @param {string} id @returns {Promise<Found[]>} */
export const getFront = async (id) => (await request("GET", `/v1/jobs/${id}/front`)).items;

/** The generations after one. @param {string} id @param {number} after @returns {Promise<LogLine[]>} */
export async function getLog(id, after) {
  const text = await (await read(`/v1/jobs/${id}/log?after=${after}`)).text();
  return text.split("\n").filter((line) => line !== "").map((line) => JSON.parse(line));
}

/** @param {string} id */
export const jobEventsUrl = (id) => `/v1/jobs/${id}/events`;

/** An individual in its own lineage's scene. @param {string} id @param {number} size @param {number|null} light_deg the scene's own where null */
export const ownPictureUrl = (id, size, light_deg) => `/v1/individuals/${id}/render.png?size=${size}${light_deg === null ? "" : `&light_deg=${light_deg}`}`;
