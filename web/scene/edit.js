/**
 * Changes of the scene: object, rotation, scale, lights, film, and uploads of OBJ files. Sends one
 * change at a time and loses none.
 *
 * @import { Backdrop, Light, Place, Scene } from "../model.js"
 */
import { batch, effect } from "../vendor/signals-core.js";
import { problemOf } from "../api/request.js";
import * as api from "../api/routes.js";
import { refreshShown } from "../lineage/generations.js";
import { clearReady, startClock } from "../lineage/pictures.js";
import { lineageStore } from "../lineage/store.js";
import { loadSetting, saveSetting } from "../page/memory.js";
import { clearProblems, guarded, showProblem } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { extentOf } from "./extents.js";
import { LIGHT_KINDS } from "./light_kind.js";
import { SKY_SAMPLES, environment, lampOf, withEnvironment, withLamp } from "./lights.js";
import { besides } from "./spot.js";
import { sceneStore } from "./store.js";
import { stopUpload, uploadFile } from "./upload.js";

/** Meshes that the server generates. */
export const BUILT_IN = ["ball", "sphere", "torus", "cube", "knob"];

/** Largest OBJ file that the server accepts. */
const OBJ_BYTES = 32 * 1024 * 1024;

/** Ends when all changes so far have been sent. @type {Promise<unknown>} */
let queue = Promise.resolve();
/** Number of changes that are queued or on their way. */
let waiting = 0;
/**
 * The next change in the queue; further changes for the same place are merged into it.
 * @type {{of: string, place: Place, changes: Partial<Scene>, work: Promise<void>}|null}
 */
let next = null;

/** Resolves when no change of the scene is on its way. */
export const sceneSettled = () => queue;

/**
 * Changes the scene of the open lineage.
 * @param {Place} place where a refusal is shown
 * @param {(present: Scene) => Partial<Scene>} change
 * @returns {Promise<void>}
 */
export function changeScene(place, change) {
  const left = sceneStore.editedScene.value;
  const of = lineageStore.lineage.value;
  if (!left || !of) return Promise.resolve();
  const changes = change(left);
  sceneStore.pendingScene.value = { ...sceneStore.pendingScene.value, ...changes };
  sceneStore.busy.value = true;
  clearReady();
  startClock();
  if (next?.of === of.id && next.place === place) {
    Object.assign(next.changes, changes);
    return next.work;
  }
  waiting += 1;
  const mine = { of: of.id, place, changes, work: Promise.resolve() };
  next = mine;
  mine.work = queue.then(() => {
    if (next === mine) next = null;
    return guarded(place, () => apply(of.id, mine.changes));
  });
  queue = mine.work.finally(() => {
    waiting -= 1;
    if (waiting > 0) return;
    sceneStore.pendingScene.value = null;
    sceneStore.busy.value = false;
  });
  return mine.work;
}

/** Number of attempts to apply a change on top of concurrent changes by other clients. */
const TRIES = 4;

/** Sends changes of the scene. @param {string} lineageId @param {Partial<Scene>} changes */
async function apply(lineageId, changes) {
  for (let tried = 1; ; tried += 1) {
    const of = lineageStore.lineage.value;
    const present = sceneStore.scene.value;
    if (!of || !present || of.id !== lineageId) return;
    const wanted = await api.createScene({ ...present, ...changes });
    // After a retry the scene may be right already, and only the pictures missing.
    if (!wanted.id || wanted.id === present.id) return refreshShown();
    try {
      const changed = await api.patchScene(of, wanted.id);
      if (lineageStore.lineage.value?.id !== lineageId) return;
      storeConfirmed(changed, wanted);
      return refreshShown();
    } catch (error) {
      if (problemOf(error).status !== 412 || tried === TRIES) throw error;
      const theirs = await api.getLineage(lineageId);
      const scene = await api.getScene(theirs.scene);
      if (lineageStore.lineage.value?.id === lineageId) storeConfirmed(theirs, scene);
    }
  }
}

/**
 * Stores a lineage and its scene as the server has them.
 * @param {import("../model.js").Lineage} of
 * @param {Scene} scene
 */
function storeConfirmed(of, scene) {
  batch(() => {
    lineageStore.lineage.value = of;
    sceneStore.scene.value = scene;
  });
}

