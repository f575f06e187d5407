/**
 * The controls of lamp, environment and backdrop: changes while they are dragged, and their
 * commit to the server.
 *
 * @import { LightSetting } from "./light_color.js"
 * @import { Backdrop, Light } from "../model.js"
 */
import { effect, untracked } from "../vendor/signals-core.js";
import { lineageStore } from "../lineage/store.js";
import { guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { changeScene } from "./edit.js";
import { extentOf } from "./extents.js";
import { NEUTRAL, intensityOf, strengthField } from "./light_color.js";
import { environmentOf, lampOf, withEnvironment, withLamp } from "./lights.js";
import { sceneStore } from "./store.js";

/**
 * Changes the lamp while a control is dragged; live frames follow.
 * @param {Partial<LightSetting>} change
 */
export function dragLight(change) {
  const scene = sceneStore.editedScene.value;
  const lamp = lampOf(scene);
  const neutral = sceneStore.neutralLight.value;
  if (!scene || !lamp || neutral === null) return;
  const wanted = { ...(sceneStore.lightSetting.value ?? NEUTRAL), ...change };
  const field = strengthField(lamp);
  if (!field) return;
  sceneStore.draggedLight.value = wanted;
  sceneStore.draggedScene.value = withLamp(scene, {
    ...lamp,
    [field]: intensityOf(wanted, neutral),
  });
}

/**
 * Changes the shape of the lamp while a control is dragged.
 * @param {Partial<Light>} change
 */
export function dragShape(change) {
  const scene = sceneStore.editedScene.value;
  const lamp = lampOf(scene);
  if (scene && lamp) sceneStore.draggedScene.value = withLamp(scene, { ...lamp, ...change });
}

/**
 * Changes the environment while a control is dragged.
 * @param {Partial<Light>} change
 */
export function dragEnvironment(change) {
  const scene = sceneStore.editedScene.value;
  const present = environmentOf(scene);
  if (scene && present)
    sceneStore.draggedScene.value = withEnvironment(scene, { ...present, ...change });
}

/** Changes the backdrop while a control is dragged. @param {Backdrop} backdrop */
export function dragBackdrop(backdrop) {
  sceneStore.draggedScene.value = { backdrop };
}

/** Commits the dragged lights or backdrop to the scene. */
export function commitLight() {
  const left = sceneStore.draggedScene.value;
  if (!left) return;
  void changeScene("light", () => left).finally(() => {
    if (sceneStore.draggedScene.value !== left) return;
    sceneStore.draggedScene.value = null;
    sceneStore.draggedLight.value = null;
  });
}

/**
 * Reads the bounding spheres of the objects, on which strength and places depend, once the pictures
 * are loaded.
 */
export function watchExtent() {
  return effect(() => {
    const scene = sceneStore.editedScene.value;
    if (!scene || !pageStore.knobsOpen.value || lineageStore.readyId.value === null) return;
    const meshes = [scene.mesh, ...(scene.objects ?? []).map(({ mesh }) => mesh ?? "sphere")];
    for (const mesh of meshes.filter((one) => !sceneStore.extents.value.has(one))) {
      // Untracked, so that showing a failure does not cause another request.
      untracked(
        () =>
          void guarded("light", async () => {
            await extentOf(mesh);
          }),
      );
    }
  });
}
