/**
 * Loop that draws the frames live: under the moving light, while the object or a control is
 * dragged, and until the pictures of the change are there; the centre also while it is edited.
 * Draws what is ready, prepares what is missing, and draws nothing if nothing has changed. The
 * server's pictures stay visible where this has nothing to show.
 *
 * @import { Cell, Individual, Scene } from "../model.js"
 * @import { Material } from "./material.js"
 * @import { PaintLight } from "./paint_lights.js"
 * @import { Context } from "./canvas.js"
 * @import { Surface } from "./surface.js"
 * @import { Extent, PointLight } from "./camera.js"
 */
import { effect } from "../vendor/signals-core.js";
import { individualSeenIn } from "../compare/ab.js";
import { compareStore } from "../compare/store.js";
import { individualIn } from "../lineage/individuals.js";
import { FRAMES, lineageStore } from "../lineage/store.js";
import { pageStore } from "../page/store.js";
import { extentOf } from "../scene/extents.js";
import { sceneStore } from "../scene/store.js";
import { BackdropPicture } from "./backdrop_picture.js";
import {
  LIGHTS, directionSeen, hasOthers, lightsOf, materialsOf, normalizedLights, rotationOf,
  strengthOf, viewOf,
} from "./camera.js";
import { layOut, observePixels, openContext } from "./canvas.js";
import { ClearBodies } from "./clear.js";
import { DraftMaterial } from "./draft_material.js";
import { FramePainter } from "./frames.js";
import { Meshes, partPaths } from "./geometry.js";
import { lightAt, startLight } from "./light_circle.js";
import { readLitCells, updateLitCells } from "./lit_cells.js";
import { METER_ANGLES } from "./material.js";
import { MaterialCache } from "./material_cache.js";
import { OtherParts } from "./others.js";
import { MeanLights, paintLightsOf } from "./paint_lights.js";
import { AdaptiveResolution, displayInterval } from "./resolution.js";
import { EVERY_WAY } from "./cone.js";
import { ShadowTexture, shadowKey } from "./shadows.js";
import { turnOf } from "./spheres.js";
import { stageOf } from "./stage.js";
import { followLight } from "./stills.js";
import { liveStore } from "./store.js";
import { drawPlaces, drawSurfaces, lightSurface } from "./surface.js";
import { ToolBox } from "./tools.js";

/** Stands for a scene without lights, which is drawn black. @type {PointLight} */
const DARK = { place: [0, 0, 1], intensity: [0, 0, 0], cone: EVERY_WAY, index: 0, degrees: 0 };

/** @type {HTMLCanvasElement|null} */
let canvas = null;
/** @type {Context|null} */
let context = null;
/**
 * Keys of what the surfaces show, of the places on lit spheres, and of what exposures were measured
 * for.
 */
let drawnKey = "";
let placedKey = "";
let meteredKey = "";
/** Id of the last generation that was drawn live. */
let liveGeneration = "";
/** True if an animation frame is requested. */
let requested = false;
/** True while materials are being compiled. */
let makingMaterials = false;
const resolution = new AdaptiveResolution();
const shadows = new ShadowTexture(schedule);
const cache = new MaterialCache(schedule);
const meshes = new Meshes(schedule);
const others = new OtherParts(schedule);
const clear = new ClearBodies(schedule);
const frames = new FramePainter(others, clear);
const toolBox = new ToolBox((gl, surface) => frames.drop(gl, surface));
const means = new MeanLights(schedule);
const draftMaterial = new DraftMaterial(schedule);
const picture = new BackdropPicture(schedule);

/** True while light or object move, so that the server's pictures do not suffice. */
const isMoving = () =>
  liveStore.lightMoving.value ||
  sceneStore.draggedPose.value !== null ||
  sceneStore.draggedScene.value !== null;

/** True while the light is elsewhere than in the server's pictures, or of another strength. */
const isLightMoved = () => liveStore.lightMoving.value || sceneStore.draggedScene.value !== null;

/** True while pictures are being replaced of frames that showed a moved light or object. */
const isReplaced = () =>
  lineageStore.readyId.value === null &&
  [liveGeneration, liveStore.still.peek()?.generation].includes(lineageStore.generation.value?.id);

/** Draws in the next animation frame. */
export function schedule() {
  if (requested || !canvas) return;
  requested = true;
  requestAnimationFrame(frame);
}

/** @param {HTMLCanvasElement|null} element */
export function attachCanvas(element) {
  if (element === canvas) return;
  canvas = element;
  if (!element) return;
  element.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    dropResources();
  });
  element.addEventListener("webglcontextrestored", () => {
    // Extensions are lost with the context; without them surfaces cannot be drawn into.
    if (context) context = openContext(element);
    schedule();
  });
  observePixels(new ResizeObserver(schedule), element);
}

