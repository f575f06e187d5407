/**
 * Everything the page knows, as signals, and what follows from it. Owns no network and no drawing: other modules write
 * here, the view reads.
 *
 * @import { Cell, Generation, Individual, Knobs, Lineage, Locks, Place, Scene, SystemAnswer, Trail, Trouble, Turning, UploadedMesh } from "./types.js"
 */
import { descentOf } from "./history.js";
import { computed, signal } from "./vendor/signals-core.js";

/** Frames around the centre. */
export const FRAMES = 20;

/** Saturation for breeding by eye; the three channels evolve apart and look garish at 1. */
export const DEFAULT_SATURATION = 0.65;

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** @type {Signal<SystemAnswer|null>} */
export const system = signal(null);
/** @type {Signal<Lineage[]>} */
export const lineages = signal([]);
/** @type {Signal<Lineage|null>} */
export const lineage = signal(null);
/** @type {Signal<Scene|null>} */
export const scene = signal(null);
/** @type {Signal<Partial<Scene>|null>} Changes of the scene that the server has not confirmed yet. */
export const wished = signal(null);
/** @type {Signal<Partial<Scene>|null>} Changes of the scene that a hand has not let go yet. */
export const held = signal(null);
/** @type {Signal<Map<string, Generation>>} Generations of the open lineage by id; replaced, never changed in place. */
export const generations = signal(new Map());
/** @type {Signal<string|null>} Id of the generation that is shown. */
export const shown = signal(null);
/** @type {Signal<Trail>} */
export const trail = signal({ past: [], future: [] });
/** @type {Signal<Individual|null>} */
export const mate = signal(null);
/** @type {Signal<Cell>} The frame that the Tab key reaches. */
export const focused = signal("centre");
/** @type {Signal<Knobs>} */
export const knobs = signal({
  mutation: 0.3,
  recombination: 0.5,
  isotropic: false,
  homogeneous: false,
  saturation: DEFAULT_SATURATION,
  energy_limit: false,
});
/** @returns {Locks} */
export const noLocks = () => ({ instructions: [], constants: [], channels: [], layers: [], parameters: [] });

/** @type {Signal<Locks>} What children keep of their parent. */
export const locks = signal(noLocks());
/** @type {Signal<Partial<Record<Place, Trouble>>>} */
export const troubles = signal({});
/** @type {Signal<boolean>} A brood is being made. */
export const breeding = signal(false);
/** @type {Signal<boolean>} A new scene is on its way. */
export const sceneBusy = signal(false);
/** @type {Signal<Turning|null>} */
export const turning = signal(null);
/** @type {Signal<UploadedMesh[]>} Meshes uploaded from this browser. */
export const meshes = signal([]);
/** @type {Signal<number|null>} Milliseconds from the click to the last picture. */
export const elapsed = signal(null);
/** @type {Signal<string>} What a screen reader is told. */
export const announcement = signal("");
/** @type {Signal<boolean>} */
export const fileOver = signal(false);
/** @type {Signal<boolean>} Left pane; folded at first where it would cover the frames. */
export const knobsOpen = signal(globalThis.innerWidth > 900);
/** @type {Signal<boolean>} Right pane. */
export const detailsOpen = signal(globalThis.innerWidth > 1180);
/** @type {Signal<boolean>} */
export const lineagesOpen = signal(false);
/** @type {Signal<boolean>} */
export const presetsOpen = signal(false);
/** @type {Signal<boolean>} Surround of 18 % grey instead of near-black. */
export const greySurround = signal(false);
/** @type {Signal<boolean>} The line of help under the frames. */
export const hinting = signal(true);
/** @type {Signal<boolean>} Marks where a picture burns out and where it is black. */
export const clipped = signal(false);

/** @type {Signal<Generation|null>} */
export const generation = computed(() => (shown.value && generations.value.get(shown.value)) || null);

/** The scene as the person left it, confirmed or not: what the controls show. @type {Signal<Scene|null>} */
export const wishedScene = computed(() => scene.value && { ...scene.value, ...wished.value, ...held.value });

/** The individual shown large: the centre, or the first child of a random start. @type {Signal<Individual|null>} */
export const large = computed(() => generation.value && largeOf(generation.value));

/** Generations by index. @type {Signal<Generation[]>} */
export const inOrder = computed(() => [...generations.value.values()].sort((a, b) => a.index - b.index));

/** Who came from whom. */
export const descent = computed(() => descentOf(inOrder.value));

/**
 * The individual that a generation shows large.
 * @param {Generation} of
 * @returns {Individual|null}
 */
export function largeOf(of) {
  return of.centre ?? of.individuals[0] ?? null;
}

/**
 * The individual in a frame of the generation that is shown.
 * @param {Cell} cell
 * @returns {Individual|null}
 */
export function individualIn(cell) {
  if (cell === "centre") return large.value;
  return generation.value?.individuals.find((individual) => individual.slot === cell) ?? null;
}

/** An individual of the generation that is shown. @param {string} id */
export const individualOf = (id) => [generation.value?.centre, ...(generation.value?.individuals ?? [])].find((one) => one?.id === id) ?? null;

/**
 * Takes in what was read, but for marks that were changed here after it was.
 * @param {Generation[]} news
 */
export function putGenerations(news) {
  const next = new Map(generations.value);
  for (const item of news) {
    const known = next.get(item.id);
    /** @param {Individual} one */
    const latest = (one) => {
      const { favourite, note, version } = [known?.centre, ...(known?.individuals ?? [])].find((it) => it?.id === one.id) ?? one;
      return version > one.version ? { ...one, favourite, note, version } : one;
    };
    next.set(item.id, known ? { ...item, centre: item.centre && latest(item.centre), individuals: item.individuals.map(latest) } : item);
  }
  generations.value = next;
}

/**
 * Replaces an individual wherever it is shown.
 * @param {string} id
 * @param {Partial<Individual>} change
 */
export function changeIndividual(id, change) {
  const next = new Map(generations.value);
  /** @param {Individual} one */
  const changed = (one) => (one.id === id ? { ...one, ...change } : one);
  for (const [key, item] of next) {
    if (item.centre?.id !== id && !item.individuals.some((one) => one.id === id)) continue;
    next.set(key, {
      ...item,
      centre: item.centre && changed(item.centre),
      individuals: item.individuals.map(changed),
    });
  }
  generations.value = next;
}

/**
 * Tells a problem at its place.
 * @param {Place} place
 * @param {Trouble} trouble
 */
export function tell(place, trouble) {
  troubles.value = { ...troubles.value, [place]: trouble };
}

/** @param {Place[]} places */
export function forget(...places) {
  if (!places.some((place) => troubles.value[place])) return;
  const next = { ...troubles.value };
  for (const place of places) delete next[place];
  troubles.value = next;
}
