/**
 * Opening, creating and hiding lineages, and following the address.
 *
 * @import { Dialect, Generation, Lineage, Scene, Start, Trail } from "../model.js"
 */
import { batch, effect } from "../vendor/signals-core.js";
import { problemOf } from "../api/request.js";
import * as api from "../api/routes.js";
import { loadSetting, saveSetting } from "../page/memory.js";
import { clearProblems, guarded, showProblem } from "../page/problem.js";
import * as route from "../page/route.js";
import { pageStore } from "../page/store.js";
import { environment } from "../scene/lights.js";
import { sceneStore } from "../scene/store.js";
import { breedNext } from "./breed.js";
import {
  beginNavigation, clearGenerations, isBred, navigationCount, redoId, show, storeBred,
  storeOutlines, storeRead, undoId,
} from "./generations.js";
import { readRest } from "./outlines.js";
import { clearReady, preloadPictures, startClock } from "./pictures.js";
import { DEFAULT_SATURATION, FRAMES, lineageStore, noLocks } from "./store.js";
import { followChanges } from "./sync.js";

/**
 * Opens what the address names; without an address the last lineage of this browser, or a new one.
 */
export async function openFromAddress() {
  await guarded("stage", async () => {
    const wanted = route.parse(location.hash);
    const readLists = async () => {
      [pageStore.serverInfo.value, lineageStore.lineages.value] = await Promise.all([
        api.getSystem(),
        api.listLineages(),
      ]);
    };
    const lists = readLists();
    if (!wanted.lineage) {
      await lists;
      return openOwn();
    }
    try {
      // At once, because each round trip to a server far away is seen.
      await Promise.all([lists, open(wanted.lineage, wanted.generation)]);
    } catch (error) {
      if (![404, 410, 422, 400].includes(problemOf(error).status)) throw error;
      await lists;
      await openOwn();
      showProblem("stage", {
        problem: {
          title: "No such lineage",
          status: 404,
          detail: "The link names a lineage that this server does not have; another is shown.",
        },
      });
    }
  }, true);
}

/**
 * Opens the lineage that this browser opened last. On a first visit, begins a new one: those in the
 * list are of other users.
 */
async function openOwn() {
  const last = loadSetting("lineage", /** @type {string|null} */ (null));
  const isListed = lineageStore.lineages.value.some(({ id }) => id === last);
  if (last && isListed) return open(last, null);
  const others = lineageStore.lineages.value.length;
  try {
    await create(untitled(lineageStore.lineages.value), STARTS.believable);
    pageStore.othersFound.value = others;
  } catch (error) {
    // A token for reading alone cannot begin one.
    if (problemOf(error).status !== 403 || others === 0) throw error;
    await openNewest();
  }
}

/** "Untitled 1", or the first number that no lineage has. @param {{name: string}[]} of */
export function untitled(of) {
  const names = new Set(of.map(({ name }) => name));
  let number = 1;
  while (names.has(`Untitled ${number}`)) number += 1;
  return `Untitled ${number}`;
}

/** Opens the newest lineage; a new one if there is none. */
function openNewest() {
  const [newest] = lineageStore.lineages.value.toSorted((a, b) => b.created_ms - a.created_ms);
  return newest ? open(newest.id, null) : create("Untitled 1", STARTS.believable);
}

/** Mutation with which children of a named material mostly still look like one. */
const NEAR = 0.1;

/**
 * Scene of a new lineage: an object with curves, a flat, a groove and a base, under a lamp.
 * @type {Partial<Scene>}
 */
const UNDER_LAMP = { mesh: "ball", lights: [{ kind: "point" }] };
/**
 * The same in the studio. Not for starts with many anisotropic or textured materials, whose
 * pictures take seconds in environments.
 * @type {Partial<Scene>}
 */
const IN_STUDIO = { mesh: "ball", lights: [{ kind: "point" }, environment("studio")] };

/**
 * True if first broods have a switch on. Believable programs begin even, although their dialect is
 * not: pictures of brushed and patterned ones take seconds in the studio and are not drawn live.
 * @param {Lineage} of
 * @param {"isotropic"|"homogeneous"} name
 */
const isEven = (of, name) => of.start === "believable" || (of.dialect[name] ?? false);

/**
 * Fills an empty lineage with the presets of its dialect.
 * @param {string} id
 */
