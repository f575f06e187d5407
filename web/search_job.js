/**
 * The search that is looked at: how it stands, its course, its front, and which find is chosen. Owns what is known of it and keeps
 * it fresh; knows nothing of drawing.
 *
 * @import { Found, Individual, Job, LogLine, Target } from "./types.js"
 */
import { batch, computed, effect, signal, untracked } from "./vendor/signals-core.js";
import { ProblemError, getIndividual, getLineage } from "./api.js";
import { breedNext } from "./breed.js";
import { guarded, open } from "./lineage.js";
import * as api from "./search_api.js";
import { leaveJob, listenToJob } from "./search_events.js";
import { lineOf, merged } from "./search_log.js";
import { errorInWords, hasEnded, stateInWords } from "./search_words.js";
import { ALL, NEW, closeSearches, looking, putJob } from "./searches.js";
import { focused, forget } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** @type {Signal<Job|null>} */
export const job = signal(null);
/** @type {Signal<Target|null>} */
export const target = signal(null);
/** Whether the server has answered what the target is; it may be gone. @type {Signal<boolean>} */
export const isTargetKnown = signal(false);
/** The scene of the lineage where finds are born. @type {Signal<string|null>} */
export const bornIn = signal(null);
/** @type {Signal<LogLine[]>} */
export const lines = signal([]);
/** The best first. @type {Signal<Found[]>} */
export const front = signal([]);
/** The individual that a person chose; the best where null. @type {Signal<string|null>} */
export const picked = signal(null);
/** What a screen reader is told while the view is open. @type {Signal<string>} */
export const told = signal("");
/** Whether a person is asked about ending it. @type {Signal<boolean>} */
export const ending = signal(false);
/** Individuals by id, as far as they were chosen. @type {Signal<Map<string, Individual & {lineage?: string, generation?: string}>>} */
export const individuals = signal(new Map());

/** The find that is shown. @type {Signal<Found|null>} */
export const chosen = computed(() => front.value.find(({ individual }) => individual === picked.value) ?? front.value[0] ?? job.value?.best ?? null);

/** The last generation that the log itself told; events leave gaps. */
let logged = 0;

/** @param {Partial<Job>} news */
function put(news) {
  if (!job.value) return;
  job.value = { ...job.value, ...news };
  putJob(job.value);
}

/** How often it was read; an answer that comes after that of a later reading is of no use. */
let reading = 0;

/** Reads what may have been missed. @param {string} id */
async function reread(id) {
  const mine = ++reading;
  const [present, news, found] = await Promise.all([api.getJob(id), api.getLog(id, logged), api.getFront(id)]);
  if (looking.value !== id || mine !== reading) return;
  if (present.kind !== "fit") throw new ProblemError({ title: "No search", status: 404, detail: "This id is of a job that draws pictures." });
  logged = Math.max(logged, news.at(-1)?.generation ?? 0);
  batch(() => {
    const before = job.value?.state;
    job.value = present;
    lines.value = merged(lines.value, news);
    front.value = found;
    putJob(present);
    if (before && before !== present.state) told.value = `${present.name} is ${stateInWords(present.state)}.`;
  });
  if (hasEnded(present)) leaveJob();
  if (!isTargetKnown.value) void readTarget(present);
}

/** The target may be gone after the search has ended, and so may the lineage; then nothing is told of them. @param {Job} of */
async function readTarget(of) {
  const [to, born] = await Promise.allSettled([api.getTarget(of.target), getLineage(of.lineage)]);
  if (job.value?.id !== of.id) return;
  batch(() => {
    target.value = to.status === "fulfilled" ? to.value : null;
    bornIn.value = born.status === "fulfilled" ? born.value.scene : null;
    isTargetKnown.value = true;
  });
}

/** @param {string} id */
const follow = (id) => {
  const again = () => void guarded("job", () => reread(id));
  listenToJob(id, {
    state: (news) => {
      if (news.state !== job.value?.state) told.value = `${job.value?.name} is ${stateInWords(news.state)}.`;
      put(news);
      again();
    },
    progress: (news) => batch(() => {
      const { progress, generation, evaluations, seconds, fitted, held } = news;
      put({ progress, generation, evaluations, seconds, fitted, held });
      lines.value = merged(lines.value, lineOf(news));
    }),
    best: (news) => batch(() => {
      put({ best: news });
      if (job.value && !hasEnded(job.value)) front.value = [news];
      told.value = `A better one: error ${errorInWords(news.e_log)}, ${news.operations} operations.`;
    }),
    reread: again,
  });
  again();
};

/** A change of the state is on its way. */
let changing = false;

/** @param {"pause"|"resume"|"cancel"} how */
export async function change(how) {
  const id = job.value?.id;
  if (!id || changing) return;
  changing = true;
  ending.value = false;
  try {
    await guarded("job", async () => {
      const present = await api.changeJob(id, how);
      if (job.value?.id !== id) return;
      told.value = `${present.name} is ${stateInWords(present.state)}.`;
      job.value = present;
      putJob(present);
      if (hasEnded(present)) await reread(id);
    });
  } finally {
    changing = false;
  }
}

/** Shows a find where it was born, its lineage open below. @param {Found} of */
export const showFound = (of) => guarded("found", async () => {
  const { lineage, generation, slot } = await individual(of);
  closeSearches();
  await open(lineage, generation);
  focused.value = slot < 20 ? slot : "centre";
});

/** A brood around a find. @param {Found} of */
export const breedFound = (of) => guarded("found", async () => {
  const { lineage, generation } = await individual(of);
  closeSearches();
  await open(lineage, generation);
  await breedNext(lineage, [of.individual]);
});

/** Opens the lineage of the finds at its newest. @param {Job} of */
export const openLineageOf = (of) => guarded("found", async () => {
  await open(of.lineage, null);
  closeSearches();
});

/** @param {Found} of @returns {Promise<any>} */
async function individual(of) {
  const known = individuals.value.get(of.individual);
  if (known) return known;
  const found = await getIndividual(of.individual);
  individuals.value = new Map(individuals.value).set(of.individual, found);
  return found;
}

/** Forgets the search before, and follows the one that is looked at now. @param {string|null} id */
function turnTo(id) {
  leaveJob();
  logged = 0;
  batch(() => {
    [job.value, lines.value, front.value, picked.value, told.value, ending.value] = [null, [], [], null, "", false];
    [target.value, isTargetKnown.value, bornIn.value] = [null, false, null];
  });
  forget("job", "found");
  if (id !== null && id !== ALL && id !== NEW) follow(id);
}

export function watchJob() {
  effect(() => {
    const id = looking.value;
    untracked(() => turnTo(id));
  });
  effect(() => {
    const of = chosen.value;
    if (of) untracked(() => void guarded("found", async () => void (await individual(of))));
  });
}
