/**
 * A picture that is wanted, and may change before it is there: the last one stays to be seen until the next has come. Owns the waiting
 * and the quiet retries; knows nothing of what is drawn.
 */
import { computed, effect, signal } from "./vendor/signals-core.js";

const RETRIES = 5;

/**
 * @typedef {{url: string, of: string}} Wanted `of`: what it shows; the picture of another thing does not stay to be seen
 *
 * @typedef {{there: {readonly value: Wanted|null}, isComing: {readonly value: boolean}, isLost: {readonly value: boolean}, watch: () => void}} Arriving
 */

/** @param {() => Wanted|null} wanted read anew whenever what it reads changes @returns {Arriving} */
export function arriving(wanted) {
  const next = computed(wanted);
  /** @type {import("./vendor/signals-core.js").Signal<Wanted|null>} */
  const there = signal(null);
  const lost = signal("");
  let url = "";

  /** @param {Wanted} one @param {number} tried */
  function load(one, tried) {
    const image = new Image();
    image.addEventListener("load", () => {
      if (one.url === url) there.value = one;
    });
    image.addEventListener("error", () => {
      if (one.url !== url) return;
      if (tried < RETRIES) setTimeout(() => one.url === url && load(one, tried + 1), 500 * 2 ** tried);
      else lost.value = one.url;
    });
    image.src = one.url;
  }

  return {
    there,
    isComing: computed(() => next.value !== null && next.value.url !== there.value?.url && lost.value !== next.value.url),
    isLost: computed(() => next.value !== null && lost.value === next.value.url),
    watch() {
      effect(() => {
        const one = next.value;
        if (one?.url === url) return;
        url = one?.url ?? "";
        if (!one || there.peek()?.of !== one.of) there.value = null;
        if (one) load(one, 0);
      });
    },
  };
}