/** Drops everything that was created in a lost context. */
function dropResources() {
  toolBox.lose();
  meshes.lose();
  frames.lose();
  drawnKey = "";
  placedKey = "";
  meteredKey = "";
  shadows.lose();
  cache.lose();
  draftMaterial.lose();
  picture.lose();
  showLive(new Set());
}

/**
 * Opens the context once the first pictures are loaded. On hardware the light then starts to
 * circle.
 */
function openOnce() {
  if (liveStore.supported.value !== null || !canvas) return;
  context = openContext(canvas);
  liveStore.supported.value = context !== null;
  if (!context) return;
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const begin = () => startLight(!(still || context?.software));
  if (context.software) return begin();
  // Before the first drawing, which could delay the display's frames.
  void displayInterval().then((interval) => {
    resolution.aimAt(interval);
    begin();
  });
}

/** Publishes which frames are drawn live; hides the canvas if none is. @param {Set<Cell>} cells */
function showLive(cells) {
  // The last drawing must not show behind the server's pictures.
  if (canvas) canvas.style.visibility = cells.size > 0 ? "visible" : "hidden";
  const before = liveStore.liveCells.value;
  if (cells.size !== before.size || [...cells].some((cell) => !before.has(cell)))
    liveStore.liveCells.value = cells;
}

/** @type {Cell[]} */
const CELLS = ["centre", ...Array(FRAMES).keys()];

/** True if an individual can be drawn live. @param {Individual|null} of */
const isLiveDrawn = (of) => of !== null && liveStore.sceneDrawable.value;

/** True if an individual is edited, and the server draws the edit. @param {Individual|null} of */
const isDraftPicture = (of) =>
  liveStore.draftRefused.value && of !== null && of.id === lineageStore.draft.value?.of.id;

/** True if a frame's material is drawn live or will be. @param {{cell: Cell}} frame */
function mayBeDrawn({ cell }) {
  const of = individualSeenIn(cell);
  return of !== null && isLiveDrawn(of) && !cache.isRefused(of) && !isDraftPicture(of);
}

/** True if an individual is shown by the server's pictures only. @param {Individual|null} of */
export const isServerDrawn = (of) => of !== null && !liveStore.sceneDrawable.value;

/**
 * Publishes where the light is.
 * @param {Scene} scene
 * @param {Extent} extent
 * @param {number} degrees
 */
function publishLight(scene, extent, degrees) {
  const pose = sceneStore.draggedPose.value ?? { rotation: rotationOf(scene), scale: scene.scale };
  const of = individualSeenIn("centre");
  // The dot has to be where the picture below it has the light.
  const pictured =
    of && !liveStore.liveCells.value.has("centre")
      ? (liveStore.still.value?.degrees ?? sceneStore.scene.value?.light_deg ?? 0)
      : degrees;
  const [light] = lightsOf(scene, extent, pose, pictured);
  const direction = light ? directionSeen(light, viewOf(scene.camera, extent, pose)) : null;
  liveStore.drawnLight.value = { degrees, direction };
}

/**
 * Draws nothing, but moves the light of the server's pictures.
 * @param {Scene} scene
 * @param {number} degrees
 */
function followOnServer(scene, degrees) {
  resolution.pause();
  showLive(new Set());
  const extent = sceneStore.extents.peek().get(scene.mesh);
  if (extent) publishLight(scene, extent, degrees);
  else void extentOf(scene.mesh).then(schedule, () => {});
  if (liveStore.lightMoving.value) schedule();
}

/**
 * One animation frame: brings surface, light, exposures and materials up to date, each only if what
 * it depends on has changed, and draws the materials that are ready.
 * @param {number} now milliseconds
 */
