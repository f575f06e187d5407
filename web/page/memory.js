/** Settings that the browser keeps between visits. Without storage everything else works. */

/**
 * Where a setting is kept: from visit to visit, or as long as the tab is open. Browsers that refuse
 * storage throw even when it is named.
 *
 * @typedef {"localStorage"|"sessionStorage"} Storage_
 */

/**
 * @template T
 * @param {string} key
 * @param {T} fallback
 * @param {Storage_} [where]
 * @returns {T}
 */
export function loadSetting(key, fallback, where = "localStorage") {
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
 * @param {Storage_} [where]
 */
export function saveSetting(key, value, where = "localStorage") {
  try {
    globalThis[where].setItem(`brood.${key}`, JSON.stringify(value));
  } catch {
    // Storage is full or forbidden; the setting is lost.
  }
}
