/**
 * The target that the open lineage was searched for, compared with the centre while breeding by
 * eye.
 *
 * @import { Scene, Target } from "../model.js"
 */
import { computed, effect, untracked } from "../vendor/signals-core.js";
import { makeFlipKey } from "../compare/flip_key.js";
import { compareStore } from "../compare/store.js";
import { lineageStore } from "../lineage/store.js";
import { liveStore } from "../live/store.js";
import { pageStore } from "../page/store.js";
import { changeScene } from "../scene/edit.js";
import {
  besideTargetUrl, getTarget, inViewUrl, listJobsOf, targetUrl, targetViewUrl,
} from "./routes.js";
import { searchStore } from "./store.js";
import { nameOfTarget } from "./words.js";

/** @param {boolean} to */
export function showTarget(to) {
  const of = searchStore.activeTarget.value;
  if (!of) return;
  compareStore.flipped.value = false;
  compareStore.targetInCentre.value = to;
  pageStore.announcement.value = to
    ? `The centre shows the target, ${nameOfTarget(of)}.`
    : "The centre shows the individual.";
}

/** Key T, and the button that does the same. */
export const flipKeyTarget = makeFlipKey(() => showTarget(!compareStore.targetInCentre.value));

/** Makes the scene of the target's picture the lineage's scene. */
export function useTargetScene() {
  const wanted = searchStore.otherScene.value;
  if (wanted) void changeScene("activeTarget", () => wanted);
}

/** Side of the pictures while the light moves. */
const QUICK_PX = 256;

/**
 * The target's picture in place of the centre. While it is visible, its light follows the moving
 * light.
 * @param {number} size
 */
export function centreUrl(size) {
  const at = compareStore.targetInCentre.value ? liveStore.still.value : null;
  return at
    ? targetPictureUrl(at.sharp ? size : Math.min(size, QUICK_PX), at.degrees)
    : targetPictureUrl(size, null);
}

/**
 * The target under the scene's own light or another.
 * @param {number} size
 * @param {number|null} light_deg null for the scene's own
 */
export function targetPictureUrl(size, light_deg) {
  const [of, within] = [searchStore.activeTarget.value, lineageStore.lineage.value];
  if (!of || !within) return null;
  return searchStore.activeView.value === null
    ? targetUrl(of.id, within.scene, size, light_deg)
    : targetViewUrl(of.id, searchStore.activeView.value);
}

/** An individual drawn in the same scene as the target. @param {string} id @param {number} size */
export function centreLikeTargetUrl(id, size) {
  const [of, within] = [searchStore.activeTarget.value, lineageStore.lineage.value];
  if (!of || !within) return null;
  return searchStore.activeView.value === null
    ? besideTargetUrl(id, of.id, within.scene, size, null)
    : inViewUrl(id, of.id, searchStore.activeView.value);
}

/**
 * Reads the targets of a lineage, except those that were deleted since.
 * @param {string} id of the lineage
 */
async function read(id) {
  try {
    const searches = (await listJobsOf(id)).filter((job) => job.lineage === id);
    const found = await Promise.allSettled(
      [...new Set(searches.map((job) => job.target))].map(getTarget),
    );
    if (lineageStore.lineage.peek()?.id !== id) return;
    searchStore.lineageTargets.value = found.flatMap((one) =>
      one.status === "fulfilled" ? [one.value] : [],
    );
  } catch {
    // The page works without it; the next lineage tries again.
  }
}

export function watchActiveTarget() {
  const open = computed(() => lineageStore.lineage.value?.id ?? null);
  // Includes searches into this lineage that were started since it was opened.
  const known = computed(() =>
    (searchStore.jobs.value ?? [])
      .filter((job) => job.lineage === open.value)
      .map(({ id }) => id)
      .sort()
      .join(),
  );
  effect(() => {
    void open.value;
    untracked(() => {
      searchStore.lineageTargets.value = [];
      searchStore.chosenTarget.value = { id: null, view: 0 };
      compareStore.targetInCentre.value = false;
    });
  });
  effect(() => {
    const id = open.value;
    void known.value;
    if (id) untracked(() => void read(id));
  });
}
