/**
 * Places and materials of the ground and of the object beside the one that is bred.
 * The controls change the first such object; a scene from elsewhere may have more.
 *
 * @import { Scene, SceneObject } from "../model.js"
 * @import { Spot } from "./spot.js"
 */
import { guarded } from "../page/problem.js";
import { changeScene, commitDragged } from "./edit.js";
import { extentOf } from "./extents.js";
import { environment } from "./lights.js";
import { placed, spotOf } from "./spot.js";
import { sceneStore } from "./store.js";

/** Where a new object is: to the right in the default camera's view and a little in front. */
const FIRST = { around: 70, distance: 1.35, height: 0, radius: 0.4 };

/** Extents of the subject and of its neighbour, once both are known. */
export function knownExtents() {
  const scene = sceneStore.editedScene.value;
  const object = scene?.objects?.[0];
  const extents = sceneStore.extents.value;
  const [subject, own] = [extents.get(scene?.mesh ?? ""), extents.get(object?.mesh ?? "sphere")];
  return subject && own ? { subject, own } : null;
}

/** @param {Scene} scene @param {SceneObject|null} first @returns {Partial<Scene>} */
const withFirst = (scene, first) => ({
  objects: [...(first ? [first] : []), ...(scene.objects ?? []).slice(1)],
});

/** Puts another object beside the subject. @param {string|null} mesh null for none */
export const chooseNeighbour = (mesh) =>
  guarded("surroundings", async () => {
    const scene = sceneStore.editedScene.value;
    if (!scene) return;
    const present = scene.objects?.[0];
    if (mesh === null) {
      await changeScene("surroundings", (now) => withFirst(now, null));
      return;
    }
    const [subject, own, before] = await Promise.all(
      [scene.mesh, mesh, present?.mesh ?? mesh].map(extentOf),
    );
    const spot = present ? spotOf(present, scene, { subject, own: before }) : FIRST;
    const stands = present ? present.stands : scene.ground ? true : undefined;
    const object = { ...present, mesh, stands, rotation_deg: undefined };
    await changeScene("surroundings", (now) =>
      withFirst(now, placed(object, spot, now, { subject, own })));
  });

/** Moves or scales the neighbour while a control is dragged. @param {Partial<Spot>} change */
export function dragNeighbour(change) {
  const scene = sceneStore.editedScene.value;
  const object = scene?.objects?.[0];
  const extents = knownExtents();
  if (!scene || !object || !extents) return;
  const spot = { ...spotOf(object, scene, extents), ...change };
  sceneStore.draggedScene.value = withFirst(scene, placed(object, spot, scene, extents));
}

/** Sends what was dragged. */
export const commitNeighbour = () => commitDragged("surroundings");

/** @param {string|undefined} material hash of a genome, or name of a preset */
export const setNeighbourMaterial = (material) =>
  changeScene("surroundings", (scene) =>
    withFirst(scene, { ...scene.objects?.[0], material }));

/** @param {Scene} scene @param {boolean} on @returns {Partial<Scene>} */
const withGround = (scene, on) => ({
  ground: on ? {} : undefined,
  objects: (scene.objects ?? []).map((object) => ({ ...object, stands: on ? true : undefined })),
});

/** Puts the ground below the objects, or takes it away. @param {boolean} on */
export const setGround = (on) => changeScene("surroundings", (scene) => withGround(scene, on));

/** Samples of the soft lamp of the stage: few enough for a brood, enough for a smooth penumbra. */
const KEY_SAMPLES = 16;

/**
 * Shows the object as a photographer would: on the ground, in the light of a studio that casts no
 * shadows, and under a soft lamp that does.
 */
export const setStage = () =>
  changeScene("surroundings", (scene) => ({
    ...(scene.ground ? {} : withGround(scene, true)),
    shadows: true,
    lights: [
      { ...environment("studio"), shadows: false },
      { kind: "sphere", samples: KEY_SAMPLES },
    ],
    light_deg: 0,
  }));

/** @param {string|undefined} material hash of a genome, or name of a preset */
export const setGroundMaterial = (material) =>
  changeScene("surroundings", (scene) => ({ ground: { ...scene.ground, material } }));
