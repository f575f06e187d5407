/**
 * What this browser remembers between visits: knobs, uploaded meshes, the surround. Owns the keys' prefix; knows nothing of
 * what the values mean. A browser that refuses storage forgets, and nothing else changes.
 */

/**
 * For how long: from visit to visit, or as long as the tab is open. Where storage is refused, even naming it throws.
 * @typedef {"localStorage"|"sessionStorage"} Kept
 */

/**
 * @template T
 * @param {string} key
 * @param {T} fallback
 * @param {Kept} [where]
 * @returns {T}
 */
export function recall(key, fallback, where = "localStorage") {
  try {
    const text = globalThis[where].getItem(`brood.${key}`);
    return text === null ? fallback : JSON.parse(text);
  } catch {
    return fallback;
  }
}

/**
 * @param {string} key
 * @param {unknown} value
 * @param {Kept} [where]
 */
export function keep(key, value, where = "localStorage") {
  try {
    globalThis[where].setItem(`brood.${key}`, JSON.stringify(value));
  } catch {
    // Storage is full or forbidden: the page works on without a memory.
  }
}
