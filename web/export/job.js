/**
 * Jobs that make large files: started, followed by their events, cancelled. Their ids are kept
 * between visits.
 *
 * @import { ExportAnswer, Place } from "../model.js"
 * @import { Content, Members } from "./archive.js"
 */
import { eventStream } from "../api/event_stream.js";
import { ProblemError, request } from "../api/request.js";
import { setEntry } from "../page/entry.js";
import { saveSetting } from "../page/memory.js";
import { guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { jobRequest, keyOf } from "./archive.js";
import { JOBS, exportStore } from "./store.js";

const stream = eventStream();
/** Id of the job whose events are listened to. @type {string|null} */
let heard = null;

/** @param {ExportAnswer|undefined} job */
export const isMaking = (job) => job?.state === "queued" || job?.state === "running";

/** The newest job for these materials. @param {Members} members */
export const jobFor = (members) =>
  exportStore.jobs.value.get(exportStore.jobIds.value[keyOf(members)] ?? "");

/** @param {Members} members @param {string|null} id null to forget it */
function remember(members, id) {
  const { [keyOf(members)]: _, ...others } = exportStore.jobIds.value;
  exportStore.jobIds.value = id === null ? others : { ...others, [keyOf(members)]: id };
  saveSetting(JOBS, exportStore.jobIds.value);
}

/** @param {ExportAnswer} job */
function store(job) {
  const before = exportStore.jobs.value.get(job.id);
  setEntry(exportStore.jobs, job.id, job);
  if (isMaking(before) && !isMaking(job))
    pageStore.announcement.value = `The export ${job.state === "succeeded" ? "is ready" : `is ${job.state}`}.`;
  if (heard === job.id && !isMaking(job)) listen(null, "favourites");
}

/** @param {string} id @returns {Promise<ExportAnswer>} */
const read = (id) => request("GET", `/v1/jobs/${id}`);

/** @param {string|null} id @param {Place} place */
function listen(id, place) {
  if (heard === id) return;
  heard = id;
  if (id === null) {
    stream.listen(null);
    return;
  }
  const again = () => void guarded(place, async () => store(await read(id)), true);
  stream.listen({
    url: `/v1/jobs/${id}/events`,
    opened: again,
    on: {
      state: again,
      resync: again,
      progress: (news) => {
        const job = exportStore.jobs.value.get(id);
        if (job) store({ ...job, ...news });
      },
    },
  });
}

/**
 * Reads the remembered job of these materials, and follows it while it is made.
 * @param {Members} members
 * @param {Place} place
 */
export function followExport(members, place) {
  const id = exportStore.jobIds.value[keyOf(members)];
  if (!id) return;
  void guarded(place, async () => {
    try {
      const job = await read(id);
      store(job);
      if (isMaking(job)) listen(id, place);
    } catch (error) {
      // Deleted with its files, after a day.
      if (!(error instanceof ProblemError) || error.problem.status !== 404) throw error;
      remember(members, null);
    }
  }, true);
}

/**
 * Starts a job; an earlier one for the same materials is forgotten, and cancelled by the server's
 * limits only.
 * @param {Members} members
 * @param {Content} content
 * @param {Place} place
 */
export async function startExport(members, content, place) {
  if (exportStore.starting.value) return;
  exportStore.starting.value = true;
  try {
    await guarded(place, async () => {
      /** @type {ExportAnswer} */
      const job = await request("POST", "/v1/exports", {
        json: jobRequest(members, content),
      });
      remember(members, job.id);
      store(job);
      listen(job.id, place);
    });
  } finally {
    exportStore.starting.value = false;
  }
}

/** @param {ExportAnswer} job @param {Place} place */
export const cancelExport = (job, place) =>
  guarded(place, async () => {
    store(await request("POST", `/v1/jobs/${job.id}/cancel`));
  });

/** Removes an ended job from the menu. @param {Members} members */
export const forgetExport = (members) => remember(members, null);
