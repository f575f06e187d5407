/**
 * The controls of the scene's first light: changes while they are dragged, and their commit to the
 * server.
 *
 * @import { LightSetting } from "./light_color.js"
 * @import { Scene } from "../model.js"
 */
import { effect, untracked } from "../vendor/signals-core.js";
import { lineageStore } from "../lineage/store.js";
import { guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { changeScene } from "./edit.js";
import { extentOf } from "./extents.js";
import { NEUTRAL, intensityOf, strengthField } from "./light_color.js";
import { sceneStore } from "./store.js";

/**
 * Changes the light while a control is dragged; live frames follow.
 * @param {Partial<LightSetting>} change
 */
export function dragLight(change) {
  const scene = sceneStore.editedScene.value;
  const neutral = sceneStore.neutralLight.value;
  if (!scene?.lights || neutral === null) return;
  const wanted = { ...(sceneStore.lightSetting.value ?? NEUTRAL), ...change };
  const [first, ...others] = scene.lights;
  const field = strengthField(first);
  if (!field) return;
  sceneStore.draggedLight.value = wanted;
  sceneStore.draggedScene.value = {
    lights: [{ ...first, [field]: intensityOf(wanted, neutral) }, ...others],
  };
}

/**
 * Changes the shape of the first light while a control is dragged.
 * @param {Partial<import("../model.js").Light>} change
 */
export function dragShape(change) {
  const [first, ...others] = sceneStore.editedScene.value?.lights ?? [];
  if (first) sceneStore.draggedScene.value = { lights: [{ ...first, ...change }, ...others] };
}

/** Commits the dragged light to the scene. */
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
 * Reads the object's bounding sphere, on which the strength depends, once the pictures are loaded.
 */
export function watchExtent() {
  return effect(() => {
    const mesh = sceneStore.editedScene.value?.mesh;
    if (
      !mesh ||
      !pageStore.knobsOpen.value ||
      lineageStore.readyId.value === null ||
      sceneStore.extents.value.has(mesh)
    )
      return;
    // Untracked, so that showing a failure does not cause another request.
    untracked(
      () =>
        void guarded("light", async () => {
          await extentOf(mesh);
        }),
    );
  });
}
