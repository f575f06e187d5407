/**
 * A search that is being asked for: its target, its options, and the request that they make. Owns what is filled in, which stays
 * until a search has begun; how a target comes to the server is search_target.js's.
 *
 * @import { PictureDraft } from "./search_views.js"
 * @import { Dialect, Individual, Job, Target, TargetKind } from "./types.js"
 */
import { signal } from "./vendor/signals-core.js";
import { guarded } from "./lineage.js";
import * as api from "./search_api.js";
import { nameOfTarget } from "./search_words.js";
import { NEW, looking, openSearches, putJob } from "./searches.js";
import { forget, large, lineage, tell } from "./state.js";

/**
 * @typedef {"seconds"|"generations"|"evaluations"} Measure
 *
 * @typedef {{file: File|null, kind: TargetKind|"", views: PictureDraft[], target: Target|null, own: string|null, name: string,
 *   strategy: string, measure: Measure, seconds: string, generations: string, evaluations: string, seed: string, threads: string, mirrored: boolean,
 *   into: "own"|"open", start: {of: Individual, name: string}|null}} Draft
 *   Numbers are as they are typed. `file`: what was chosen, the first of several pictures; `views`: what is said of pictures;
 *   `own`: the target that this form has made and that nothing searches for yet.
 */

/** What the server knows by name; none is sent unless it is chosen. */
export const STRATEGIES = ["hybrid", "lobes", "gp", "analytic"];

/** @type {Draft} */
const BLANK = {
  file: null, kind: "", views: [], target: null, own: null, name: "", strategy: "", measure: "seconds", seconds: "25", generations: "40",
  evaluations: "20000", seed: "", threads: "", mirrored: false, into: "own", start: null,
};

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */
/** @type {Signal<Draft>} */
export const draft = signal(BLANK);
/** @type {Signal<boolean>} */
export const starting = signal(false);

/** @param {Partial<Draft>} change */
export function fill(change) {
  draft.value = { ...draft.value, ...change };
}

/** Starts the form from an individual, its finds to be born beside it. @param {Individual} of @param {string} name */
export function searchFrom(of, name) {
  // Genetic programs, which the server takes where no other strategy can go on from it, stay in its dialect.
  fill({ start: { of, name }, into: lineage.value ? "open" : "own" });
  openSearches(NEW);
}

/**
 * Why what a search finds cannot be bred together with the programs of a lineage; empty where it can. The server has the last word.
 * @param {Dialect} dialect
 */
export function misfit({ length, opcodes, registers }) {
  if (length === 0 || (opcodes === "extended" && registers === 16 && length >= 120)) return "";
  return `its programs are for another machine (${opcodes}, ${registers} registers, ${length} instructions) than a search's (extended, 16, 120)`;
}

/** A whole number as it is typed. @param {string} text */
const isWhole = (text) => /^\d+$/.test(text.trim());

/**
 * What the server is asked for, or what is wrong with the form.
 * @param {Draft} of
 * @param {string|null} open the open lineage
 * @returns {{json: Record<string, unknown>}|{field: string, wrong: string}}
 */
export function requestOf(of, open) {
  if (!of.target) return { field: "target", wrong: of.kind === "image" && of.file ? "Have the pictures read first." : "Choose what to match first: a file, or a target that is here already." };
  const budget = Number(of[of.measure]);
  if (of[of.measure].trim() === "" || !(budget > 0)) return { field: of.measure, wrong: `How many ${of.measure}? A number above 0.` };
  if (of.measure !== "seconds" && !Number.isInteger(budget)) return { field: of.measure, wrong: `${of.measure === "generations" ? "Generations" : "Evaluations"} are a whole number.` };
  if (of.seed.trim() !== "" && !isWhole(of.seed)) return { field: "seed", wrong: "A seed is a whole number, or empty." };
  if (of.threads.trim() !== "" && !(isWhole(of.threads) && Number(of.threads) > 0)) return { field: "threads", wrong: "Threads are a whole number from 1 on, or empty for all." };
  /** @type {Record<string, unknown>} */
  const json = { kind: "fit", target: of.target.id, [of.measure]: budget };
  if (of.name.trim()) json.name = of.name.trim();
  if (of.strategy) json.strategy = of.strategy;
  // Seeds go beyond what a number of JavaScript holds; as text they arrive whole.
  if (of.seed.trim()) json.seed = of.seed.trim();
  if (of.threads.trim()) json.threads = Number(of.threads);
  if (of.mirrored) json.mirrored = true;
  if (of.into === "open" && open) json.lineage = open;
  if (of.start) json.start = [of.start.of.id];
  return { json };
}

/** The field that the last refusal was about. @type {Signal<string|null>} */
export const wrongField = signal(null);

/** Starts the search, and looks at it. */
export async function startSearch() {
  if (starting.value) return;
  const asked = requestOf(draft.value, lineage.value?.id ?? null);
  wrongField.value = null;
  if ("wrong" in asked) {
    wrongField.value = asked.field;
    tell("search", { problem: { title: "Not yet", status: 400, detail: asked.wrong } });
    return;
  }
  starting.value = true;
  try {
    await guarded("search", async () => {
      try {
        began(await api.createJob(asked.json));
      } catch (error) {
        wrongField.value = pointed(error);
        throw error;
      }
    });
  } finally {
    starting.value = false;
  }
}

/** The field that a refusal points to. @param {any} error */
const pointed = (error) => /^\/(\w+)/.exec(error?.problem?.pointer ?? "")?.[1] ?? null;

/** The next form begins with the same options, but is of nothing yet. @param {Job} job */
function began(job) {
  fill({ name: "", start: null, own: null });
  putJob(job);
  if (looking.value === NEW) openSearches(job.id);
}

/** What stands in the place of a name that nobody typed. */
export const placeholderName = () => (draft.value.target ? nameOfTarget(draft.value.target) : "the target's name");

/** The centre, as what a search may start from. */
export const centreAsStart = () => (large.value ? { of: large.value, name: "the centre" } : null);
