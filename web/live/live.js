/**
 * The frames drawn live, under the moving light and while the object is turned. Owns the loop: what is there is drawn, what is
 * missing is made, and nothing is drawn when nothing changed. The server's pictures stand in wherever this has nothing to show.
 *
 * @import { Cell, Individual, Scene } from "../types.js"
 * @import { Geometry } from "./geometry.js"
 * @import { Meter } from "./material.js"
 * @import { Linked } from "./program.js"
 * @import { Context } from "./stage.js"
 * @import { Pens, Surface } from "./surface.js"
 * @import { Extent, PointLight } from "./view.js"
 */
import { computed, effect, signal } from "../vendor/signals-core.js";
import { flipped, pinned, seenIn, targetSeen } from "../compare.js";
import { extentOf, extents } from "../extents.js";
import { ready } from "../pictures.js";
import { FRAMES, breeding, clipped, generation, held, individualIn, turning, wishedScene } from "../state.js";
import { dropGeometry, loadGeometry } from "./geometry.js";
import { chosenBefore, letMove, lightAt, moving, rest } from "./light.js";
import { METER_ANGLES, METER_SIDE, drawMaterial, makeDark, makeMeter } from "./material.js";
import { Pace, displayInterval } from "./pace.js";
import { learnParts, lightParts } from "./parts.js";
import { layOut, observePixels, openContext } from "./stage.js";
import { followLight, still } from "./stills.js";
import { Stock } from "./stock.js";
import { dropSurface, drawSurface, lightSurface, makePens, makeSurface } from "./surface.js";
import { LIGHTS, evenedOut, isDrawable, lightsOf, rotationOf, seenAt, strengthOf, viewOf } from "./view.js";

/** @template T @typedef {import("../vendor/signals-core.js").Signal<T>} Signal */

/** Frames whose picture is drawn here. @type {Signal<Set<Cell>>} */
export const liveCells = signal(new Set());
/** Whether this browser can; null until it was tried. @type {Signal<boolean|null>} */
export const able = signal(null);

/** Where a scene has no light at all: what is drawn is black then, not missing. @type {PointLight} */
const DARK = { place: [0, 0, 1], intensity: [0, 0, 0] };

/** @type {HTMLCanvasElement|null} */
let canvas = null;
/** @type {Context|null} */
let context = null;
/** @type {{pens: Pens, dark: Linked, meter: Meter, metering: Surface, small: Surface, large: Surface}|null} */
let tools = null;
/** @type {{mesh: string, geometry: Geometry}|null} */
let object = null;
let loading = "";
/** What the surfaces show, where the light was, and what exposures were measured for. */
let drawn = "";
let litAt = "";
let metered = "";
let requested = false;
/** What could not be fetched is asked for again after so long. */
const AGAIN_MS = 5000;
/** Whether materials are being made. */
let making = false;
const pace = new Pace();
const stock = new Stock(schedule);

/** Told where the light is each time something is drawn. @type {Set<(degrees: number, seen: import("../types.js").Vec3|null) => void>} */
export const watchers = new Set();

/** Whether anything but the server's pictures is wanted: the light is not where they have it, or light or object are in a hand. */
const wanted = () => moving.value || rest.value !== 0 || turning.value !== null || held.value !== null;

/** Draws at the next opportunity. */
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
    forget();
  });
  element.addEventListener("webglcontextrestored", () => {
    // What the context was asked to be able to do is lost with it: without it no surface can be drawn into.
    if (context) context = openContext(element);
    schedule();
  });
  observePixels(new ResizeObserver(schedule), element);
}

/** A lost context takes everything with it that was made in it. */
function forget() {
  tools = null;
  object = null;
  drawn = "";
  litAt = "";
  metered = "";
  stock.lose();
  show(new Set());
}

/** Tries once whether the browser can, when the first pictures are there: by hardware the light goes round from then on. */
function tryOnce() {
  if (able.value !== null || !canvas) return;
  context = openContext(canvas);
  able.value = context !== null;
  if (!context) return;
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const begin = () => {
    // Nobody has put it anywhere meanwhile.
    if (rest.value !== 0 || moving.value) return;
    if (chosenBefore() ?? !(still || context?.software)) letMove(true, false);
  };
  if (context.software) return begin();
  // Before anything is drawn, which could hold up the display's frames.
  void displayInterval().then((interval) => {
    pace.aimAt(interval);
    begin();
  });
}

