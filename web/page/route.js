/**
 * The address: `#/lineage/<id>/generation/<id>` names what is shown. After it, `/search/<id>` names
 * the search that is open over it, or `/favourites/<lineage or all>` the list of favourites, so
 * that a reload or a shared link restores both.
 *
 * @typedef {{lineage: string|null, generation: string|null, search: string|null, favourites:
 *   string|null}} Address
 */

/** @param {string} hash @returns {Address} */
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
  /** @type {Address} */
  const found = { lineage: null, generation: null, search: null, favourites: null };
  for (let at = 0; at + 1 < parts.length; at += 2) {
    const part = parts[at];
    if (part === "lineage" || part === "generation" || part === "search" || part === "favourites")
      found[part] = decoded(parts[at + 1]);
  }
  return found;
}

/**
 * @param {string|null} lineage
 * @param {string|null} generation
 * @param {string|null} [search]
 * @param {string|null} [favourites]
 */
export function format(lineage, generation, search = null, favourites = null) {
  const part = (/** @type {string} */ name, /** @type {string|null} */ id) =>
    id ? `/${name}/${encodeURIComponent(id)}` : "";
  return `#${part("lineage", lineage)}${part("generation", generation)}${part("search", search)}${part("favourites", favourites)}`;
}

/**
 * Puts the address into the browser's history. Replaces the entry if it does not name a generation
 * yet. An open search or list of favourites stays in the address.
 * @param {string} lineage
 * @param {string|null} generation
 */
export function write(lineage, generation) {
  const present = parse(location.hash);
  const next = format(lineage, generation, present.search, present.favourites);
  if (location.hash === next) return;
  if (present.generation === null) history.replaceState(null, "", next);
  else history.pushState(null, "", next);
}

/**
 * Replaces an address that could not be opened by that of what is shown.
 * @param {string} lineage
 * @param {string} generation
 */
export function correct(lineage, generation) {
  const { search, favourites } = parse(location.hash);
  history.replaceState(null, "", format(lineage, generation, search, favourites));
}

/** Adds an open search to the address, or removes it. @param {string|null} search */
export function writeSearch(search) {
  const { lineage, generation, search: present, favourites } = parse(location.hash);
  if (search !== present)
    history.pushState(null, "", format(lineage, generation, search, favourites));
}

/** Adds the list of favourites to the address, or removes it. @param {string|null} favourites */
export function writeFavourites(favourites) {
  const { lineage, generation, search, favourites: present } = parse(location.hash);
  if (favourites !== present)
    history.pushState(null, "", format(lineage, generation, search, favourites));
}
