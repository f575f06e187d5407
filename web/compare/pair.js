/**
 * Two pictures over each other: opacity of the upper one, and the flip between them.
 *
 * @import { Signal } from "../vendor/signals-core.js"
 */
import { computed, signal } from "../vendor/signals-core.js";
import { makeFlipKey } from "./flip_key.js";

/**
 * @typedef {{share: Signal<number>, flipped: Signal<boolean>, seen: {readonly value: number},
 *   key: ReturnType<typeof makeFlipKey>}} Pair `share`: opacity of the upper picture as it was set,
 *   0 to 1; `flipped`: true while the other picture is shown; `seen`: the resulting opacity.
 */

/** @returns {Pair} */
export function pairOf() {
  const share = signal(0);
  const flipped = signal(false);
  // A flip from a blend shows the upper picture alone.
  const seen = computed(() => (flipped.value ? (share.value > 0.99 ? 0 : 1) : share.value));
  const key = makeFlipKey(() => {
    flipped.value = !flipped.value;
  });
  return { share, flipped, seen, key };
}

/** Shows the lower picture alone. @param {Pair} of */
export function resetPair(of) {
  of.share.value = 0;
  of.flipped.value = false;
}