/** @param {WebGL2RenderingContext} gl @param {Scene} scene */
async function load(gl, scene) {
  loading = scene.mesh;
  try {
    const geometry = await loadGeometry(gl, scene.mesh);
    if (!gl.isContextLost()) {
      if (object) dropGeometry(gl, object.geometry);
      object = { mesh: scene.mesh, geometry };
    }
  } catch {
    // The server's pictures stay meanwhile.
    await new Promise((done) => setTimeout(done, AGAIN_MS));
  }
  if (loading === scene.mesh) loading = "";
  schedule();
}

/**
 * Sizes the buffers; the surfaces are made anew where theirs have changed.
 * @param {WebGL2RenderingContext} gl
 * @param {Scene} scene
 */
function prepare(gl, scene) {
  if (!canvas) return null;
  // A texture holds what falls on the large frame from each light, one below the other.
  const slots = Math.max(1, Math.min(LIGHTS, scene.lights?.length ?? 1));
  const layout = layOut(canvas, moving.value || turning.value ? pace.ratio : 1, gl.getParameter(gl.MAX_TEXTURE_SIZE) / slots);
  if (!layout) return null;
  if (canvas.width !== layout.width || canvas.height !== layout.height) {
    canvas.width = layout.width;
    canvas.height = layout.height;
  }
  Object.assign(canvas.style, layout.css);
  tools ??= {
    pens: makePens(gl),
    dark: makeDark(gl),
    meter: makeMeter(gl),
    metering: makeSurface(gl, METER_SIDE, LIGHTS * METER_ANGLES),
    small: makeSurface(gl, layout.small, slots),
    large: makeSurface(gl, layout.large, slots),
  };
  for (const name of /** @type {const} */ (["small", "large"])) {
    if (tools[name].side === layout[name] && tools[name].slots === slots) continue;
    dropSurface(gl, tools[name]);
    tools[name] = makeSurface(gl, layout[name], slots);
    drawn = "";
  }
  // What there is no memory for is not drawn.
  return tools.small.whole && tools.large.whole ? { layout, ...tools } : null;
}

/** @param {Set<Cell>} cells */
function show(cells) {
  // What was drawn last must not be seen behind the server's pictures.
  if (canvas) canvas.style.visibility = cells.size > 0 ? "visible" : "hidden";
  const before = liveCells.value;
  if (cells.size !== before.size || [...cells].some((cell) => !before.has(cell))) liveCells.value = cells;
}

/** @type {Cell[]} */
const CELLS = ["centre", ...Array(FRAMES).keys()];

/** Whether the scene is one that frames can be drawn of. */
export const sceneDrawable = computed(() => wishedScene.value === null || isDrawable(wishedScene.value));

/** Whether it can be drawn here. @param {Individual|null} of */
const isDrawnHere = (of) => of !== null && sceneDrawable.value;

/** Whether it is certainly seen in the server's pictures alone. @param {Individual|null} of */
export const isPictured = (of) => of !== null && !sceneDrawable.value;

/** Where the light is, told to those who show it. @param {Scene} scene @param {Extent} extent @param {number} degrees */
function tell(scene, extent, degrees) {
  const pose = turning.value ?? { rotation: rotationOf(scene), scale: scene.scale };
  const of = seenIn("centre");
  // The dot is where the picture below it has the light.
  const pictured = of && !liveCells.value.has("centre") && !isDrawnHere(of) ? (still.value?.degrees ?? 0) : degrees;
  const [light] = lightsOf(scene, extent, pose, (scene.light_deg ?? 0) + pictured);
  for (const told of watchers) told(degrees, light ? seenAt(light, viewOf(scene.camera, extent, pose)) : null);
}

/** Nothing is drawn here, but pictures of the server may follow the light. @param {Scene} scene @param {number} degrees */
function onlyFollow(scene, degrees) {
  pace.pause();
  show(new Set());
  const extent = extents.peek().get(scene.mesh);
  if (extent) tell(scene, extent, degrees);
  else void extentOf(scene.mesh).then(schedule, () => {});
  if (moving.value) schedule();
}

