/**
 * Opening, making, renaming and hiding lineages, and showing their generations. Owns the road from an address to a shown
 * generation; knows nothing of breeding or drawing.
 *
 * @import { Generation, Lineage, Trail } from "./types.js"
 */
import { batch, effect, signal } from "./vendor/signals-core.js";
import * as api from "./api.js";
import * as events from "./events.js";
import { redoTarget, step, undoTarget } from "./history.js";
import { keep, recall } from "./memory.js";
import { ready, unready } from "./pictures.js";
import * as route from "./route.js";
import {
  DEFAULT_SATURATION, changeIndividual, descent, forget, generation, generations, knobs, lineage, lineages, lineagesOpen, locks, mate,
  noLocks, putGenerations, scene, sceneBusy, shown, system, tell, trail,
} from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** The scene that a generation's picture addresses were read for. @type {Map<string, string>} */
const readFor = new Map();
/** The newest wish wins over answers that come late. */
let wish = 0;

/** How many wishes there were: who waits for something sees whether somebody wanted something else meanwhile. */
export const wishes = () => wish;

/** What is under way, by its place. @type {Set<string>} */
const underWay = new Set();

/**
 * The same, once at a time: who asks twice is not given two.
 * @param {import("./types.js").Place} place
 * @param {() => Promise<void>} work
 */
export async function alone(place, work) {
  if (underWay.has(place)) return;
  underWay.add(place);
  await guarded(place, work);
  underWay.delete(place);
}

/** @param {() => Promise<void>} work @param {import("./types.js").Place} place */
export async function guarded(place, work) {
  try {
    forget(place);
    await work();
  } catch (error) {
    tell(place, { problem: api.problemOf(error), retry: () => void guarded(place, work) });
  }
}

/** Restores what the address says; without one, the newest lineage; without any, a new one. */
export async function start() {
  await guarded("stage", async () => {
    const wanted = route.parse(location.hash);
    [system.value, lineages.value] = await Promise.all([api.getSystem(), api.listLineages()]);
    if (!wanted.lineage) return openNewest();
    try {
      await open(wanted.lineage, wanted.generation);
    } catch (error) {
      if (![404, 410, 422, 400].includes(api.problemOf(error).status)) throw error;
      await openNewest();
      tell("stage", { problem: { title: "No such lineage", status: 404, detail: "The link names a lineage that this server does not have; the newest is shown." } });
    }
  });
}

/** Opens the newest lineage; a new one where there is none. */
function openNewest() {
  const [newest] = lineages.value.toSorted((a, b) => b.created_ms - a.created_ms);
  return newest ? open(newest.id, null) : create("first");
}

/**
 * @param {string} name
 * @param {{dialect?: Partial<import("./types.js").Dialect>, saturation?: number, begin?: (id: string) => Promise<void>}} [how] what it may
 *   use, and how it begins where not with a random brood
 */
export async function create(name, { dialect, saturation = DEFAULT_SATURATION, begin } = {}) {
  const made = await api.createLineage({ name, thumbnail_px: 256, saturation, dialect, scene: begin && scene.value?.id });
  lineages.value = [...lineages.value, made];
  await open(made.id, null, begin);
}

/** Hears of searches that tell the open lineage; put here by the module of searches, which depends on this one. */
let noteJob = (/** @type {any} */ _news) => {};

/** @param {(news: any) => void} note */
export function setJobNoter(note) {
  noteJob = note;
}

/** Breeds the first brood of an empty lineage; put here by the breeding module, which depends on this one. */
let breedFirst = async (/** @type {string} */ _id) => {};

/** @param {(id: string) => Promise<void>} breed */
export function setFirstBreeder(breed) {
  breedFirst = breed;
}

/** Whether it came about by variation: what a search found or somebody brought in says nothing of how to breed on. @param {Generation} of */
export const isBred = (of) => !["fit", "adopt"].includes(of.individuals[0]?.operator ?? "");

/**
 * @param {string} id
 * @param {string|null} wanted a generation; the newest where null
 * @param {(id: string) => Promise<void>} [begin] how it begins where it is empty; with a random brood unless said
 */
