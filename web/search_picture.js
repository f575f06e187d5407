/**
 * The picture of the find that is shown, under its own light or another: the last one stays to be seen until the next is there. Owns
 * the waiting and the quiet retries; knows nothing of drawing.
 */
import { computed, effect, signal } from "./vendor/signals-core.js";
import { ownPictureUrl } from "./search_api.js";
import { hasEnded } from "./search_words.js";
import { chosen, job } from "./search_job.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

const SIDE_PX = 384;
const RETRIES = 5;

/** Where the light is, in degrees around; as in its lineage where null. @type {Signal<number|null>} */
export const light = signal(null);
/** While a hand has not let it go yet. @type {Signal<number|null>} */
export const heldLight = signal(null);
/** What is there. @type {Signal<{url: string, individual: string}|null>} */
export const picture = signal(null);

/** What should be: while it still searches, the small picture that is drawn anyway. @type {Signal<{url: string, individual: string}|null>} */
const wanted = computed(() => {
  const of = chosen.value;
  if (!of) return null;
  const plain = light.value === null && job.value && !hasEnded(job.value) && of.thumbnail;
  return { url: plain || ownPictureUrl(of.individual, SIDE_PX, light.value), individual: of.individual };
});

/** Whether it is on its way. */
export const isComing = computed(() => wanted.value !== null && wanted.value.url !== picture.value?.url);

let url = "";

export function watchPicture() {
  effect(() => {
    const next = wanted.value;
    if (next?.url === url) return;
    url = next?.url ?? "";
    if (!next) picture.value = null;
    else load(next, 0);
  });
}

/** @param {{url: string, individual: string}} next @param {number} tried */
function load(next, tried) {
  const image = new Image();
  image.addEventListener("load", () => {
    if (next.url === url) picture.value = next;
  });
  image.addEventListener("error", () => {
    if (tried < RETRIES) setTimeout(() => next.url === url && load(next, tried + 1), 500 * 2 ** tried);
  });
  image.src = next.url;
}