const beginWithMaterials = (id) =>
  guarded("stage", async () => {
    const of = lineageStore.lineage.value;
    if (!of || of.id !== id) return;
    const startedAt = navigationCount();
    startClock();
    const all = await api.listPresets();
    const presets = all.filter(({ dialect }) => goesInto(of.dialect, dialect));
    const names = presets.map(({ name }) => name).slice(0, FRAMES);
    const made = await api.adopt(id, { presets: names });
    storeBred(made, of.scene);
    if (startedAt === navigationCount()) await show(made.id, "visit");
  });

/**
 * True if a lineage of programs accepts a material.
 * @param {Dialect} own
 * @param {Dialect} dialect
 */
export const goesInto = (own, dialect) =>
  dialect.length === 0 ||
  (dialect.length <= own.length &&
    dialect.opcodes === own.opcodes &&
    dialect.parametrisation === own.parametrisation &&
    dialect.registers === own.registers);

/** Breeds the first brood of an empty lineage at random. @param {string} id */
const beginAtRandom = (id) => breedNext(id, []);

/**
 * @param {string} name
 * @param {{start?: Start, dialect?: Partial<Dialect>, saturation?: number, energy_limit?: boolean,
 *   begin?: (id: string) => Promise<void>, first?: Partial<Scene>, scene?: string}} [how]
 *   `begin`: makes the first generation in place of a random brood; `scene`: id; default: that of
 *   the open lineage for a chosen material, else the new scene `first`
 */
export async function create(
  name,
  {
    start,
    dialect,
    saturation = DEFAULT_SATURATION,
    energy_limit = true,
    begin,
    first = UNDER_LAMP,
    scene: chosen,
  } = {},
) {
  const shown = begin && begin !== beginWithMaterials && sceneStore.scene.value?.id;
  const scene = chosen || shown || (await api.createScene(first)).id;
  const made = await api.createLineage({
    name, thumbnail_px: 256, saturation, start, dialect, scene, energy_limit,
  });
  lineageStore.lineages.value = [...lineageStore.lineages.value, made];
  await open(made.id, null, begin);
}

/**
 * Starting contents of a lineage.
 * @type {Record<Start|"presets", Parameters<typeof create>[1]>}
 */
export const STARTS = {
  believable: { start: "believable", saturation: 1, first: IN_STUDIO },
  presets: { saturation: 1, begin: beginWithMaterials },
  models: { start: "models", first: IN_STUDIO },
  // Painted materials have neither.
  painted: { start: "painted", saturation: 1, energy_limit: false },
  wild: { start: "wild" },
};

/**
 * A generation of this lineage; null if there is none with this id.
 * @param {string} lineage
 * @param {string} id
 */
async function findGeneration(lineage, id) {
  try {
    const found = await api.getGeneration(id);
    return found.lineage === lineage ? found : null;
  } catch (error) {
    if (![404, 410, 422, 400].includes(problemOf(error).status)) throw error;
    return null;
  }
}

/**
 * The generation to show, by default the newest. Its pictures are requested at once.
 * @param {Lineage} of
 * @param {Generation|null} asked
 * @param {() => boolean} isNewest
 */
async function readTarget(of, asked, isNewest) {
  const target = asked ?? (await api.getNewestGeneration(of));
  if (target && isNewest()) preloadPictures(target);
  return target;
}

/**
 * @param {string} id
 * @param {string|null} wanted a generation; null for the newest
 * @param {(id: string) => Promise<void>} [begin] makes the first generation of an empty lineage
 */
