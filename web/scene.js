/**
 * Changes of the scene: object, rotation, scale, exposure, and OBJ files. Owns the order of changes (one at a time, none
 * lost); knows nothing of hands and drawing.
 *
 * @import { Light, Place, Scene } from "./types.js"
 */
import { batch, effect } from "./vendor/signals-core.js";
import * as api from "./api.js";
import { extentOf } from "./extents.js";
import { guarded, rereadShown } from "./lineage.js";
import { keep, recall } from "./memory.js";
import { startClock, unready } from "./pictures.js";
import { announcement, forget, knobsOpen, lineage, meshes, scene, sceneBusy, tell, wished, wishedScene } from "./state.js";

/** Objects that the server makes by code. */
export const BUILT_IN = ["sphere", "torus", "cube", "knob"];

/** The server's limit, said before 32 MiB are sent in vain. */
const OBJ_BYTES = 32 * 1024 * 1024;

/** @type {Promise<unknown>} */
let queue = Promise.resolve();
let waiting = 0;
/** What waits for its turn: more of the same kind goes with it. @type {{of: string, place: Place, changes: Partial<Scene>, work: Promise<void>}|null} */
let next = null;

/** Resolves when no change of the scene is on its way. */
export const sceneSettled = () => queue;

/**
 * Changes the scene of the open lineage; its pictures follow.
 * @param {Place} place where a refusal is told
 * @param {(present: Scene) => Partial<Scene>} change
 * @returns {Promise<void>}
 */
export function changeScene(place, change) {
  const left = wishedScene.value;
  const of = lineage.value;
  if (!left || !of) return Promise.resolve();
  const changes = change(left);
  wished.value = { ...wished.value, ...changes };
  sceneBusy.value = true;
  unready();
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
    wished.value = null;
    sceneBusy.value = false;
  });
  return mine.work;
}

/** Changes of a scene that somebody else changes at the same time are put upon theirs, so often at most. */
const TRIES = 4;

/** @param {string} lineageId @param {Partial<Scene>} changes */
async function apply(lineageId, changes) {
  for (let tried = 1; ; tried += 1) {
    const of = lineage.value;
    const present = scene.value;
    if (!of || !present || of.id !== lineageId) return;
    const wanted = await api.createScene({ ...present, ...changes });
    // Tried again, it may be the pictures alone that are missing.
    if (!wanted.id || wanted.id === present.id) return rereadShown();
    try {
      const changed = await api.putScene(of, wanted.id);
      if (lineage.value?.id !== lineageId) return;
      take(changed, wanted);
      return rereadShown();
    } catch (error) {
      if (api.problemOf(error).status !== 412 || tried === TRIES) throw error;
      const theirs = await api.getLineage(lineageId);
      const its = await api.getScene(theirs.scene);
      if (lineage.value?.id === lineageId) take(theirs, its);
    }
  }
}

/** @param {import("./types.js").Lineage} of @param {Scene} its */
function take(of, its) {
  batch(() => {
    lineage.value = of;
    scene.value = its;
  });
}

/**
 * The lights as they are to be on another object: one that has a strength but no place of its own stays as far away in radii,
 * and has to stay as strong for its distance.
 * @param {Light[]} lights
 * @param {string} from
 * @param {string} to
 * @returns {Promise<Light[]>}
 */
async function lightsOn(lights, from, to) {
  if (!lights.some((light) => light.intensity && !light.position)) return lights;
  const [before, after] = await Promise.all([extentOf(from), extentOf(to)]);
  /** @param {Light} light @param {number} factor @returns {Light} */
  const times = (light, factor) => {
    const intensity = typeof light.intensity === "number" ? /** @type {const} */ ([light.intensity, light.intensity, light.intensity]) : light.intensity;
    return { ...light, intensity: intensity && [intensity[0] * factor, intensity[1] * factor, intensity[2] * factor] };
  };
  return lights.map((light) => (light.position ? light : times(light, (after.radius / before.radius) ** 2)));
}

