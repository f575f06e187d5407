/**
 * Changes of the open lineage by other clients: read as events report them, without changing what
 * is shown.
 */
import { batch, effect } from "../vendor/signals-core.js";
import * as api from "../api/routes.js";
import { guarded } from "../page/problem.js";
import { sceneStore } from "../scene/store.js";
import { listenToLineage } from "./events.js";
import { readGeneration, refreshShown, storeOutlines, storeRead } from "./generations.js";
import { updateIndividual } from "./individuals.js";
import { isHistoryIncomplete, readOutlines } from "./outlines.js";
import { lineageStore } from "./store.js";

/** Follows the events of this lineage only. @param {string} id */
export function followChanges(id) {
  listenToLineage(id, {
    known: (one) => lineageStore.generations.value.has(one),
    onNewGeneration,
    onLineageChanged,
    onIndividualChanged,
    onJob: (news) => {
      lineageStore.jobNews.value = news;
    },
    resync,
  });
}

/**
 * Adds a generation that another client bred to the strip, without showing it.
 * @param {string} id
 */
async function onNewGeneration(id) {
  const of = lineageStore.lineage.value;
  if (!of) return;
  await guarded("stage", async () => {
    await readGeneration(id, of.scene);
    const centre = lineageStore.generations.value.get(id)?.centre;
    if (centre && !lineageStore.descent.value.parents.has(id)) await readBirth(centre.id);
  });
  // The other client may have changed the scene too.
  await resync(false);
}

/**
 * Reads the generation in which an individual was born, because the store has dropped it.
 * @param {string} id
 */
async function readBirth(id) {
  const { lineage, generation } = await api.getIndividual(id);
  const of = lineageStore.lineage.value;
  if (of?.id === lineage) await readGeneration(generation, of.scene);
}

/**
 * Reads the lineage again; changes by this page are known already and have no higher version.
 * @param {number} version
 */
async function onLineageChanged(version) {
  const of = lineageStore.lineage.value;
  if (of && version > of.version) await resync(false);
}

/** @param {{id: string, favourite: boolean, note: string, version: number}} news */
function onIndividualChanged({ id, ...news }) {
  const all = [...lineageStore.generations.value.values()];
  const born = all.flatMap(({ individuals }) => individuals).find((one) => one.id === id);
  const known = born ?? all.find(({ centre }) => centre?.id === id)?.centre;
  if (known && news.version > known.version) updateIndividual(id, news);
  // Lists of favourites show those that are held where they were born.
  if (news.favourite && !born) void guarded("stage", () => readBirth(id));
}

/**
 * Reads what other clients may have changed without an event.
 * @param {boolean} all true if marks of any individual may have changed, and not only the
 *   lineage, its scene and its list of generations
 */
async function resync(all) {
  const of = lineageStore.lineage.value;
  if (!of) return;
  await guarded("stage", async () => {
    const present = await api.getLineage(of.id);
    const isComplete =
      isHistoryIncomplete() || present.generations === lineageStore.generations.value.size;
    const shownId = lineageStore.shownId.value;
    const [scene, read, shown] = await Promise.all([
      present.scene === sceneStore.scene.value?.id
        ? sceneStore.scene.value
        : api.getScene(present.scene),
      all || !isComplete ? readOutlines(of.id) : [],
      all && shownId ? api.getGeneration(shownId) : null,
    ]);
    if (lineageStore.lineage.value?.id !== of.id) return;
    // What was read is older than the change on its way: read again once the scene has settled.
    if (sceneStore.busy.value || present.version < lineageStore.lineage.value.version) {
      const pending = lineageStore.pendingSync;
      pending.value = all || pending.value === "everything" ? "everything" : "lineage";
      return;
    }
    batch(() => {
      lineageStore.lineage.value = present;
      sceneStore.scene.value = scene;
      // Another generation may be shown by now; it is read below.
      const again = all && shownId === lineageStore.shownId.value;
      if (read.length > 0) storeOutlines(read, again);
      if (shown && again) storeRead([shown], present.scene);
    });
    await refreshShown();
  });
}

/** Catches up once the scene has settled. */
export function watchSync() {
  return effect(() => {
    const pending = lineageStore.pendingSync.value;
    if (pending === "nothing" || sceneStore.busy.value) return;
    lineageStore.pendingSync.value = "nothing";
    queueMicrotask(() => void resync(pending === "everything"));
  });
}
