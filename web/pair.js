/**
 * Two pictures looked at one over the other: how much of the upper is seen. Owns the share of each pair and which pair the key X
 * flips; knows nothing of what the pictures are.
 */
import { computed, signal } from "./vendor/signals-core.js";
import { flipKey } from "./flip_key.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/**
 * @typedef {{share: Signal<number>, flipped: Signal<boolean>, seen: {readonly value: number}, key: ReturnType<typeof flipKey>}} Pair
 *   `share`: of the upper picture, 0 to 1, as it was set; `flipped`: the other is looked at; `seen`: what follows from both.
 */

/** @returns {Pair} */
export function pairOf() {
  const share = signal(0);
  const flipped = signal(false);
  // From in between a flip shows the upper one alone, which is what is looked for.
  const seen = computed(() => (flipped.value ? (share.value > 0.99 ? 0 : 1) : share.value));
  const key = flipKey(() => {
    flipped.value = !flipped.value;
  });
  return { share, flipped, seen, key };
}

/** Puts the lower picture alone into sight. @param {Pair} of */
export function rest(of) {
  of.share.value = 0;
  of.flipped.value = false;
}

/** The target's picture over its scene, as understood. */
export const understood = pairOf();
/** The target over what a search found. */
export const besideFound = pairOf();
