/**
 * A picture whose address changes: the last one stays visible until the next has loaded. Retries
 * failed loads; independent of what is shown.
 *
 * @import { ReadonlySignal } from "../vendor/signals-core.js"
 */
import { computed, effect, signal } from "../vendor/signals-core.js";

/** Number of retries after which a picture counts as failed. */
const RETRIES = 5;
/** Delay between the retries of a failed picture. */
const SLOW_MS = 30_000;

/**
 * @typedef {{url: string, of: string}} PictureRequest
 *   `of`: what it shows; the picture of something else does not stay visible.
 *
 * @typedef {{current: ReadonlySignal<PictureRequest|null>, isLoading: ReadonlySignal<boolean>,
 *   isFailed: ReadonlySignal<boolean>, start: () => void}} LoadingPicture
 */

/**
 * Creates such a picture; `start` begins to follow the address.
 * @param {() => PictureRequest|null} wanted a function of signals
 * @returns {LoadingPicture}
 */
export function loadingPicture(wanted) {
  const next = computed(wanted);
  /** @type {import("../vendor/signals-core.js").Signal<PictureRequest|null>} */
  const current = signal(null);
  const failedUrl = signal("");
  let url = "";

  /** @param {PictureRequest} one @param {number} tried */
  function load(one, tried) {
    const image = new Image();
    image.addEventListener("load", () => {
      if (one.url !== url) return;
      failedUrl.value = "";
      current.value = one;
    });
    image.addEventListener("error", () => {
      if (one.url !== url) return;
      if (tried >= RETRIES) failedUrl.value = one.url;
      const delay = tried < RETRIES ? 500 * 2 ** tried : SLOW_MS;
      setTimeout(() => one.url === url && load(one, tried + 1), delay);
    });
    image.src = one.url;
  }

  return {
    current,
    isLoading: computed(
      () =>
        next.value !== null &&
        next.value.url !== current.value?.url &&
        failedUrl.value !== next.value.url,
    ),
    isFailed: computed(() => next.value !== null && failedUrl.value === next.value.url),
    start() {
      effect(() => {
        const one = next.value;
        if (one?.url === url) return;
        url = one?.url ?? "";
        if (!one || current.peek()?.of !== one.of) current.value = null;
        if (one) load(one, 0);
      });
    },
  };
}
