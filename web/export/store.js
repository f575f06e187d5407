/**
 * Store of exports of several materials: what the file contains, and the jobs that make large ones.
 *
 * @import { ExportAnswer } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 */
import { signal } from "../vendor/signals-core.js";
import { loadSetting } from "../page/memory.js";

/** Name of the setting with the ids of jobs. */
export const JOBS = "exports";

class ExportStore {
  /** Formats of the file, by name. @type {Signal<string[]>} */
  formats = signal(["brood", "png"]);
  /** Side of the pictures, as typed. @type {Signal<string>} */
  side = signal("512");
  /**
   * Id of the newest job by what it exports; kept between visits.
   * @type {Signal<Record<string, string>>}
   */
  jobIds = signal(loadSetting(JOBS, {}));
  /** Jobs as last read, by id. @type {Signal<Map<string, ExportAnswer>>} */
  jobs = signal(new Map());
  /** True while the server is asked to start a job. @type {Signal<boolean>} */
  starting = signal(false);
}

export const exportStore = new ExportStore();
