/**
 * The pictures of a search that is looked at: the find that is shown and the target beside it, under their own light or another. Owns
 * which are wanted; their waiting is arriving.js's, how they lie over each other pair.js's.
 *
 * @import { Found, Job, Target } from "./types.js"
 */
import { computed, effect, signal, untracked } from "./vendor/signals-core.js";
import * as api from "./api.js";
import { arriving } from "./arriving.js";
import { guarded } from "./lineage.js";
import { besideFound, rest } from "./pair.js";
import { besideTargetUrl, inViewUrl, ownPictureUrl, targetUrl, targetViewUrl } from "./search_api.js";
import { hasEnded } from "./search_words.js";
import { bornIn, chosen, isTargetKnown, job, target } from "./search_job.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

const SIDE_PX = 384;
/** While it still searches the next find comes soon. */
const QUICK_PX = 256;

/** Where the light is, in degrees around; as in its scene where null. @type {Signal<number|null>} */
export const light = signal(null);
/** While a hand has not let it go yet. @type {Signal<number|null>} */
export const heldLight = signal(null);
/** Which of the target's pictures is looked at. @type {Signal<number>} */
export const view = signal(0);
/** Scenes of the target's pictures as the server knows them, by target and picture. @type {Signal<Map<string, string>>} */
const scenes = signal(new Map());

/** @param {Target} of */
const isPictures = (of) => (of.views ?? []).length > 0;

/**
 * The pictures of a find and of its target that belong together.
 * @param {{of: Found|null, within: Job, to: Target|null, scene: string|null, view: number, viewScene: string|null, light: number|null}} what
 *   `scene`: of the find's lineage; `viewScene`: of the target's picture
 * @returns {{find: string|null, target: string|null}} null: there is none, or not yet
 */
export function pairUrls({ of, within, to, scene, view, viewScene, light }) {
  const size = hasEnded(within) ? SIDE_PX : QUICK_PX;
  if (to && isPictures(to)) {
    if (light === null) return { find: of && inViewUrl(of.individual, to.id, view), target: targetViewUrl(to.id, view) };
    return { find: of && viewScene && api.pictureUrl(of.individual, viewScene, SIDE_PX, light), target: null };
  }
  if (to && scene) return { find: of && besideTargetUrl(of.individual, to.id, scene, size, light), target: targetUrl(to.id, scene, size, light) };
  if (!of) return { find: null, target: null };
  const drawn = light === null && !hasEnded(within) && of.thumbnail;
  return { find: drawn || ownPictureUrl(of.individual, SIDE_PX, light), target: null };
}

/** @type {{readonly value: {find: string|null, target: string|null}}} */
const wanted = computed(() => {
  const [of, within, to] = [chosen.value, job.value, target.value];
  if (!within || !isTargetKnown.value) return { find: null, target: null };
  const viewScene = (to && scenes.value.get(`${to.id} ${view.value}`)) ?? null;
  return pairUrls({ of, within, to, scene: bornIn.value, view: view.value, viewScene, light: light.value });
});

/** What must change before a picture of before is wrong to be seen. */
const kept = () => `${target.value?.id} ${view.value} ${target.value && isPictures(target.value) ? light.value === null : ""}`;

export const findPicture = arriving(() => (wanted.value.find ? { url: wanted.value.find, of: kept() } : null));
export const targetPicture = arriving(() => (wanted.value.target ? { url: wanted.value.target, of: kept() } : null));

/** Whether there is a target to lie over the find. */
export const isPaired = computed(() => wanted.value.target !== null);

/** Looks at another picture of the target, as it was taken. @param {number} at */
export function lookAt(at) {
  view.value = at;
  light.value = null;
  heldLight.value = null;
}

/** The server draws a scene under another light where it knows the scene. @param {Target} of @param {number} at */
async function learnScene(of, at) {
  const known = of.views?.[at]?.scene;
  const key = `${of.id} ${at}`;
  if (!known || scenes.value.has(key)) return;
  const { id } = await api.createScene(known);
  if (id) scenes.value = new Map(scenes.value).set(key, id);
}

export function watchPicture() {
  findPicture.watch();
  targetPicture.watch();
  const looked = computed(() => job.value?.id);
  effect(() => {
    void looked.value;
    untracked(() => {
      lookAt(0);
      rest(besideFound);
    });
  });
  effect(() => {
    const [of, at] = [target.value, view.value];
    if (of && light.value !== null) untracked(() => void guarded("found", () => learnScene(of, at)));
  });
}
