/**
 * Store of live drawing: which frames are drawn in the browser, and the light on its circle.
 *
 * @import { Cell, Vec3 } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 * @import { Environment } from "./spheres.js"
 * @import { Still } from "./stills.js"
 */
import { computed, signal } from "../vendor/signals-core.js";
import { loadSetting } from "../page/memory.js";
import { sceneStore } from "../scene/store.js";
import { isDrawable, materialsOf } from "./camera.js";
import {
  NO_ENVIRONMENT, isTurnedAsWhole, isTurning, restingEnvironment, turningEnvironment,
} from "./spheres.js";

/** Default speed of the light, degrees a second. */
const SPEED = 40;

class LiveStore {
  /** Frames that are drawn in the browser. @type {Signal<Set<Cell>>} */
  liveCells = signal(new Set());
  /** True if this browser can draw live; null until it was tried. @type {Signal<boolean|null>} */
  supported = signal(null);
  /** True while the light circles. @type {Signal<boolean>} */
  lightMoving = signal(false);
  /** Degrees a second. @type {Signal<number>} */
  lightSpeed = signal(loadSetting("light-speed", SPEED));
  /**
   * Light of the server's pictures that follow it; null while it is the confirmed scene's.
   * @type {Signal<Still|null>}
   */
  still = signal(null);
  /**
   * Address of the server's picture of the edited centre; null if it is drawn live or not edited.
   * @type {Signal<string|null>}
   */
  draftPicture = signal(null);
  /**
   * Present angle of the light and its direction from the centre as the camera sees it (null
   * without a light). Changes with every drawing, so no component may depend on it.
   * @type {Signal<{degrees: number, direction: Vec3|null}|null>}
   */
  drawnLight = signal(null);

  /** True if any light circles. @type {Signal<boolean>} */
  lightCircles = computed(() => {
    const lights = sceneStore.editedScene.value?.lights ?? [];
    return lights.some(({ kind, fixed }) => kind !== "environment" || !fixed);
  });

  /** True since environments have turned, until nothing is drawn live. @type {Signal<boolean>} */
  turned = signal(false);

  /**
   * The environments as they are drawn; null if they cannot be. They have to be those that the
   * server has confirmed, apart from their rotation as a whole.
   * @type {Signal<Environment|null>}
   */
  environment = computed(() => {
    const [scene, edited] = [sceneStore.scene.value, sceneStore.editedScene.value];
    if (!scene || !edited) return NO_ENVIRONMENT;
    const moves = this.lightMoving.value && isTurning(edited);
    const confirmed = restingEnvironment(scene);
    const rests = !moves && restingEnvironment(edited).key === confirmed.key;
    if (rests && (!this.turned.value || confirmed.key === "")) return confirmed;
    const turning = moves && !isTurnedAsWhole(edited) ? null : turningEnvironment(edited);
    if (turning && turning.key === turningEnvironment(scene)?.key) return turning;
    return rests ? confirmed : null;
  });

  /**
   * Names of materials of other objects that the server or the driver refused. @type
   * {Signal<Set<string>>}
   */
  refusedMaterials = signal(new Set());

  /**
   * Ids of images that the browser cannot draw as the server does.
   * @type {Signal<Set<string>>}
   */
  refusedImages = signal(new Set());

  /** True if the scene is one that can be drawn live. @type {Signal<boolean>} */
  sceneDrawable = computed(() => {
    const scene = sceneStore.editedScene.value;
    if (scene === null) return true;
    const { backdrop } = scene;
    const refused =
      materialsOf(scene).some((name) => this.refusedMaterials.value.has(name)) ||
      (backdrop?.kind === "image" && this.refusedImages.value.has(backdrop.image));
    return isDrawable(scene) && !refused && this.environment.value !== null;
  });

  /** True if the edited centre is the server's picture: its material has no lit spheres. */
  draftRefused = signal(false);
}

export const liveStore = new LiveStore();
