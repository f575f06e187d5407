/**
 * Formats in which the server exports source code.
 *
 * @import { Place } from "../model.js"
 */
import * as api from "../api/routes.js";
import { guarded } from "../page/problem.js";
import { lineageStore } from "./store.js";

/** Reads the list of languages for source code once. @param {Place} place */
export function listFormats(place) {
  if (lineageStore.exportFormats.peek().length > 0) return;
  void guarded(place, async () => {
    lineageStore.exportFormats.value = await api.listExports();
  }, true);
}
