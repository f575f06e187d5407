/**
 * Which of the searches' views is open, and the list of searches. Owns the list's freshness and the part of the address that names
 * a search; knows nothing of drawing.
 *
 * @import { Job } from "./types.js"
 */
import { computed, effect, signal, untracked } from "./vendor/signals-core.js";
import { guarded, setJobNoter } from "./lineage.js";
import * as route from "./route.js";
import * as api from "./search_api.js";
import { hasEnded } from "./search_words.js";
import { announcement, forget } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** The views that are no search of their own. */
export const ALL = "all";
export const NEW = "new";
const FRESH_MS = 2000;

/** What is open: the list, the form, a search by its id; nothing where null. @type {Signal<string|null>} */
export const looking = signal(null);
/** Newest first. @type {Signal<Job[]|null>} */
export const jobs = signal(null);
/** Where the list goes on; null at its end. @type {Signal<string|null>} */
export const further = signal(null);
/** How many are not at their end, of those that are known. */
export const busy = computed(() => (jobs.value ?? []).filter((one) => one.state === "queued" || one.state === "running").length);

/** @param {Job[]} news @param {Job[]} known */
function together(news, known) {
  const ids = new Set(news.map(({ id }) => id));
  return [...news, ...known.filter(({ id }) => !ids.has(id))].sort((a, b) => b.created_ms - a.created_ms);
}

/** Takes in how a search stands now. @param {Job} of */
export function putJob(of) {
  if (jobs.peek() !== null) jobs.value = together([of], jobs.peek() ?? []);
}

async function readNewest() {
  const { items, next } = await api.listJobs(null);
  // What was read before lies behind the newest; where nothing does, this is the whole beginning.
  if ((jobs.value ?? []).length <= items.length) further.value = next;
  jobs.value = together(items, jobs.value ?? []);
}

/** Reads on where the list broke off. */
export const readFurther = () => guarded("searches", async () => {
  const { items, next } = await api.listJobs(further.value);
  jobs.value = together(jobs.value ?? [], items);
  further.value = next;
});

/** A search has told of itself to the open lineage, whether anybody looks at searches or not. @param {{id: string, state: Job["state"], progress: number}} news */
function noteJob({ id, state, progress }) {
  const known = jobs.value?.find((one) => one.id === id);
  if (!known) return;
  putJob({ ...known, state, progress });
  if (hasEnded({ state }) && !hasEnded(known) && looking.value === null) announcement.value = `The search ${known.name} has ended.`;
}

/** @param {string} [at] */
export function openSearches(at = ALL) {
  looking.value = at;
}

export function closeSearches() {
  looking.value = null;
  forget("searches", "target", "search", "job", "found");
}

/** Follows the address to the view that it names. */
export function followSearch() {
  const { search } = route.parse(location.hash);
  if (search !== looking.value) looking.value = search;
}

/** Keeps the address, and the list while it is looked at. */
export function watchSearches() {
  setJobNoter(noteJob);
  effect(() => route.writeSearch(looking.value));
  effect(() => {
    if (looking.value !== ALL) return;
    /** @type {ReturnType<typeof setTimeout>|undefined} */
    let timer;
    let left = false;
    const look = async () => {
      if (!document.hidden) await guarded("searches", readNewest);
      if (!left) timer = setTimeout(look, FRESH_MS);
    };
    untracked(() => void look());
    return () => {
      left = true;
      clearTimeout(timer);
    };
  });
}
