/**
 * Images of the scene: the picture of the backdrop, and normal maps. A file is uploaded, and the
 * scene then names it.
 *
 * @import { NormalMap, Place, Scene } from "../model.js"
 * @import { Part } from "./normal_map.js"
 */
import * as api from "../api/routes.js";
import { lineageStore } from "../lineage/store.js";
import { clearProblems, guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { uprightFile } from "../photo/decode.js";
import { changeScene, commitDragged, setBackdrop } from "./edit.js";
import { PLAIN, normalMapOf, withNormalMap } from "./normal_map.js";
import { sceneStore } from "./store.js";
import { stopUpload, uploadFile } from "./upload.js";

/** Where uploads and problems of the normal map of a part are shown. @type {Record<Part, Place>} */
export const NORMAL_MAP_PLACES = {
  subject: "normalMap",
  neighbour: "neighbourNormalMap",
  ground: "groundNormalMap",
};

/**
 * Uploads an image, and changes the scene of the lineage that was open then.
 * @param {Place} place
 * @param {File} file
 * @param {(file: File) => Promise<File>} prepared the file to send
 * @param {(scene: Scene, image: string) => Partial<Scene>} change
 */
function uploadImage(place, file, prepared, change) {
  clearProblems(place);
  pageStore.announcement.value = `Reading ${file.name}.`;
  const of = lineageStore.lineage.value?.id;
  return guarded(place, async () => {
    const made = await uploadFile(place, file, async (one, send) =>
      api.createImage(await prepared(one), send),
    );
    if (!made || lineageStore.lineage.value?.id !== of) return;
    await changeScene(place, (scene) => change(scene, made.id));
  });
}

/** Shows a picture behind the object. @param {File} file */
export async function openBackdrop(file) {
  sceneStore.pictureAwaited.value = lineageStore.lineage.value?.id ?? "";
  await uploadImage("backdrop", file, uprightFile, (_, image) => ({
    backdrop: { kind: "image", image },
  }));
  // After a failure the choice is again that of the scene.
  if (!sceneStore.uploads.value.has("backdrop")) sceneStore.pictureAwaited.value = "";
}

/** Offers to open a picture for the backdrop. */
export function awaitPicture() {
  clearProblems("backdrop");
  sceneStore.pictureAwaited.value = lineageStore.lineage.value?.id ?? "";
}

/** True if a picture for the backdrop is to be opened. Tracks signals. */
export const isPictureAwaited = () =>
  sceneStore.pictureAwaited.value !== "" &&
  sceneStore.pictureAwaited.value === lineageStore.lineage.value?.id;

/**
 * Shows something else than a picture behind the object.
 * @param {import("../model.js").Backdrop|null} backdrop
 */
export function chooseBackdrop(backdrop) {
  stopUpload("backdrop");
  clearProblems("backdrop");
  sceneStore.pictureAwaited.value = "";
  if (sceneStore.editedScene.value?.backdrop?.kind !== backdrop?.kind) void setBackdrop(backdrop);
}

/**
 * Gives a part a normal map, as strong as the one before.
 * @param {Part} part
 * @param {File} file
 */
export const openNormalMap = (part, file) =>
  uploadImage(NORMAL_MAP_PLACES[part], file, async (one) => one, (scene, image) =>
    withNormalMap(scene, part, { ...PLAIN, ...normalMapOf(scene, part), image }));

/** @param {Part} part */
export function removeNormalMap(part) {
  const place = NORMAL_MAP_PLACES[part];
  stopUpload(place);
  return changeScene(place, (scene) => withNormalMap(scene, part, null));
}

/**
 * Changes a normal map while a control is dragged.
 * @param {Part} part
 * @param {Partial<NormalMap>} change
 */
export function dragNormalMap(part, change) {
  const scene = sceneStore.editedScene.value;
  const map = normalMapOf(scene, part);
  if (scene && map)
    sceneStore.draggedScene.value = withNormalMap(scene, part, { ...map, ...change });
}

/** Sends what was dragged. @param {Part} part */
export const commitNormalMap = (part) => commitDragged(NORMAL_MAP_PLACES[part]);