export async function open(id, wanted, begin = beginAtRandom) {
  const isNewest = beginNavigation();
  const [of, asked, outlines] = await Promise.all([
    api.getLineage(id),
    wanted ? findGeneration(id, wanted) : null,
    api.listOutlines(id, null),
  ]);
  const [target, scene] = await Promise.all([
    readTarget(of, asked, isNewest),
    api.getScene(of.scene),
  ]);
  if (!isNewest()) return;
  clearReady();
  const bred = target && isBred(target) ? target : null;
  batch(() => {
    lineageStore.lineage.value = of;
    sceneStore.scene.value = scene;
    lineageStore.shownId.value = null;
    clearGenerations();
    storeOutlines(outlines.items);
    if (target) storeRead([target], of.scene);
    lineageStore.mate.value = null;
    lineageStore.trail.value = loadSetting(
      `trail.${id}`,
      /** @type {Trail} */ ({ past: [], future: [] }),
      "sessionStorage",
    );
    lineageStore.knobs.value = {
      mutation: bred?.mutation ?? (begin === beginWithMaterials ? NEAR : 0.3),
      recombination: bred?.recombination ?? 0.5,
      isotropic: target?.constraints?.isotropic ?? isEven(of, "isotropic"),
      homogeneous: target?.constraints?.homogeneous ?? isEven(of, "homogeneous"),
      bumps: target?.constraints?.bumps ?? null,
      saturation: target?.saturation ?? of.saturation,
      energy_limit: target?.energy_limit ?? of.energy_limit,
      steer: bred?.steer ?? [],
      painting: bred?.painting ?? null,
      ...loadSetting(`knobs.${id}`, {}),
    };
    lineageStore.locks.value = { ...noLocks(), ...loadSetting(`locks.${id}`, {}) };
    pageStore.lineagesOpen.value = false;
  });
  followChanges(id);
  clearProblems("stage");
  void readRest(id, outlines.next);
  if (wanted && target?.id !== wanted) {
    showProblem("stage", {
      problem: {
        title: "Not in this lineage",
        status: 404,
        detail: "The link names a generation that this lineage does not have; the newest is shown.",
      },
    });
  }
  if (target) await show(target.id, "visit");
  else await begin(id);
}

/** Opens what the address names after it was typed or the browser went back or forward. */
export async function followAddress() {
  const wanted = route.parse(location.hash);
  if (!wanted.lineage) return;
  await guarded("stage", async () => {
    try {
      await goTo(/** @type {string} */ (wanted.lineage), wanted.generation);
    } catch (error) {
      // The address is what is shared, so it has to name what is shown.
      const [of, id] = [lineageStore.lineage.value, lineageStore.shownId.value];
      if (of && id) route.correct(of.id, id);
      throw error;
    }
  });
}

/** Shows a generation of any lineage. @param {string} to a lineage @param {string|null} id */
export async function goTo(to, id) {
  if (to !== lineageStore.lineage.value?.id) return open(to, id);
  if (!id || id === lineageStore.shownId.value) return;
  if (id === undoId()) return show(id, "undo");
  if (id === redoId()) return show(id, "redo");
  return show(id, "visit");
}

/** Stores a changed lineage in the list, and as the open one if it is. @param {Lineage} changed */
export function replaceListed(changed) {
  lineageStore.lineages.value = lineageStore.lineages.value.map((one) =>
    one.id === changed.id ? { ...one, ...changed } : one,
  );
  if (lineageStore.lineage.value?.id === changed.id) lineageStore.lineage.value = changed;
}

/** @param {Lineage} of */
export async function hide(of) {
  await api.hideLineage(of);
  lineageStore.lineages.value = lineageStore.lineages.value.filter((one) => one.id !== of.id);
  lineageStore.found.value = lineageStore.found.value.filter((one) => one.id !== of.id);
  if (lineageStore.lineage.value?.id !== of.id) return;
  await openNewest();
}

/**
 * Saves the knobs and locks of the open lineage, and keeps the title and the server's state
 * current.
 */
export function watchLineage() {
  effect(() => {
    // After a start, the server reports no backend before the first pictures.
    if (
      lineageStore.readyId.value === null ||
      !pageStore.serverInfo.peek() ||
      pageStore.serverInfo.peek()?.backend
    )
      return;
    void guarded("stage", async () => {
      pageStore.serverInfo.value = await api.getSystem();
    });
  });
  effect(() => {
    if (lineageStore.lineage.value)
      saveSetting(`knobs.${lineageStore.lineage.value.id}`, lineageStore.knobs.value);
  });
  effect(() => {
    if (lineageStore.lineage.value)
      saveSetting(`locks.${lineageStore.lineage.value.id}`, lineageStore.locks.value);
  });
  effect(() => {
    if (lineageStore.lineage.value) saveSetting("lineage", lineageStore.lineage.value.id);
  });
  effect(() => {
    const name = lineageStore.lineage.value?.name;
    document.title = name
      ? `${name} · generation ${lineageStore.generation.value?.index ?? "-"} · brood`
      : "brood";
  });
}
