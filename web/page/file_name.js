/** Names of downloaded files: of a lineage or search, with the beginning of a hash or id. */

/** Longest part of a name that is taken over. */
const MOST = 40;

/**
 * A name as part of a file name: letters and digits of any script, lower case, joined by hyphens.
 * @param {string} name
 */
export const slug = (name) =>
  name
    .normalize("NFKC")
    .toLowerCase()
    .replaceAll(/[^\p{L}\p{N}]+/gu, "-")
    .slice(0, MOST)
    .replaceAll(/^-+|-+$/g, "") || "material";

/**
 * Name of a file of an individual or a brood, such as "gold-7f3a.es300.glsl".
 * @param {string} name of the lineage or search
 * @param {string} mark hash or id; the last digits of an id and the first of a hash differ most
 * @param {string} ending without the dot
 */
export const fileName = (name, mark, ending) =>
  `${slug(name)}-${mark.includes("-") ? mark.slice(-4) : mark.slice(0, 4)}.${ending}`;
