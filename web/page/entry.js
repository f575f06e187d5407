/** Entries of maps in signals. */

/**
 * Replaces an entry of a map in a signal by a new map.
 * @template K, V
 * @param {import("../vendor/signals-core.js").Signal<Map<K, V>>} of
 * @param {K} key
 * @param {V|null} to null to remove the entry
 */
export function setEntry(of, key, to) {
  const next = new Map(of.peek());
  if (to === null) next.delete(key);
  else next.set(key, to);
  of.value = next;
}
