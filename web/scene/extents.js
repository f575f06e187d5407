/**
 * Bounding spheres of meshes: requested once each, from the head of the mesh.
 *
 * @import { Extent } from "../live/camera.js"
 */
import { getBeginning } from "../api/request.js";
import { HEAD_BYTES, readExtent } from "../live/geometry.js";
import { sceneStore } from "./store.js";

/** @param {string} mesh @returns {Promise<Extent>} */
export async function extentOf(mesh) {
  const known = sceneStore.extents.peek().get(mesh);
  if (known) return known;
  const extent = readExtent(await getBeginning(`/v1/meshes/${mesh}/geometry`, HEAD_BYTES));
  sceneStore.extents.value = new Map(sceneStore.extents.peek()).set(mesh, extent);
  return extent;
}
