/**
 * Store of the scene that the open lineage is seen in, with changes that the server has not
 * confirmed yet. Does no requests and no drawing.
 *
 * @import { DraggedPose, Place, Scene, Upload, UploadedMesh } from "../model.js"
 * @import { Extent } from "../live/camera.js"
 * @import { Signal } from "../vendor/signals-core.js"
 * @import { LightSetting } from "./light_color.js"
 */
import { computed, signal } from "../vendor/signals-core.js";
import { NEUTRAL, neutralStrength, settingOf, strengthField } from "./light_color.js";
import { lampOf } from "./lights.js";

class SceneStore {
  /** The scene that the server has confirmed. @type {Signal<Scene|null>} */
  scene = signal(null);
  /** Changes that are sent or queued and not confirmed yet. @type {Signal<Partial<Scene>|null>} */
  pendingScene = signal(null);
  /** Changes while a control is dragged. @type {Signal<Partial<Scene>|null>} */
  draggedScene = signal(null);
  /** True while a change is on its way to the server. @type {Signal<boolean>} */
  busy = signal(false);
  /** Pose of the object while it is rotated or scaled by hand. @type {Signal<DraggedPose|null>} */
  draggedPose = signal(null);
  /** Meshes uploaded from this browser. @type {Signal<UploadedMesh[]>} */
  meshes = signal([]);
  /** Running uploads by the place that chose them. @type {Signal<Map<Place, Upload>>} */
  uploads = signal(new Map());
  /**
   * Id of the lineage whose backdrop becomes a picture once a file is chosen; empty if none does.
   */
  pictureAwaited = signal("");
  /** Bounding spheres read so far, by mesh. @type {Signal<Map<string, Extent>>} */
  extents = signal(new Map());
  /** Colour and strength of the light while they are dragged. @type {Signal<LightSetting|null>} */
  draggedLight = signal(null);

  /**
   * The scene with all changes, confirmed or not, as the controls show it.
   * @type {Signal<Scene|null>}
   */
  editedScene = computed(
    () =>
      this.scene.value && {
        ...this.scene.value,
        ...this.pendingScene.value,
        ...this.draggedScene.value,
      },
  );

  /**
   * Strength of the lamp at 0 EV; null where unknown or not adjustable.
   * @type {Signal<number|null>}
   */
  neutralLight = computed(() => {
    const scene = this.editedScene.value;
    const light = lampOf(scene);
    const extent = scene && this.extents.value.get(scene.mesh);
    return light && extent && strengthField(light) ? neutralStrength(light, extent) : null;
  });

  /** True if the light controls can change anything yet. @type {Signal<boolean>} */
  lightEditable = computed(() => this.neutralLight.value !== null);

  /**
   * Setting of the light controls; null where the light is dark.
   * @type {Signal<LightSetting|null>}
   */
  lightSetting = computed(() => {
    if (this.draggedLight.value) return this.draggedLight.value;
    const neutral = this.neutralLight.value;
    const light = lampOf(this.editedScene.value);
    const field = light && strengthField(light);
    return neutral === null || !field ? NEUTRAL : settingOf(light[field], neutral);
  });
}

export const sceneStore = new SceneStore();