/** @param {string} mesh */
export async function chooseObject(mesh) {
  const present = wishedScene.value;
  if (!present || mesh === present.mesh) return;
  await guarded("object", async () => {
    const lights = await lightsOn(present.lights ?? [], present.mesh, mesh);
    await changeScene("object", () => ({ mesh, rotation_deg: [0, 0, 0], scale: 1, lights }));
  });
}

/** Kinds that need a file. */
const FILES = { ies: api.createProfile, environment: api.createEnvironment };
/** Samples of light from all around: fewer than the server takes by itself, so that a brood is there in seconds. */
const SKY_SAMPLES = 16;
/** Kinds that stand somewhere. */
const PLACED = ["point", "spot", "ies", "sphere", "disk", "rectangle"];

/**
 * Puts another light in the place of the first; it stays where that stood, as strong as a scene has it that says nothing.
 * @param {import("./types.js").LightKind} kind
 * @param {Partial<Light>} [more]
 */
const setLight = (kind, more) =>
  changeScene("light", ({ lights: [first, ...others] = [] }) => {
    const position = PLACED.includes(kind) && first?.position ? { position: first.position } : {};
    return { lights: [{ kind, ...position, ...more }, ...others] };
  });

/** @param {import("./types.js").LightKind} kind one that needs no file */
export const chooseLight = (kind) => setLight(kind, kind === "ambient" ? { samples: SKY_SAMPLES } : {});

/**
 * Reads a profile or a picture of an environment, and lights the object by it.
 * @param {"ies"|"environment"} kind
 * @param {File} file
 */
export function lightByFile(kind, file) {
  forget("light");
  announcement.value = `Reading ${file.name}.`;
  return guarded("light", async () => {
    const { id } = await FILES[kind](file);
    await setLight(kind, kind === "ies" ? { profile: id } : { image: id, samples: SKY_SAMPLES });
  });
}

/** @param {boolean} shadows */
export const setShadows = (shadows) => changeScene("light", () => ({ shadows }));

/** @param {import("./types.js").Tone} tone */
export const setTone = (tone) => changeScene("film", (present) => ({ film: { ...present.film, tone } }));

/** @param {"auto"|number} exposure */
export const setExposure = (exposure) => changeScene("film", (present) => ({ film: { ...present.film, exposure } }));

/**
 * Reads an OBJ file, shows what was odd about it, and breeds on it from now on.
 * @param {File} file
 */
export async function uploadObj(file) {
  forget("object");
  knobsOpen.value = true;
  if (file.size > OBJ_BYTES) {
    tell("object", {
      problem: { title: "The file is too large", status: 413, detail: `${file.name} has ${(file.size / 2 ** 20).toFixed(1)} MiB; an OBJ may have 32 MiB.` },
    });
    return;
  }
  announcement.value = `Reading ${file.name}.`;
  await guarded("object", async () => {
    const answer = await api.createMesh(file);
    meshes.value = [...meshes.value.filter((one) => one.answer.id !== answer.id), { name: file.name, answer }].slice(-20);
    keep("meshes", meshes.value);
    announcement.value = `${file.name}: ${answer.triangles} triangles, ${answer.warnings.length} warnings.`;
    await chooseObject(answer.id);
  });
}

export function recallMeshes() {
  const kept = recall("meshes", meshes.value);
  if (Array.isArray(kept)) meshes.value = kept;
}

/** Asks what was odd about an object that somebody else uploaded. */
export function watchMeshes() {
  effect(() => {
    const id = scene.value?.mesh;
    const isKnown = () => meshes.peek().some((one) => one.answer.id === id);
    if (!id || BUILT_IN.includes(id) || isKnown()) return;
    void guarded("object", async () => {
      const answer = await api.getMesh(id);
      if (!isKnown()) meshes.value = [...meshes.peek(), { name: "uploaded", answer }].slice(-20);
    });
  });
}
