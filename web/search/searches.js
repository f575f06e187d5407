/**
 * The dialog of searches: which view is open, its part of the address, and the list of searches.
 *
 * @import { Job } from "../model.js"
 */
import { effect, untracked } from "../vendor/signals-core.js";
import { lineageStore } from "../lineage/store.js";
import { clearProblems, guarded } from "../page/problem.js";
import * as route from "../page/route.js";
import { pageStore } from "../page/store.js";
import * as api from "./routes.js";
import { ALL, searchStore } from "./store.js";
import { hasEnded, stateInWords } from "./words.js";

/** @param {Job[]} news @param {Job[]} known */
function mergeJobs(news, known) {
  const ids = new Set(news.map(({ id }) => id));
  return [...news, ...known.filter(({ id }) => !ids.has(id))].sort(
    (a, b) => b.created_ms - a.created_ms,
  );
}

/**
 * Stores the state of searches, and announces one that has ended while the dialog is closed.
 * @param {Job[]} news
 */
function storeJobs(news) {
  const known = searchStore.jobs.peek() ?? [];
  const ended = news.find(
    (one) => hasEnded(one) && known.some((before) => before.id === one.id && !hasEnded(before)),
  );
  if (ended && searchStore.openView.peek() === null)
    pageStore.announcement.value = `The search ${ended.name} is ${stateInWords(ended.state)}.`;
  searchStore.jobs.value = mergeJobs(news, known);
}

/** @param {Job} of */
export const storeJob = (of) => storeJobs([of]);

async function readNewest() {
  const known = (searchStore.jobs.value ?? []).length;
  const { items, next } = await api.listJobs(null);
  // The list is merged with what was read before, so the cursor moves only if this page covers all
  // of it.
  if (known <= items.length) searchStore.nextCursor.value = next;
  storeJobs(items);
}

/** Reads the next page of the list. */
export const loadMore = () =>
  guarded("searches", async () => {
    const { items, next } = await api.listJobs(searchStore.nextCursor.value);
    storeJobs(items);
    searchStore.nextCursor.value = next;
  });

/**
 * Stores news of a search that the open lineage's events reported.
 * @param {{id: string, state: Job["state"], progress: number}} news
 */
function noteJob({ id, state, progress }) {
  const known = searchStore.jobs.value?.find((one) => one.id === id);
  if (known) storeJob({ ...known, state, progress });
  else void guarded("searches", async () => storeJob(await api.getJob(id)));
}

/** @param {string} [at] */
export function openSearches(at = ALL) {
  searchStore.openView.value = at;
}

export function closeSearches() {
  searchStore.openView.value = null;
  clearProblems("searches", "target", "search", "job", "found");
}

/** Opens the view that the address names. */
export function followSearchAddress() {
  const { search } = route.parse(location.hash);
  if (search !== searchStore.openView.value) searchStore.openView.value = search;
}

/** Keeps the address current, and the list while it is shown or a search runs. */
export function watchSearches() {
  effect(() => {
    const news = lineageStore.jobNews.value;
    if (news) untracked(() => noteJob(news));
  });
  effect(() => route.writeSearch(searchStore.openView.value));
  effect(() => {
    const wait_ms = searchStore.pollInterval_ms.value;
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
