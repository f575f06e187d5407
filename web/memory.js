/**
 * What this browser remembers between visits: knobs, uploaded meshes, the surround. Owns the keys' prefix; knows nothing of
 * what the values mean. A browser that refuses storage forgets, and nothing else changes.
 */

/**
 * @template T
 * @param {string} key
 * @param {T} fallback
 * @param {Storage} [from]
 * @returns {T}
 */
export function recall(key, fallback, from) {
  try {
    const text = (from ?? localStorage).getItem(`brood.${key}`);
    return text === null ? fallback : JSON.parse(text);
  } catch {
    return fallback;
  }
}

/**
 * @param {string} key
 * @param {unknown} value
 * @param {Storage} [into]
 */
export function keep(key, value, into) {
  try {
    (into ?? localStorage).setItem(`brood.${key}`, JSON.stringify(value));
  } catch {
    // Storage is full or forbidden: the page works on without a memory.
  }
}