export async function open(id, wanted, begin = breedFirst) {
  const mine = ++wish;
  const [of, all] = await Promise.all([api.getLineage(id), api.listGenerations(id)]);
  const its = await api.getScene(of.scene);
  if (mine !== wish) return;
  unready();
  const newest = all.at(-1);
  const target = all.find((one) => one.id === wanted) ?? newest ?? null;
  const bred = target && isBred(target) ? target : null;
  readFor.clear();
  for (const one of all) readFor.set(one.id, of.scene);
  batch(() => {
    lineage.value = of;
    scene.value = its;
    generations.value = new Map(all.map((one) => [one.id, one]));
    shown.value = null;
    mate.value = null;
    trail.value = recall(`trail.${id}`, /** @type {Trail} */ ({ past: [], future: [] }), "sessionStorage");
    knobs.value = {
      mutation: bred?.mutation ?? 0.3,
      recombination: bred?.recombination ?? 0.5,
      isotropic: target?.constraints?.isotropic ?? of.dialect.isotropic ?? false,
      homogeneous: target?.constraints?.homogeneous ?? of.dialect.homogeneous ?? false,
      saturation: target?.saturation ?? of.saturation,
      energy_limit: target?.energy_limit ?? of.energy_limit,
      ...recall(`knobs.${id}`, {}),
    };
    locks.value = { ...noLocks(), ...recall(`locks.${id}`, {}) };
    lineagesOpen.value = false;
  });
  events.listen(id, { known: (one) => generations.value.has(one), news: adopt, changed, marked, resync, job: (news) => noteJob(news) });
  forget("stage");
  if (wanted && target?.id !== wanted) {
    tell("stage", {
      problem: { title: "Not in this lineage", status: 404, detail: "The link names a generation that this lineage does not have; the newest is shown." },
    });
  }
  if (target) await show(target.id, "visit");
  else await begin(id);
}

/**
 * Shows a generation of the open lineage.
 * @param {string} id
 * @param {"visit"|"undo"|"redo"} how
 */
export async function show(id, how) {
  const mine = ++wish;
  const of = lineage.value;
  if (!of || shown.value === id) return;
  if (readFor.get(id) !== of.scene) await readGeneration(id, of.scene);
  if (mine !== wish) return;
  unready();
  batch(() => {
    trail.value = step(trail.value, shown.value, id, how);
    shown.value = id;
    mate.value = null;
  });
  keep(`trail.${of.id}`, trail.value, "sessionStorage");
  route.write(of.id, id);
}

export const undo = () => move("undo", undoTarget(trail.value, descent.value, shown.value));
export const redo = () => move("redo", redoTarget(trail.value, descent.value, shown.value));

/** @param {"undo"|"redo"|"visit"} how @param {string|null} target */
async function move(how, target) {
  if (target) await guarded("stage", () => show(target, how));
}

/** @param {string} id */
export const visit = (id) => move("visit", id);

/** Follows an address that was typed, or the browser's own back and forward. */
export async function follow() {
  const wanted = route.parse(location.hash);
  if (!wanted.lineage) return;
  await guarded("stage", async () => {
    try {
      await go(/** @type {string} */ (wanted.lineage), wanted.generation);
    } catch (error) {
      // The address says what is shown, which is what is shared.
      if (lineage.value && shown.value) route.correct(lineage.value.id, shown.value);
      throw error;
    }
  });
}

/** @param {string} to a lineage @param {string|null} id */
async function go(to, id) {
  if (to !== lineage.value?.id) return open(to, id);
  if (!id || id === shown.value) return;
  if (id === undoTarget(trail.value, descent.value, shown.value)) return show(id, "undo");
  if (id === redoTarget(trail.value, descent.value, shown.value)) return show(id, "redo");
  return show(id, "visit");
}

/**
 * @param {string} id
 * @param {string} sceneId
 */
async function readGeneration(id, sceneId) {
  const read = await api.getGeneration(id);
  if (read.lineage !== lineage.value?.id) throw new api.ProblemError({ title: "Not in this lineage", status: 404, detail: "That generation belongs to another lineage." });
  readFor.set(id, sceneId);
  putGenerations([read]);
}

