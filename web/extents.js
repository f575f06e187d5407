/**
 * How large objects are, by mesh: asked for once, and only the head of a mesh is read. Owns what is known; knows nothing of what
 * is counted in it.
 *
 * @import { Extent } from "./live/view.js"
 */
import { signal } from "./vendor/signals-core.js";
import { getBeginning } from "./api.js";
import { HEAD_BYTES, readExtent } from "./live/geometry.js";

/** @type {import("./vendor/signals-core.js").Signal<Map<string, Extent>>} */
export const extents = signal(new Map());

/** @param {string} mesh @returns {Promise<Extent>} */
export async function extentOf(mesh) {
  const known = extents.peek().get(mesh);
  if (known) return known;
  const extent = readExtent(await getBeginning(`/v1/meshes/${mesh}/geometry`, HEAD_BYTES));
  extents.value = new Map(extents.peek()).set(mesh, extent);
  return extent;
}
