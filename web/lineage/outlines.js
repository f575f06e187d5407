/**
 * The history of a lineage as outlines, read page by page: a long one while it is shown.
 *
 * @import { GenerationOutline } from "../model.js"
 */
import * as api from "../api/routes.js";
import { guarded } from "../page/problem.js";
import { storeOutlines } from "./generations.js";
import { lineageStore } from "./store.js";

/**
 * Least number of outlines that are stored together, and at least as many as are in the store: each
 * time, all are put in order and drawn anew.
 */
const TOGETHER = 1000;

/** Id of the lineage whose outlines are being read. @type {string|null} */
let reading = null;

/** True while the history of the open lineage is incomplete. */
export const isHistoryIncomplete = () => reading !== null && reading === lineageStore.lineage.value?.id;

/**
 * Reads the outlines after the first page into the store, while the lineage is open.
 * @param {string} id the open lineage
 * @param {string|null} next cursor after the first page
 */
export async function readRest(id, next) {
  reading = next === null ? null : id;
  await guarded("stage", async () => {
    /** @type {GenerationOutline[]} */
    let read = [];
    for (let cursor = next; cursor !== null;) {
      const page = await api.listOutlines(id, cursor);
      if (lineageStore.lineage.value?.id !== id) return;
      read.push(...page.items);
      cursor = page.next;
      const enough = Math.max(TOGETHER, lineageStore.generations.value.size);
      if (read.length < enough && cursor !== null) continue;
      storeOutlines(read);
      read = [];
    }
  });
  if (reading === id) reading = null;
}

/** Reads all outlines of a lineage. @param {string} id @returns {Promise<GenerationOutline[]>} */
export async function readOutlines(id) {
  const read = [];
  let cursor = null;
  do {
    const page = await api.listOutlines(id, cursor);
    read.push(...page.items);
    cursor = page.next;
  } while (cursor !== null);
  return read;
}
