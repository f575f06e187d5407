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
import { hasEnded, stateInWords } from "./search_words.js";
import { announcement, forget } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** The views that are no search of their own. */
export const ALL = "all";
export const NEW = "new";
/** So often the list is read while it is looked at, and while it is not but a search goes on. */
const FRESH_MS = 2000;
const BEHIND_MS = 8000;

/** What is open: the list, the form, a search by its id; nothing where null. @type {Signal<string|null>} */
export const looking = signal(null);
/** Newest first. @type {Signal<Job[]|null>} */
export const jobs = signal(null);
/** Where the list goes on; null at its end. @type {Signal<string|null>} */
export const further = signal(null);
/** How many are not at their end, of those that are known. */
export const busy = computed(() => (jobs.value ?? []).filter((one) => one.state === "queued" || one.state === "running").length);

const pace_ms = computed(() => (looking.value === ALL ? FRESH_MS : busy.value > 0 ? BEHIND_MS : 0));

/** @param {Job[]} news @param {Job[]} known */
function together(news, known) {
  const ids = new Set(news.map(({ id }) => id));
  return [...news, ...known.filter(({ id }) => !ids.has(id))].sort((a, b) => b.created_ms - a.created_ms);
}

/** Takes in how searches stand now, and says which have ended unseen. @param {Job[]} news */
function learn(news) {
  const known = jobs.peek() ?? [];
  const ended = news.find((one) => hasEnded(one) && known.some((before) => before.id === one.id && !hasEnded(before)));
  if (ended && looking.peek() === null) announcement.value = `The search ${ended.name} is ${stateInWords(ended.state)}.`;
  jobs.value = together(news, known);
}

/** @param {Job} of */
export const putJob = (of) => learn([of]);

async function readNewest() {
  const known = (jobs.value ?? []).length;
  const { items, next } = await api.listJobs(null);
  // What was read before lies behind the newest; where nothing does, this is the whole beginning.
  if (known <= items.length) further.value = next;
  learn(items);
}

/** Reads on where the list broke off. */
export const readFurther = () => guarded("searches", async () => {
  const { items, next } = await api.listJobs(further.value);
  learn(items);
  further.value = next;
});

/** A search has told of itself to the open lineage. @param {{id: string, state: Job["state"], progress: number}} news */
function noteJob({ id, state, progress }) {
  const known = jobs.value?.find((one) => one.id === id);
  if (known) putJob({ ...known, state, progress });
  else void guarded("searches", async () => putJob(await api.getJob(id)));
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
    const wait_ms = pace_ms.value;
    if (wait_ms === 0) return;
    /** @type {ReturnType<typeof setTimeout>|undefined} */
    let timer;
    let left = false;
    const look = async () => {
      if (!document.hidden) await guarded("searches", readNewest);
      if (!left) timer = setTimeout(look, wait_ms);
    };
    untracked(() => void look());
    return () => {
      left = true;
      clearTimeout(timer);
    };
  });
}