/** Sends what was dragged. @param {Place} place */
export function commitDragged(place) {
  const left = sceneStore.draggedScene.value;
  if (!left) return;
  void changeScene(place, () => left).finally(() => {
    if (sceneStore.draggedScene.value === left) sceneStore.draggedScene.value = null;
  });
}

/** Sizes of a light that are given. @param {Light} light @returns {[string, number][]} */
const sizesOf = (light) =>
  /** @type {const} */ (["radius", "width", "height"]).flatMap((field) => {
    const size = light[field];
    return typeof size === "number" ? [/** @type {[string, number]} */ ([field, size])] : [];
  });

/**
 * Adapts lights to another object: a light with a strength but no position stays at the same
 * distance in radii, so its strength must grow with the square of the radius, and its size with
 * the radius.
 * @param {Light[]} lights
 * @param {string} from
 * @param {string} to
 * @returns {Promise<Light[]>}
 */
async function lightsOn(lights, from, to) {
  if (!lights.some((light) => !light.position && (light.intensity || sizesOf(light).length > 0)))
    return lights;
  const [before, after] = await Promise.all([extentOf(from), extentOf(to)]);
  const ratio = after.radius / before.radius;
  /** @param {Light} light @param {number} factor @returns {Light} */
  const times = (light, factor) => {
    const intensity =
      typeof light.intensity === "number"
        ? /** @type {const} */ ([light.intensity, light.intensity, light.intensity])
        : light.intensity;
    return {
      ...light,
      ...Object.fromEntries(sizesOf(light).map(([field, size]) => [field, size * ratio])),
      intensity: intensity && [intensity[0] * factor, intensity[1] * factor, intensity[2] * factor],
    };
  };
  return lights.map((light) =>
    light.position ? light : times(light, ratio ** 2),
  );
}

/**
 * The other objects of a scene, beside another subject of scale 1.
 * @param {Scene} scene
 * @param {string} mesh
 */
async function objectsOn(scene, mesh) {
  const objects = scene.objects ?? [];
  if (objects.length === 0) return objects;
  const [from, to, ...own] = await Promise.all(
    [scene.mesh, mesh, ...objects.map((object) => object.mesh ?? "sphere")].map(extentOf),
  );
  return besides(objects, { from: scene, to: { ...scene, mesh, scale: 1 } }, { from, to, own });
}

/** Number of choices of an object so far; an older choice that comes late is dropped. */
let objectChoices = 0;

/** Shows another object, unturned and at its own size. @param {string} mesh */
export async function chooseObject(mesh) {
  stopUpload("object");
  const mine = ++objectChoices;
  const present = sceneStore.editedScene.value;
  if (!present || mesh === present.mesh) return;
  await guarded("object", async () => {
    const lights = await lightsOn(present.lights ?? [], present.mesh, mesh);
    const objects = await objectsOn(present, mesh);
    if (mine !== objectChoices) return;
    await changeScene("object", () => ({
      mesh,
      rotation_deg: [0, 0, 0],
      scale: 1,
      lights,
      ...(objects.length > 0 ? { objects } : {}),
      // Another pole needs the sphere.
      sphere_pole: undefined,
    }));
  });
}

/** True if object or light are turned, or the object is scaled. @param {Scene|null} scene */
export const isTurned = (scene) =>
  scene !== null &&
  (scene.scale !== 1 ||
    (scene.light_deg ?? 0) !== 0 ||
    scene.rotation_deg.some((degrees) => degrees !== 0));

/** Resets rotation and scale of the object, and the angle of a resting light. */
export function resetView() {
  if (isTurned(sceneStore.editedScene.value))
    void changeScene("stage", () => ({ rotation_deg: [0, 0, 0], scale: 1, light_deg: 0 }));
}

/** Requests that store the files of lights. */
const FILES = { ies: api.createProfile, environment: api.createEnvironment };
/**
 * Replaces the lamp. Keeps its position, and takes the default strength of the new kind.
 * @param {import("../model.js").LightKind} kind
 * @param {Partial<Light>} [more]
 */
const setLamp = (kind, more) =>
  changeScene("light", (scene) => {
    const lamp = lampOf(scene);
    const { isPlaced } = LIGHT_KINDS[kind];
    const position = isPlaced && lamp?.position ? { position: lamp.position } : {};
    return withLamp(scene, { kind, ...position, ...more });
  });

