/**
 * Pictures of the open search: the shown result and the target beside it, under their own light or
 * another one.
 *
 * @import { Target } from "../model.js"
 */
import { computed, effect, untracked } from "../vendor/signals-core.js";
import * as api from "../api/routes.js";
import { resetPair } from "../compare/pair.js";
import { guarded } from "../page/problem.js";
import { loadingPicture } from "./loading_picture.js";
import { isPictures } from "./pair_urls.js";
import { searchStore } from "./store.js";

/**
 * Identity of what the pictures show: a picture of something else is hidden while the next one
 * loads.
 */
function pictureSubject() {
  const target = searchStore.target.value;
  const ownLight = target && isPictures(target) ? searchStore.pictureLight.value === null : "";
  return `${target?.id} ${searchStore.pictureView.value} ${ownLight}`;
}

/** @param {"find"|"target"} which */
const requested = (which) => () => {
  const url = searchStore.pictureUrls.value[which];
  return url ? { url, of: pictureSubject() } : null;
};

export const findPicture = loadingPicture(requested("find"));
export const targetPicture = loadingPicture(requested("target"));

/** Looks at one of the target's pictures under its own light. @param {number} at */
export function lookAt(at) {
  searchStore.pictureView.value = at;
  searchStore.pictureLight.value = null;
  searchStore.draggedLight.value = null;
}

/**
 * Stores the scene of a target's picture, so that the server can draw it under another light.
 * @param {Target} of
 * @param {number} at
 */
async function storeViewScene(of, at) {
  const known = of.views?.[at]?.scene;
  const key = `${of.id} ${at}`;
  if (!known || searchStore.viewScenes.value.has(key)) return;
  const { id } = await api.createScene(known);
  if (id) searchStore.viewScenes.value = new Map(searchStore.viewScenes.value).set(key, id);
}

export function watchPictures() {
  findPicture.start();
  targetPicture.start();
  const jobId = computed(() => searchStore.job.value?.id);
  effect(() => {
    void jobId.value;
    untracked(() => {
      lookAt(0);
      resetPair(searchStore.foundPair);
    });
  });
  effect(() => {
    const [of, at] = [searchStore.target.value, searchStore.pictureView.value];
    if (of && searchStore.pictureLight.value !== null)
      untracked(() => void guarded("found", () => storeViewScene(of, at)));
  });
}
