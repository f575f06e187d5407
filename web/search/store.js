/**
 * Store of searches: the list, the form of a new one, the open one, and the target of the search
 * that made the open lineage. Does no requests and no drawing.
 *
 * @import { Found, Individual, Job, LogLine, Scene, Spread, Target } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 * @import { Draft } from "./draft.js"
 * @import { PairUrls } from "./pair_urls.js"
 */
import { computed, signal } from "../vendor/signals-core.js";
import { pairOf } from "../compare/pair.js";
import { sceneStore } from "../scene/store.js";
import { pairUrls } from "./pair_urls.js";
import { sameScene } from "./same_scene.js";

/** Views of the dialog that are not of one search. */
export const ALL = "all";
export const NEW = "new";

/** Milliseconds between two reads of the list: while it is shown, and while a search runs. */
const SHOWN_MS = 2000;
const RUNNING_MS = 8000;

/** Form before anything is filled in. @type {Draft} */
export const BLANK = {
  file: null,
  kind: "",
  views: [],
  target: null,
  own: null,
  name: "",
  strategy: "",
  objective: "",
  measure: "seconds",
  seconds: "25",
  generations: "40",
  evaluations: "20000",
  seed: "",
  threads: "",
  islands: "",
  mirrored: false,
  into: "own",
  start: null,
};

class SearchStore {
  /**
   * Open view of the dialog: the list, the form, or a search by its id; null if closed.
   * @type {Signal<string|null>}
   */
  openView = signal(null);
  /** Newest first; null until read. @type {Signal<Job[]|null>} */
  jobs = signal(null);
  /** Cursor of the next page of the list; null at its end. @type {Signal<string|null>} */
  nextCursor = signal(null);

  /** @type {Signal<Draft>} */
  draft = signal(BLANK);
  /** True while the server is asked to start a search. @type {Signal<boolean>} */
  starting = signal(false);
  /** Field that the last refusal names. @type {Signal<string|null>} */
  wrongField = signal(null);
  /** Targets that the server has, newest first. @type {Signal<Target[]>} */
  targets = signal([]);
  /**
   * Bytes of the running upload; all are sent while the server reads.
   * @type {Signal<{sent: number, whole: number}|null>}
   */
  upload = signal(null);
  /**
   * Picture (by number) and field that the last refusal names.
   * @type {Signal<{view: number|null, field: string}|null>}
   */
  wrongPicture = signal(null);
  /** True if pictures were changed since the server read them. @type {Signal<boolean>} */
  picturesChanged = signal(false);
  /**
   * Form that was being filled in when an existing target was chosen.
   * @type {Signal<Pick<Draft, "file"|"kind"|"views">|null>}
   */
  setAside = signal(null);

  /** The open search. @type {Signal<Job|null>} */
  job = signal(null);
  /** Target of that search. @type {Signal<Target|null>} */
  target = signal(null);
  /**
   * True once the server has answered for the target, which may be gone.
   * @type {Signal<boolean>}
   */
  targetRead = signal(false);
  /** Scene of the lineage in which results are born. @type {Signal<string|null>} */
  lineageScene = signal(null);
  /** @type {Signal<LogLine[]>} */
  logLines = signal([]);
  /** Results, best first. @type {Signal<Found[]>} */
  front = signal([]);
  /** Spread of the materials, once the search has ended. @type {Signal<Spread|null>} */
  spread = signal(null);
  /**
   * Individual that the user picked from the front; null for the best.
   * @type {Signal<string|null>}
   */
  pickedId = signal(null);
  /** Text of the dialog's live region. @type {Signal<string>} */
  jobAnnouncement = signal("");
  /** True while the user is asked to confirm the cancellation. @type {Signal<boolean>} */
  confirmingCancel = signal(false);
  /**
   * Individuals of picked results, by id.
   * @type {Signal<Map<string, Individual & {lineage?: string, generation?: string}>>}
   */
  individuals = signal(new Map());

  /**
   * Angle of the light in the result's pictures, degrees; null for that of their scene.
   * @type {Signal<number|null>}
   */
  pictureLight = signal(null);
  /** The same while the slider is dragged. @type {Signal<number|null>} */
  draggedLight = signal(null);
  /** Number of the target's picture that is shown. @type {Signal<number>} */
  pictureView = signal(0);
  /**
   * Ids of stored scenes of the target's pictures, by target and picture.
   * @type {Signal<Map<string, string>>}
   */
  viewScenes = signal(new Map());
  /** The target's picture over its scene, as the server understood it. */
  understoodPair = pairOf();
  /** The target over the result. */
  foundPair = pairOf();

  /**
   * Targets of searches whose results are born in the open lineage; that of the newest search
   * first.
   * @type {Signal<Target[]>}
   */
  lineageTargets = signal([]);
  /**
   * Id of the target that the user chose, and the number of its picture.
   * @type {Signal<{id: string|null, view: number}>}
   */
  chosenTarget = signal({ id: null, view: 0 });

  /** Number of known searches that are queued or running. @type {Signal<number>} */
  runningCount = computed(
    () =>
      (this.jobs.value ?? []).filter(({ state }) => state === "queued" || state === "running")
        .length,
  );
  /** Milliseconds between two reads of the list; 0 for none. @type {Signal<number>} */
  pollInterval_ms = computed(() =>
    this.openView.value === ALL ? SHOWN_MS : this.runningCount.value > 0 ? RUNNING_MS : 0,
  );
  /** The result that is shown. @type {Signal<Found|null>} */
  chosenResult = computed(
    () =>
      this.front.value.find(({ individual }) => individual === this.pickedId.value) ??
      this.front.value[0] ??
      this.job.value?.best ??
      null,
  );

  /** Addresses of the pictures of the result and of the target. @type {Signal<PairUrls>} */
  pictureUrls = computed(() => {
    const [of, within, to] = [this.chosenResult.value, this.job.value, this.target.value];
    if (!within || !this.targetRead.value) return { find: null, target: null };
    const view = this.pictureView.value;
    const viewScene = (to && this.viewScenes.value.get(`${to.id} ${view}`)) ?? null;
    return pairUrls({
      of,
      within,
      to,
      scene: this.lineageScene.value,
      view,
      viewScene,
      light: this.pictureLight.value,
    });
  });
  /** True if a picture of the target can lie over the result's. @type {Signal<boolean>} */
  isPaired = computed(() => this.pictureUrls.value.target !== null);

  /** The target that is compared with the centre. @type {Signal<Target|null>} */
  activeTarget = computed(
    () =>
      this.lineageTargets.value.find(({ id }) => id === this.chosenTarget.value.id) ??
      this.lineageTargets.value[0] ??
      null,
  );
  /**
   * Number of its picture; null for a measured target, which any scene can show.
   * @type {Signal<number|null>}
   */
  activeView = computed(() => {
    const views = this.activeTarget.value?.views ?? [];
    return views.length > 0 ? Math.min(this.chosenTarget.value.view, views.length - 1) : null;
  });
  /**
   * Scene of that picture if it differs from the lineage's, so that the two do not cover each
   * other.
   * @type {Signal<Scene|null>}
   */
  otherScene = computed(() => {
    const view = this.activeView.value;
    const wanted = view === null ? null : (this.activeTarget.value?.views?.[view].scene ?? null);
    const present = sceneStore.scene.value;
    return wanted && present && !sameScene(wanted, present) ? wanted : null;
  });
}

export const searchStore = new SearchStore();
