/**
 * The address: `#/lineage/<id>/generation/<id>` says what is shown, and `/search/<id>` behind it which search lies over it, so that
 * a reload or a shared link restores it. Owns the hash; knows nothing of what the ids stand for.
 */

/**
 * @param {string} hash
 * @returns {{lineage: string|null, generation: string|null, search: string|null}}
 */
export function parse(hash) {
  // A link may have been mangled on its way.
  const decoded = (/** @type {string} */ part) => {
    try {
      return decodeURIComponent(part);
    } catch {
      return part;
    }
  };
  const parts = hash.replace(/^#\/?/, "").split("/");
  /** @type {{lineage: string|null, generation: string|null, search: string|null}} */
  const found = { lineage: null, generation: null, search: null };
  for (let at = 0; at + 1 < parts.length; at += 2) {
    const part = parts[at];
    if (part === "lineage" || part === "generation" || part === "search") found[part] = decoded(parts[at + 1]);
  }
  return found;
}

/**
 * @param {string|null} lineage
 * @param {string|null} generation
 * @param {string|null} [search]
 */
export function format(lineage, generation, search = null) {
  const part = (/** @type {string} */ name, /** @type {string|null} */ id) => (id ? `/${name}/${encodeURIComponent(id)}` : "");
  return `#${part("lineage", lineage)}${part("generation", generation)}${part("search", search)}`;
}

/**
 * Puts the address into the browser's history, replacing the first one that led here without naming a state; a search that lies
 * over it stays.
 * @param {string} lineage
 * @param {string|null} generation
 */
export function write(lineage, generation) {
  const present = parse(location.hash);
  const next = format(lineage, generation, present.search);
  if (location.hash === next) return;
  if (present.generation === null) history.replaceState(null, "", next);
  else history.pushState(null, "", next);
}

/**
 * Says what is shown in place of an address that led nowhere.
 * @param {string} lineage
 * @param {string} generation
 */
export function correct(lineage, generation) {
  history.replaceState(null, "", format(lineage, generation, parse(location.hash).search));
}

/**
 * Puts a search over what is shown into the address, or takes it away.
 * @param {string|null} search
 */
export function writeSearch(search) {
  const { lineage, generation, search: present } = parse(location.hash);
  if (search !== present) history.pushState(null, "", format(lineage, generation, search));
}