/** @param {number} now */
function frame(now) {
  requested = false;
  const scene = wishedScene.value;
  const gl = context?.gl;
  if (!gl || gl.isContextLost() || !scene || !generation.value || !wanted()) {
    pace.pause();
    still.value = null;
    return show(new Set());
  }
  const degrees = lightAt(now);
  // A new brood's own pictures come first.
  if (!breeding.value && ready.value === generation.value.id) followLight(degrees, moving.value);
  if (!CELLS.some((cell) => isDrawnHere(seenIn(cell)))) return onlyFollow(scene, degrees);
  if (object?.mesh !== scene.mesh) {
    if (loading !== scene.mesh) void load(gl, scene);
    return show(new Set());
  }
  // Making materials takes time that drawing them does not.
  if (!(moving.value || turning.value) || making) pace.pause();
  else if (pace.step(now)) drawn = "";
  const prepared = prepare(gl, scene);
  if (!prepared) return show(new Set());
  const { layout, pens, dark, meter, metering, small, large } = prepared;
  const { geometry } = object;
  const base = scene.light_deg ?? 0;
  const pose = turning.value ?? { rotation: rotationOf(scene), scale: scene.scale };
  const view = viewOf(scene.camera, geometry.extent, pose);
  const key = JSON.stringify([scene.mesh, scene.camera, pose.rotation, pose.scale]);
  if (key !== drawn) {
    for (const surface of [metering, small, large]) drawSurface(gl, pens, surface, geometry, view);
    drawn = key;
    litAt = "";
  }
  /** @param {number} at */
  const lightsAt = (at) => {
    const there = lightsOf(scene, geometry.extent, pose, base + at).slice(0, LIGHTS);
    return there.length > 0 ? there : [DARK];
  };
  const lights = lightsAt(degrees);
  const lit = JSON.stringify(lights.map((light) => light.place));
  const strength = strengthOf(lights);
  const all = Array.from({ length: METER_ANGLES }, (_, k) => evenedOut(lightsAt((360 * k) / METER_ANGLES), strength)).flat();
  if (lit !== litAt) {
    if (litAt === "") lightSurface(gl, pens, metering, all);
    for (const surface of [small, large]) lightSurface(gl, pens, surface, lights);
    litAt = lit;
  }
  // While it is turned, what was learnt would be over before it is of use.
  const learning = !turning.value && [small, large].map((surface) => learnParts(gl, surface)).includes(true);
  for (const surface of [small, large]) lightParts(gl, surface.parts, lights);
  const lightsKey = JSON.stringify([key, all.map((light) => [light.place, light.intensity.map(Math.fround)])]);
  if (!turning.value && lightsKey !== metered) {
    stock.remeter(gl);
    metered = lightsKey;
  }
  /** @type {Individual[]} */
  const individuals = layout.squares.flatMap(({ cell }) => individualIn(cell) ?? []);
  // The centre stands last in the document's order of rows, but is looked at first.
  const centre = individualIn("centre");
  const first = [centre, pinned.value, ...individuals].filter((one) => one !== null).filter(isDrawnHere);
  making = stock.work(gl, first, { meter, look: { surface: metering, lights: all }, within: geometry.within, together: context?.together ?? 1 });
  const exposure = scene.film.exposure;
  const materials = layout.squares.flatMap((square) => {
    const of = seenIn(square.cell);
    const material = of && stock.drawable(of);
    return material ? [{ ...square, material }] : [];
  });
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.disable(gl.SCISSOR_TEST);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT);
  for (const { cell, corner, material } of materials) {
    const surface = cell === "centre" ? large : small;
    const where = { corner, gain: exposure === "auto" ? material.gain / strength : 2 ** exposure, marks: clipped.value };
    drawMaterial(gl, material, dark, { surface, lights }, where);
  }
  const cells = new Set(materials.map(({ cell }) => cell));
  show(cells);
  tell(scene, geometry.extent, degrees);
  if (making || learning || moving.value) schedule();
}

/** Draws whenever what is shown has changed. */
export function watchLive() {
  effect(() => {
    if (ready.value !== null) setTimeout(tryOnce);
  });
  effect(() => {
    // What a drawing depends on; the loop reads it again.
    void [generation.value, wishedScene.value, held.value, turning.value, moving.value, rest.value, able.value, clipped.value, pinned.value, flipped.value, targetSeen.value];
    schedule();
  });
  document.addEventListener("visibilitychange", schedule);
}
