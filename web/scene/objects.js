/**
 * The ground and the object beside the one that is bred: where they are, and what they are made of.
 * The controls change the first such object; a scene from elsewhere may have more.
 *
 * @import { Extent } from "../live/camera.js"
 * @import { Scene, SceneObject, Vec3 } from "../model.js"
 */
import { changeScene } from "./edit.js";
import { extentOf } from "./extents.js";
import { environment } from "./lights.js";
import { sceneStore } from "./store.js";
import { guarded } from "../page/problem.js";

/** Place of an object: degrees around the subject, distance and radius in radii of the subject. */
/** @typedef {{around: number, distance: number, radius: number}} Spot */

/** Where a new object is: to the right of the default camera's view and a little behind. */
const FIRST = { around: 105, distance: 1.5, radius: 0.5 };

/** @param {Pick<Scene, "mesh"|"scale">} scene @param {Extent} subject */
const radiusOf = (scene, subject) => subject.radius * scene.scale;

/**
 * Puts an object somewhere: on the ground if there is one, else level with the subject.
 * @param {SceneObject} object
 * @param {Spot} spot
 * @param {Scene} scene
 * @param {{subject: Extent, own: Extent}} extents
 * @returns {SceneObject}
 */
export function placed(object, { around, distance, radius }, scene, { subject, own }) {
  const unit = radiusOf(scene, subject);
  const angle = (around * Math.PI) / 180;
  const towards = [Math.sin(angle), 0, Math.cos(angle)];
  const position = /** @type {Vec3} */ (
    towards.map((along, axis) => subject.centre[axis] + along * distance * unit - own.centre[axis])
  );
  return {
    ...object,
    position,
    scale: Math.min((radius * unit) / own.radius, 1000),
    ...(scene.ground ? { stands: true } : { stands: undefined }),
  };
}

/**
 * Where an object is.
 * @param {SceneObject} object
 * @param {Pick<Scene, "mesh"|"scale">} scene
 * @param {{subject: Extent, own: Extent}} extents
 * @returns {Spot}
 */
export function spotOf(object, scene, { subject, own }) {
  const unit = radiusOf(scene, subject);
  const position = object.position ?? [0, 0, 0];
  const [x, , z] = position.map((at, axis) => at + own.centre[axis] - subject.centre[axis]);
  const degrees = (Math.atan2(x, z) * 180) / Math.PI;
  return {
    around: (degrees + 360) % 360,
    distance: Math.hypot(x, z) / unit,
    radius: ((object.scale ?? 1) * own.radius) / unit,
  };
}

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
    const object = { ...present, mesh, rotation_deg: undefined };
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
export function commitNeighbour() {
  const left = sceneStore.draggedScene.value;
  if (!left) return;
  void changeScene("surroundings", () => left).finally(() => {
    if (sceneStore.draggedScene.value === left) sceneStore.draggedScene.value = null;
  });
}

/** @param {string|undefined} material hash of a genome, or name of a preset */
export const setNeighbourMaterial = (material) =>
  changeScene("surroundings", (scene) =>
    withFirst(scene, { ...scene.objects?.[0], material }));

/** Puts the ground below the objects, or takes it away. @param {boolean} on */
export const setGround = (on) =>
  changeScene("surroundings", (scene) => ({
    ground: on ? {} : undefined,
    objects: (scene.objects ?? []).map((object) => ({ ...object, stands: on ? true : undefined })),
  }));

/** Samples of the soft lamp of the stage: few enough for a brood, enough for a smooth penumbra. */
const KEY_SAMPLES = 16;

/**
 * Shows the object as a photographer would: on the ground, in the light of a studio that casts no
 * shadows, and under a soft lamp that does.
 */
export const setStage = () =>
  changeScene("surroundings", (scene) => ({
    ground: scene.ground ?? {},
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