function frame(now) {
  requested = false;
  const scene = sceneStore.editedScene.value;
  const gl = context?.gl;
  const generation = lineageStore.generation.value;
  const draft = lineageStore.draft.value;
  // Only the edited centre is drawn then.
  const resting = !(isMoving() || isReplaced());
  if (gl && !draft && !gl.isContextLost()) draftMaterial.drop(gl);
  if (!gl || gl.isContextLost() || !scene || !generation || (resting && !draft)) {
    resolution.pause();
    liveStore.still.value = null;
    liveStore.turned.value = false;
    liveGeneration = "";
    return showLive(new Set());
  }
  const degrees = lightAt(now);
  // A new brood's own pictures come first.
  if (!lineageStore.breeding.value && lineageStore.readyId.value === generation.id)
    followLight(degrees, liveStore.lightMoving.value, generation.id);
  const environment = liveStore.environment.value;
  if (!environment || !CELLS.some((cell) => isLiveDrawn(individualSeenIn(cell))))
    return followOnServer(scene, degrees);
  const paths = partPaths(scene);
  const geometries = meshes.all(gl, paths);
  const hasPicture = picture.prepare(gl, scene.backdrop);
  if (!geometries || !hasPicture || !canvas) return showLive(new Set());
  // Time spent on compiling materials does not count as drawing.
  const adapts = liveStore.lightMoving.value || sceneStore.draggedPose.value !== null;
  if (!adapts || makingMaterials) resolution.pause();
  else if (resolution.step(now)) drawnKey = "";
  const tools = toolBox.prepare(gl, canvas, scene, adapts ? resolution.ratio : 1);
  if (!tools) return showLive(new Set());
  if (tools.isNew) drawnKey = "";
  const { layout, pens, dark, backdrop, meter } = tools;
  const [[small], [large], [metering]] = [tools.small, tools.large, tools.metering];
  const [geometry] = geometries;
  const pose = sceneStore.draggedPose.value ?? { rotation: rotationOf(scene), scale: scene.scale };
  const stage = stageOf(scene, pose, geometries);
  const view = viewOf(scene.camera, geometry.extent, pose, stage);
  const tangents = scene.tangents ?? "vertex";
  const parts = geometries.map((own, part) => ({
    geometry: own,
    tangents,
    place: stage.places[part],
  }));
  const key = JSON.stringify([paths, tangents, scene.camera, pose.rotation, pose.scale, stage]);
  const redrawn = key !== drawnKey;
  if (redrawn) {
    for (const surfaces of [tools.small, tools.large, tools.metering, tools.ground])
      if (surfaces.length > 0) drawSurfaces(gl, pens, surfaces, parts, view);
    drawnKey = key;
    placedKey = "";
    frames.forget();
  }
  const confirmed = sceneStore.scene.value ?? scene;
  // Not the dragged angle, which would cause a measurement of each material at every step.
  const base = confirmed.light_deg ?? 0;
  if (environment.key !== "") {
    const turns = environment.turns > 1;
    liveStore.turned.value = turns;
    const turn = turns ? turnOf(scene, degrees) : null;
    const measured = turns ? turnOf(confirmed, base) : null;
    const placed = JSON.stringify([key, turn, measured]);
    if (placed !== placedKey) {
      for (const surface of [small, large]) drawPlaces(gl, pens, surface, view, turn);
      drawPlaces(gl, pens, metering, view, measured);
      placedKey = placed;
    }
  }
  /** @param {number} at */
  const lightsAt = (at) => {
    const there = lightsOf(scene, geometry.extent, pose, at).slice(0, LIGHTS);
    return there.length > 0 ? there : [DARK];
  };
  const lights = lightsAt(degrees);
  const paintLights = paintLightsOf(scene, geometry.extent, pose, degrees, (image) => means.of(image));
  // What the server traces is requested once, whatever the resolution is now.
  const full = layOut(canvas, 1, Infinity) ?? layout;
  // A turned object is drawn without shadows until it rests.
  const shade = sceneStore.draggedPose.value ? "" : shadowKey(scene);
  const isClear = cache.showsClear() || draftMaterial.isClear();
  const unknown = !shadows.has(shade, isClear);
  if (unknown && shade === shadowKey(confirmed) && confirmed.id) {
    const of = { key: shade, sceneId: confirmed.id, side: full.large, lights: lights.length, isClear };
    shadows.request(gl, of);
    if (isLightMoved() || draft) return showLive(new Set());
  }
  const opaque = shadows.of(gl, shade, 0);
  const strength = strengthOf(lights);
  const all = Array.from({ length: METER_ANGLES }, (_, k) =>
    normalizedLights(lightsAt(base + (360 * k) / METER_ANGLES), strength),
  ).flat();
  if (redrawn) lightSurface(gl, pens, metering, all, opaque);
  // While the object rotates, the lit cells would be outdated before they are known.
  const learning =
    !sceneStore.draggedPose.value &&
    [small, large].map((surface) => readLitCells(gl, surface)).includes(true);
  for (const surface of [small, large]) updateLitCells(gl, surface.litCells, lights);
  const lightsKey = JSON.stringify([
    key,
    all.map(({ place, cone, intensity }) => [place, cone, intensity.map(Math.fround)]),
    environment.key,
    environment.key === "" ? 1 : strength,
    unknown ? "" : shade,
  ]);
  if (!sceneStore.draggedPose.value && lightsKey !== meteredKey) {
    lightSurface(gl, pens, metering, all, opaque);
    cache.remeter(gl);
    draftMaterial.remeter(gl);
    meteredKey = lightsKey;
  }
  const squares = resting ? layout.squares.filter(({ cell }) => cell === "centre") : layout.squares;
  const making = {
    meter,
    pens,
    look: { surface: metering, lights: all, around: 1 / strength },
    within: geometry.within,
    environment,
    together: context?.together ?? 1,
    painting: paintLights?.length ?? 0,
    clearing:
      !sceneStore.draggedPose.value && clear.canDraw(scene, confirmed) && others.areSmooth(scene),
  };
  // Before the others, because the user sees only this one change.
  const makingDraft = draftMaterial.work(gl, draft, making);
  /** @type {Individual[]} */
  const individuals = layout.squares.flatMap(({ cell }) => individualIn(cell) ?? []);
  // The centre's material is prepared first, because users look there first.
  const centre = individualIn("centre");
  const first = [centre, compareStore.pinned.value, ...individuals]
    .filter((one) => one !== null)
    .filter(isLiveDrawn);
  makingMaterials = cache.work(gl, resting ? [] : first, making);
  const widest = Math.max(...geometries.map(({ within }) => within));
  if (others.work(gl, scene, { ...making, within: widest })) makingMaterials = true;
  const materials = squares.flatMap((square) => {
    const of = individualSeenIn(square.cell);
    if (square.cell === "centre" && isDraftPicture(of)) return [];
    const edited = square.cell === "centre" && of?.id === draft?.of.id && draftMaterial.drawable(environment);
    const material = edited || (of && !resting && cache.drawable(of, environment));
    return material ? [{ ...square, material }] : [];
  });
  const shared = {
    key: JSON.stringify([key, unknown ? "" : shade, materialsOf(scene)]),
    lightsAt: (/** @type {number} */ at) => normalizedLights(lightsAt(at), strength),
    shadows: opaque,
  };
  const follows = sceneStore.draggedPose.value !== null || sceneStore.draggedScene.value !== null;
  const wait = (again = true) => {
    resolution.pause();
    showLive(new Set());
    publishLight(scene, geometry.extent, degrees);
    if (again) schedule();
  };
  const beside = hasOthers(scene) ? others.prepare(gl, scene, tools, shared, follows) : null;
  if (hasOthers(scene) && !beside) return wait();
  // All frames have one light: none is drawn under a moved light before all can be.
  if (isLightMoved() && materials.length < layout.squares.filter(mayBeDrawn).length) return wait();
  const sized = materials.map((one) => ({ ...one, side: one.cell === "centre" ? full.large : full.small }));
  const glass = clear.prepare(gl, { scene: confirmed, slots: lights.length }, sized);
  if (!glass) return wait(liveStore.lightMoving.value);
  const isDrawn = frames.draw(gl, tools, materials, {
    scene,
    seen: { key, view, parts },
    lit: {
      key: JSON.stringify([shared.key, degrees, all, paintLights]),
      lights,
      strength,
      shared: shared.lightsAt(degrees),
      paintLights,
      shadowsOf: (passed) => shadows.of(gl, shade, passed),
    },
    beside,
    glass,
    picture: picture.held,
    degrees,
    marks: pageStore.clippingShown.value,
  });
  if (!isDrawn) return showLive(new Set());
  const cells = new Set(materials.map(({ cell }) => cell));
  showLive(cells);
  // The light of a resting frame is that of its picture, and needs no dot.
  if (resting) liveStore.drawnLight.value = { degrees, direction: null };
  else {
    liveGeneration = generation.id;
    publishLight(scene, geometry.extent, degrees);
  }
  if (makingMaterials || makingDraft || learning || beside?.measures || liveStore.lightMoving.value)
    schedule();
}

/** Draws whenever something visible has changed. */
export function watchLive() {
  effect(() => {
    if (lineageStore.readyId.value !== null) setTimeout(openOnce);
  });
  effect(() => {
    // Subscribes to all that a drawing depends on; the loop reads it again.
    void [
      lineageStore.generation.value,
      sceneStore.editedScene.value,
      sceneStore.draggedScene.value,
      sceneStore.draggedPose.value,
      lineageStore.readyId.value,
      lineageStore.draft.value,
      liveStore.lightMoving.value,
      liveStore.supported.value,
      pageStore.clippingShown.value,
      compareStore.pinned.value,
      compareStore.flipped.value,
      compareStore.targetInCentre.value,
    ];
    schedule();
  });
  document.addEventListener("visibilitychange", schedule);
}
