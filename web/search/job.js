/**
 * The open search, that is the one in view: reads its state, log, front and target, follows its
 * events, and pauses, resumes or cancels it.
 *
 * @import { Found, Individual, Job, LogLine, Target } from "../model.js"
 */
import { batch, effect, untracked } from "../vendor/signals-core.js";
import { ProblemError } from "../api/request.js";
import { getIndividual, getLineage } from "../api/routes.js";
import { breedNext } from "../lineage/breed.js";
import { open } from "../lineage/open.js";
import { clearProblems, guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { leaveJob, listenToJob } from "./events.js";
import { mergeLines, progressLine } from "./log.js";
import * as api from "./routes.js";
import { closeSearches, storeJob } from "./searches.js";
import { ALL, NEW, searchStore } from "./store.js";
import { errorInWords, hasEnded, stateInWords } from "./words.js";

/** Last generation that was read from the log. Not from events, which leave gaps. */
let lastLogged = 0;

/** @param {Partial<Job>} news */
function updateJob(news) {
  if (!searchStore.job.value) return;
  searchStore.job.value = { ...searchStore.job.value, ...news };
  storeJob(searchStore.job.value);
}

/** Number of readings; an answer is dropped if a later reading has begun. */
let readCount = 0;

/** Reads what may have been missed. @param {string} id */
async function reread(id) {
  const mine = ++readCount;
  const [present, news, found] = await Promise.all([
    api.getJob(id),
    api.getLog(id, lastLogged),
    api.getFront(id),
  ]);
  if (searchStore.openView.value !== id || mine !== readCount) return;
  if (present.kind !== "fit")
    throw new ProblemError({
      title: "Not a search",
      status: 404,
      detail: "This id is of a job that renders pictures.",
    });
  lastLogged = Math.max(lastLogged, news.at(-1)?.generation ?? 0);
  batch(() => {
    const before = searchStore.job.value?.state;
    searchStore.job.value = present;
    searchStore.logLines.value = mergeLines(searchStore.logLines.value, news);
    searchStore.front.value = found.items;
    searchStore.spread.value = found.spread ?? null;
    storeJob(present);
    if (before && before !== present.state)
      searchStore.jobAnnouncement.value = `${present.name} is ${stateInWords(present.state)}.`;
  });
  if (hasEnded(present)) leaveJob();
  if (!searchStore.targetRead.value) void readTarget(present);
}

/** True if the scenes of the target have uncertainties, and their corrections are not known yet. */
const awaitsScenes = () =>
  (searchStore.target.value?.views ?? []).some(
    ({ refine, corrected }) => !corrected && Object.keys(refine ?? {}).length > 0,
  );

/**
 * Reads the target and the lineage, which may have been deleted after the search ended.
 * @param {Job} of
 */
async function readTarget(of) {
  const [to, born] = await Promise.allSettled([api.getTarget(of.target), getLineage(of.lineage)]);
  if (searchStore.job.value?.id !== of.id) return;
  batch(() => {
    searchStore.target.value = to.status === "fulfilled" ? to.value : null;
    searchStore.lineageScene.value = born.status === "fulfilled" ? born.value.scene : null;
    searchStore.targetRead.value = true;
  });
}

/** @param {string} id */
const followJob = (id) => {
  const again = () => void guarded("job", () => reread(id));
  listenToJob(id, {
    state: (news) => {
      if (news.state !== searchStore.job.value?.state)
        searchStore.jobAnnouncement.value = `${searchStore.job.value?.name} is ${stateInWords(news.state)}.`;
      updateJob(news);
      again();
    },
    progress: (news) =>
      batch(() => {
        const { progress, generation, evaluations, seconds, fitted, held } = news;
        updateJob({ progress, generation, evaluations, seconds, fitted, held });
        searchStore.logLines.value = mergeLines(searchStore.logLines.value, progressLine(news));
      }),
    best: (news) =>
      batch(() => {
        updateJob({ best: news });
        // The first result follows the correction of the scenes.
        const job = searchStore.job.value;
        if (job && awaitsScenes()) void readTarget(job);
        if (searchStore.job.value && !hasEnded(searchStore.job.value))
          searchStore.front.value = [news];
        searchStore.jobAnnouncement.value = `Better result: error ${errorInWords(news.e_log)}, ${news.operations} operations.`;
      }),
    reread: again,
  });
  again();
};

/** True while a change of the state is on its way. */
let changing = false;

/** @param {"pause"|"resume"|"cancel"} how */
export async function changeState(how) {
  const id = searchStore.job.value?.id;
  if (!id || changing) return;
  changing = true;
  searchStore.confirmingCancel.value = false;
  try {
    await guarded("job", async () => {
      const present = await api.changeJob(id, how);
      if (searchStore.job.value?.id !== id) return;
      searchStore.jobAnnouncement.value = `${present.name} is ${stateInWords(present.state)}.`;
      searchStore.job.value = present;
      storeJob(present);
      if (hasEnded(present)) await reread(id);
    });
  } finally {
    changing = false;
  }
}

/** Shows a result in its lineage. @param {Found} of */
export const showFound = (of) =>
  guarded("found", async () => {
    const { lineage, generation, slot } = await readIndividual(of);
    closeSearches();
    await open(lineage, generation);
    pageStore.focusedCell.value = slot < 20 ? slot : "centre";
  });

/** Breeds a brood around a result. @param {Found} of */
export const breedFound = (of) =>
  guarded("found", async () => {
    const { lineage, generation } = await readIndividual(of);
    closeSearches();
    await open(lineage, generation);
    await breedNext(lineage, [of.individual]);
  });

/** Opens the lineage of the results at its newest generation. @param {Job} of */
export const openLineageOf = (of) =>
  guarded("found", async () => {
    await open(of.lineage, null);
    closeSearches();
  });

/** @param {Found} of @returns {Promise<any>} */
async function readIndividual(of) {
  const known = searchStore.individuals.value.get(of.individual);
  if (known) return known;
  const found = await getIndividual(of.individual);
  searchStore.individuals.value = new Map(searchStore.individuals.value).set(of.individual, found);
  return found;
}

/** Clears the last search and follows the one that is open now. @param {string|null} id */
function switchTo(id) {
  leaveJob();
  lastLogged = 0;
  batch(() => {
    [
      searchStore.job.value,
      searchStore.logLines.value,
      searchStore.front.value,
      searchStore.pickedId.value,
      searchStore.jobAnnouncement.value,
      searchStore.confirmingCancel.value,
      searchStore.spread.value,
    ] = [null, [], [], null, "", false, null];
    [searchStore.target.value, searchStore.targetRead.value, searchStore.lineageScene.value] = [
      null,
      false,
      null,
    ];
  });
  clearProblems("job", "found");
  if (id !== null && id !== ALL && id !== NEW) followJob(id);
}

export function watchJob() {
  effect(() => {
    const id = searchStore.openView.value;
    untracked(() => switchTo(id));
  });
  effect(() => {
    const of = searchStore.chosenResult.value;
    if (of) untracked(() => void guarded("found", async () => void (await readIndividual(of))));
  });
}