/** @param {import("../model.js").LightKind|null} kind one that needs no file; null for no lamp */
export function chooseLamp(kind) {
  stopUpload("light");
  if (kind === null) return changeScene("light", (scene) => withLamp(scene, null));
  return setLamp(kind, kind === "ambient" ? { samples: SKY_SAMPLES } : {});
}

/**
 * Surrounds the object with a built-in environment.
 * @param {string|null} image its name in scenes; null for none
 */
export function chooseEnvironment(image) {
  stopUpload("light");
  return changeScene("light", (scene) => ({
    ...withEnvironment(scene, image === null ? null : environment(image)),
    // Without an environment there is none to show.
    ...(image === null && scene.backdrop?.kind === "environment" ? { backdrop: undefined } : {}),
  }));
}

/** Shows something else behind the object. @param {Backdrop|null} backdrop */
export const setBackdrop = (backdrop) =>
  changeScene("light", () => ({ backdrop: backdrop ?? undefined }));

/**
 * Uploads an IES profile for the lamp or the picture of an environment, and lights the object with
 * it.
 * @param {"ies"|"environment"} kind
 * @param {File} file
 */
export function lightByFile(kind, file) {
  clearProblems("light");
  pageStore.announcement.value = `Reading ${file.name}.`;
  const of = lineageStore.lineage.value?.id;
  return guarded("light", async () => {
    const stored = await uploadFile("light", file, FILES[kind]);
    if (!stored || lineageStore.lineage.value?.id !== of) return;
    const { id } = stored;
    if (kind === "ies") await setLamp(kind, { profile: id });
    else await changeScene("light", (scene) => withEnvironment(scene, environment(id)));
  });
}

/** @param {boolean} shadows */
export const setShadows = (shadows) => changeScene("light", () => ({ shadows }));

/**
 * Changes a convention of the scene, in which renderers differ.
 * @param {"normals"|"tangents"|"sphere_pole"} name
 * @param {string} value
 */
export const setConvention = (name, value) => changeScene("object", () => ({ [name]: value }));

/** @param {import("../model.js").Tone} tone */
export const setTone = (tone) =>
  changeScene("film", (present) => ({ film: { ...present.film, tone } }));

/** @param {"auto"|number} exposure */
export const setExposure = (exposure) =>
  changeScene("film", (present) => ({ film: { ...present.film, exposure } }));

/**
 * Uploads an OBJ file, shows its warnings, and makes it the object of the lineage.
 * @param {File} file
 */
export async function uploadObj(file) {
  clearProblems("object");
  pageStore.knobsOpen.value = true;
  if (file.size > OBJ_BYTES) {
    showProblem("object", {
      problem: {
        title: "The file is too large",
        status: 413,
        detail: `An OBJ file may have 32 MiB; ${file.name} has ${(file.size / 2 ** 20).toFixed(1)} MiB.`,
      },
    });
    return;
  }
  pageStore.announcement.value = `Reading ${file.name}.`;
  const of = lineageStore.lineage.value?.id;
  await guarded("object", async () => {
    const answer = await uploadFile("object", file, api.createMesh);
    if (!answer) return;
    sceneStore.meshes.value = [
      ...sceneStore.meshes.value.filter((one) => one.answer.id !== answer.id),
      { name: file.name, answer },
    ].slice(-20);
    saveSetting("meshes", sceneStore.meshes.value);
    pageStore.announcement.value = `${file.name}: ${answer.triangles} triangles, ${answer.warnings.length} warnings.`;
    if (lineageStore.lineage.value?.id === of) await chooseObject(answer.id);
  });
}

export function loadMeshes() {
  const kept = loadSetting("meshes", sceneStore.meshes.value);
  if (Array.isArray(kept)) sceneStore.meshes.value = kept;
}

/** Reads the warnings of an object that another client uploaded. */
export function watchMeshes() {
  effect(() => {
    const id = sceneStore.scene.value?.mesh;
    const isKnown = () => sceneStore.meshes.peek().some((one) => one.answer.id === id);
    if (!id || BUILT_IN.includes(id) || isKnown()) return;
    void guarded("object", async () => {
      const answer = await api.getMesh(id);
      if (!isKnown())
        sceneStore.meshes.value = [...sceneStore.meshes.peek(), { name: "uploaded", answer }].slice(
          -20,
        );
    });
  });
}
