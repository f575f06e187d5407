/**
 * The address: `#/lineage/<id>/generation/<id>` says what is shown, so that a reload or a shared link restores it. Owns the
 * hash; knows nothing of what the ids stand for.
 */

/**
 * @param {string} hash
 * @returns {{lineage: string|null, generation: string|null}}
 */
export function parse(hash) {
  const parts = hash.replace(/^#\/?/, "").split("/");
  const found = { lineage: /** @type {string|null} */ (null), generation: /** @type {string|null} */ (null) };
  for (let at = 0; at + 1 < parts.length; at += 2) {
    if (parts[at] === "lineage") found.lineage = decodeURIComponent(parts[at + 1]);
    if (parts[at] === "generation") found.generation = decodeURIComponent(parts[at + 1]);
  }
  return found;
}

/**
 * @param {string} lineage
 * @param {string|null} generation
 */
export function format(lineage, generation) {
  const tail = generation ? `/generation/${encodeURIComponent(generation)}` : "";
  return `#/lineage/${encodeURIComponent(lineage)}${tail}`;
}

/**
 * Puts the address into the browser's history, replacing the first one that led here without naming a state.
 * @param {string} lineage
 * @param {string|null} generation
 */
export function write(lineage, generation) {
  const next = format(lineage, generation);
  if (location.hash === next) return;
  if (parse(location.hash).generation === null) history.replaceState(null, "", next);
  else history.pushState(null, "", next);
}
