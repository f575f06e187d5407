/**
 * What the open lineage's finds were searched for, looked at beside what is bred by eye. Owns which target that is, which of its
 * pictures is meant, and whether it stands in the centre's place; knows nothing of drawing.
 *
 * @import { Scene, Target } from "./types.js"
 */
import { computed, effect, signal, untracked } from "./vendor/signals-core.js";
import { flipped, targetSeen } from "./compare.js";
import { flipKey } from "./flip_key.js";
import { still } from "./live/stills.js";
import { changeScene } from "./scene.js";
import { besideTargetUrl, getTarget, inViewUrl, listJobsOf, targetUrl, targetViewUrl } from "./search_api.js";
import { nameOfTarget } from "./search_words.js";
import { jobs } from "./searches.js";
import { announcement, lineage, scene } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** Targets whose searches' finds are born in the open lineage, that of the newest first. @type {Signal<Target[]>} */
export const soughtHere = signal([]);
/** The id of the one that a person chose, and which of its pictures. @type {Signal<{id: string|null, view: number}>} */
export const chosenSought = signal({ id: null, view: 0 });

/** The one that is meant. @type {{readonly value: Target|null}} */
export const sought = computed(() => soughtHere.value.find(({ id }) => id === chosenSought.value.id) ?? soughtHere.value[0] ?? null);

/** Its picture that is meant; null where it is measured, and drawn in any scene. */
export const soughtView = computed(() => {
  const views = sought.value?.views ?? [];
  return views.length > 0 ? Math.min(chosenSought.value.view, views.length - 1) : null;
});

/** @param {boolean} to */
export function showTarget(to) {
  const of = sought.value;
  if (!of) return;
  flipped.value = false;
  targetSeen.value = to;
  announcement.value = to ? `The centre shows the target, ${nameOfTarget(of)}.` : "The centre shows itself.";
}

/** T, and what does the same. */
export const keyOfTarget = flipKey(() => showTarget(!targetSeen.value));


/** The scene of its picture, where that is not the lineage's: then the two do not cover each other. @type {{readonly value: Scene|null}} */
export const otherScene = computed(() => {
  const wanted = soughtView.value === null ? null : (sought.value?.views?.[soughtView.value].scene ?? null);
  return wanted && scene.value && !isSame(wanted, scene.value) ? wanted : null;
});

/** Whether two scenes are drawn alike: the names of their fields may come in any order. @param {Scene} a @param {Scene} b */
export function isSame(a, b) {
  const { id: _, ...one } = a;
  const { id: __, ...other } = b;
  return canonical(one) === canonical(other);
}

/** @param {unknown} of @returns {string} */
function canonical(of) {
  if (Array.isArray(of)) return `[${of.map(canonical).join()}]`;
  if (typeof of !== "object" || of === null) return JSON.stringify(of) ?? "null";
  const fields = Object.entries(of).filter(([, value]) => value !== undefined && value !== null).sort(([a], [b]) => (a < b ? -1 : 1));
  return `{${fields.map(([name, value]) => `${JSON.stringify(name)}:${canonical(value)}`).join()}}`;
}

/** Breeds in the scene of the picture from now on. */
export function takeItsScene() {
  const wanted = otherScene.value;
  if (wanted) void changeScene("sought", () => wanted);
}

/** While the light moves, pictures come one after the other. */
const QUICK_PX = 256;

/** The target as the centre is drawn; where it is looked at, the light is where it is now. @param {number} size */
export function centreUrl(size) {
  const at = targetSeen.value ? still.value : null;
  return at ? targetPictureUrl(at.sharp ? size : Math.min(size, QUICK_PX), (scene.value?.light_deg ?? 0) + at.degrees) : targetPictureUrl(size, null);
}

/** The target under the scene's own light, or another. @param {number} size @param {number|null} light_deg */
export function targetPictureUrl(size, light_deg) {
  const [of, within] = [sought.value, lineage.value];
  if (!of || !within) return null;
  return soughtView.value === null ? targetUrl(of.id, within.scene, size, light_deg) : targetViewUrl(of.id, soughtView.value);
}

/** An individual as it is drawn beside that. @param {string} id @param {number} size */
export function besideSoughtUrl(id, size) {
  const [of, within] = [sought.value, lineage.value];
  if (!of || !within) return null;
  return soughtView.value === null ? besideTargetUrl(id, of.id, within.scene, size, null) : inViewUrl(id, of.id, soughtView.value);
}

/** Reads what was searched for; what is gone since is left out. @param {string} id of the lineage */
async function read(id) {
  try {
    const its = (await listJobsOf(id)).filter((job) => job.lineage === id);
    const found = await Promise.allSettled([...new Set(its.map((job) => job.target))].map(getTarget));
    if (lineage.peek()?.id !== id) return;
    soughtHere.value = found.flatMap((one) => (one.status === "fulfilled" ? [one.value] : []));
  } catch {
    // Without it everything else works; the next lineage asks again.
  }
}

export function watchSought() {
  const open = computed(() => lineage.value?.id ?? null);
  // Searches into this lineage that began since.
  const known = computed(() => (jobs.value ?? []).filter((job) => job.lineage === open.value).map(({ id }) => id).sort().join());
  effect(() => {
    void open.value;
    untracked(() => {
      soughtHere.value = [];
      chosenSought.value = { id: null, view: 0 };
      targetSeen.value = false;
    });
  });
  effect(() => {
    const id = open.value;
    void known.value;
    if (id) untracked(() => void read(id));
  });
}
