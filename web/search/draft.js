/**
 * Form of a new search: its options, and the request that they make. The form keeps its content
 * until a search is started.
 *
 * @import { PictureDraft } from "./views.js"
 * @import { Dialect, Individual, Job, Target, TargetKind } from "../model.js"
 */
import { lineageStore } from "../lineage/store.js";
import { guarded, showProblem } from "../page/problem.js";
import * as api from "./routes.js";
import { openSearches, storeJob } from "./searches.js";
import { NEW, searchStore } from "./store.js";
import { nameOfTarget } from "./words.js";

/**
 * @typedef {"seconds"|"generations"|"evaluations"} Measure
 *
 * @typedef {{file: File|null, kind: TargetKind|"", views: PictureDraft[], target: Target|null,
 *   own: string|null, name: string, strategy: string, objective: string, measure: Measure,
 *   seconds: string, generations: string, evaluations: string, seed: string, threads: string,
 *   islands: string, mirrored: boolean, into: "own"|"open",
 *   start: {of: Individual, name: string}|null}} Draft
 *   Numbers are as they are typed. `file`: the chosen file, or the first of several pictures;
 *   `views`: pictures with their settings; `own`: id of the target that this form has uploaded and
 *   that no search uses yet; `into`: results go to a lineage of their own or to the open one.
 */

/** Strategies of the server; none is sent unless one is chosen. */
export const STRATEGIES = ["hybrid", "lobes", "gp", "analytic"];

/** Objectives of the server; none is sent unless one is chosen. */
export const OBJECTIVES = [
  { name: "seen", words: "what pictures show: dark values count" },
  { name: "e_log", words: "E_log alone" },
];

/** True if a strategy fits lobes, whose objective can be chosen. @param {string} strategy */
export const hasObjective = (strategy) => ["", "hybrid", "lobes"].includes(strategy);

/** True if a strategy may have islands. @param {string} strategy */
export const hasIslands = (strategy) => ["", "hybrid", "gp"].includes(strategy);

/** @param {Partial<Draft>} change */
export function updateDraft(change) {
  searchStore.draft.value = { ...searchStore.draft.value, ...change };
}

/**
 * Starts the form from an individual, with results in its lineage.
 * @param {Individual} of
 * @param {string} name
 */
export function searchFrom(of, name) {
  // Genetic programs, which the server chooses if no other strategy can start from it, stay in its
  // dialect.
  updateDraft({ start: { of, name }, into: lineageStore.lineage.value ? "open" : "own" });
  openSearches(NEW);
}

/**
 * Reason why results of a search cannot be bred with the programs of a lineage; empty if they can.
 * The server decides in the end.
 * @param {Dialect} dialect
 */
export function dialectMismatch({ length, opcodes, registers }) {
  if (length === 0 || (opcodes === "extended" && registers === 16 && length >= 120)) return "";
  return `its programs (${opcodes}, ${registers} registers, ${length} instructions) are for another machine than a search's (extended, 16 registers, 120 instructions)`;
}

/** True if a text is a whole number. @param {string} text */
const isWhole = (text) => /^\d+$/.test(text.trim());

/**
 * Builds the request of a form, or returns the error of the form.
 * @param {Draft} of
 * @param {string|null} open the open lineage
 * @returns {{json: Record<string, unknown>}|{field: string, wrong: string}}
 */
export function requestOf(of, open) {
  if (!of.target)
    return {
      field: "target",
      wrong:
        of.kind === "image" && of.file
          ? "Read the pictures first."
          : "Choose a target first: a file, or one that the server has.",
    };
  const budget = Number(of[of.measure]);
  if (of[of.measure].trim() === "" || !(budget > 0))
    return { field: of.measure, wrong: `The budget must be a number of ${of.measure} above 0.` };
  if (of.measure !== "seconds" && !Number.isInteger(budget))
    return { field: of.measure, wrong: `The budget must be a whole number of ${of.measure}.` };
  if (of.seed.trim() !== "" && !isWhole(of.seed))
    return { field: "seed", wrong: "The seed must be a whole number, or empty." };
  if (of.threads.trim() !== "" && !(isWhole(of.threads) && Number(of.threads) > 0))
    return {
      field: "threads",
      wrong: "The number of threads must be a whole number of at least 1, or empty for all.",
    };
  const hasIslandsTyped = hasIslands(of.strategy) && of.islands.trim() !== "";
  if (hasIslandsTyped && !(isWhole(of.islands) && Number(of.islands) > 0))
    return {
      field: "islands",
      wrong: "The number of islands must be a whole number of at least 1, or empty for one.",
    };
  /** @type {Record<string, unknown>} */
  const json = { kind: "fit", target: of.target.id, [of.measure]: budget };
  if (of.name.trim()) json.name = of.name.trim();
  if (of.strategy) json.strategy = of.strategy;
  if (of.objective && hasObjective(of.strategy)) json.objective = of.objective;
  // Sent as text, because seeds may exceed the whole numbers that JavaScript represents.
  if (of.seed.trim()) json.seed = of.seed.trim();
  if (of.threads.trim()) json.threads = Number(of.threads);
  if (hasIslandsTyped) json.islands = Number(of.islands);
  if (of.mirrored) json.mirrored = true;
  if (of.into === "open" && open) json.lineage = open;
  if (of.start) json.start = [of.start.of.id];
  return { json };
}

/** Starts the search and opens its view. */
export async function startSearch() {
  if (searchStore.starting.value) return;
  const asked = requestOf(searchStore.draft.value, lineageStore.lineage.value?.id ?? null);
  searchStore.wrongField.value = null;
  if ("wrong" in asked) {
    searchStore.wrongField.value = asked.field;
    showProblem("search", {
      problem: { title: "The form is incomplete", status: 400, detail: asked.wrong },
    });
    return;
  }
  searchStore.starting.value = true;
  try {
    await guarded("search", async () => {
      try {
        onStarted(await api.createJob(asked.json));
      } catch (error) {
        searchStore.wrongField.value = fieldNamedBy(error);
        throw error;
      }
    });
  } finally {
    searchStore.starting.value = false;
  }
}

/** Field that a refusal names. @param {any} error */
const fieldNamedBy = (error) => /^\/(\w+)/.exec(error?.problem?.pointer ?? "")?.[1] ?? null;

/** Keeps the options for the next search, but not what it starts from. @param {Job} job */
function onStarted(job) {
  updateDraft({ name: "", start: null, own: null });
  storeJob(job);
  if (searchStore.openView.value === NEW) openSearches(job.id);
}

/** Name of a search whose name is left empty. */
export const placeholderName = () =>
  searchStore.draft.value.target
    ? nameOfTarget(searchStore.draft.value.target)
    : "the target's name";

/** The centre as the start of a search. */
export const centreAsStart = () =>
  lineageStore.centre.value ? { of: lineageStore.centre.value, name: "the centre" } : null;