/** Reads the shown generation's picture addresses anew, where the scene is another than they were read for. */
export async function rereadShown() {
  const of = lineage.value;
  if (of && shown.value && readFor.get(shown.value) !== of.scene) await readGeneration(shown.value, of.scene);
}

/**
 * Takes in a generation that was just bred here.
 * @param {Generation} made
 * @param {string} sceneId the scene that the lineage had when it was asked for
 */
export function putBred(made, sceneId) {
  if (made.lineage !== lineage.value?.id) return;
  readFor.set(made.id, sceneId);
  putGenerations([made]);
}

/** A generation bred elsewhere: it joins the strip and is not shown unasked. @param {string} id */
async function adopt(id) {
  if (!lineage.value) return;
  await guarded("stage", () => readGeneration(id, lineage.value?.scene ?? ""));
  // Whoever bred it may have changed the scene too.
  await resync(false);
}

/** Somebody has changed the lineage; whoever did it here knows it already, or will in a moment. @param {number} version */
async function changed(version) {
  if (lineage.value && version > lineage.value.version) await resync(false);
}

/** @param {{id: string, favourite: boolean, note: string, version: number}} news */
function marked({ id, ...news }) {
  const known = [...generations.value.values()].flatMap((one) => [one.centre, ...one.individuals]).find((one) => one?.id === id);
  if (known && news.version > known.version) changeIndividual(id, news);
}

/** What is to be read once the scene has settled: what was read before is older than what is done here. @type {Signal<"nothing"|"some"|"all">} */
const behind = signal("nothing");

/**
 * What others did may not have been heard of: it is read, and what is shown stays.
 * @param {boolean} all whether marks of any individual may have changed, and not only the lineage, its scene and its generations
 */
async function resync(all) {
  const of = lineage.value;
  if (!of) return;
  await guarded("stage", async () => {
    const present = await api.getLineage(of.id);
    const [its, read] = await Promise.all([
      present.scene === scene.value?.id ? scene.value : api.getScene(present.scene),
      all || present.generations !== generations.value.size ? api.listGenerations(of.id) : [],
    ]);
    if (lineage.value?.id !== of.id) return;
    if (sceneBusy.value || present.version < lineage.value.version) {
      behind.value = all || behind.value === "all" ? "all" : "some";
      return;
    }
    for (const one of read) readFor.set(one.id, present.scene);
    batch(() => {
      lineage.value = present;
      scene.value = its;
      if (read.length > 0) putGenerations(read);
    });
    await rereadShown();
  });
}

/** @param {Lineage} of @param {string} name */
export async function rename(of, name) {
  const changed = await api.patchLineage(of, { name });
  lineages.value = lineages.value.map((one) => (one.id === changed.id ? changed : one));
  if (lineage.value?.id === changed.id) lineage.value = changed;
}

/** @param {Lineage} of */
export async function hide(of) {
  await api.hideLineage(of);
  lineages.value = lineages.value.filter((one) => one.id !== of.id);
  if (lineage.value?.id !== of.id) return;
  await openNewest();
}

/** Keeps the knobs of the open lineage and the title of the window, and asks who draws until that is known. */
export function watchLineage() {
  effect(() => {
    if (ready.value === null || !system.peek() || system.peek()?.backend) return;
    void guarded("stage", async () => {
      system.value = await api.getSystem();
    });
  });
  effect(() => {
    if (behind.value === "nothing" || sceneBusy.value) return;
    const all = behind.value === "all";
    behind.value = "nothing";
    queueMicrotask(() => void resync(all));
  });
  effect(() => {
    if (lineage.value) keep(`knobs.${lineage.value.id}`, knobs.value);
  });
  effect(() => {
    if (lineage.value) keep(`locks.${lineage.value.id}`, locks.value);
  });
  effect(() => {
    const name = lineage.value?.name;
    document.title = name ? `${name} · generation ${generation.value?.index ?? "-"} · brood` : "brood";
  });
}
