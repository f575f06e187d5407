/**
 * Several materials side by side: which were chosen, and what the server found of them. Owns the choice and its bounds, which
 * stay while the page is open; knows nothing of drawing.
 *
 * @import { Cell, Comparison, Generation, Individual, Preset } from "./types.js"
 */
import { computed, effect, signal } from "./vendor/signals-core.js";
import * as api from "./api.js";
import { pinned } from "./compare.js";
import { guarded } from "./lineage.js";
import { listPresets } from "./presets.js";
import { FRAMES, announcement, forget, generation, inOrder, large, lineage } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/**
 * Something that can be compared: an individual by its id, or a preset, whose genome the server has to be given first.
 * @typedef {{key: string, name: string, picture: string, preset?: Preset}} Choice
 */

/** As the server has them. */
export const FEWEST = 2;
export const MOST = 6;
const SIDE_PX = 256;

/** @type {Signal<boolean>} */
export const comparing = signal(false);
/** In the order of choosing; the others are held against the first. @type {Signal<Choice[]>} */
export const chosen = signal([]);
/** What was found, with the choice that it is of. @type {Signal<{of: Choice[], found: Comparison}|null>} */
export const compared = signal(null);
/** Whether what can be chosen is in sight. @type {Signal<boolean>} */
export const offering = signal(true);
/** @type {Signal<boolean>} */
export const waiting = signal(false);

/** Whether the answer is of what is chosen now. */
export const isCurrent = computed(() => compared.value !== null && keysOf(compared.value.of) === keysOf(chosen.value));

/** @param {Choice[]} of */
const keysOf = (of) => of.map(({ key }) => key).join();

/** @param {Individual} of @param {string} name @returns {Choice} */
const choice = (of, name) => ({ key: of.id, name, picture: of.thumbnail });

/** An individual of a generation, named by its place. @param {Individual} of @param {Generation} born */
export const placed = (of, born) => choice(of, `generation ${born.index}, frame ${of.slot + 1}`);

/** @param {Preset} preset @returns {Choice} */
export const ofPreset = (preset) => ({ key: preset.name, name: preset.title, picture: `/web/presets/${preset.name}.png`, preset });

/** The open lineage's individuals that were born with their own place. @param {string} id */
function bornAs(id) {
  for (const born of inOrder.value) {
    const found = born.individuals.find((one) => one.id === id);
    if (found) return placed(found, born);
  }
  return null;
}

/** What is on the stage: the centre, then the frames; each once. @returns {Choice[]} */
export function onStage() {
  const of = generation.value;
  if (!of) return [];
  const around = of.individuals.filter((one) => one.slot < FRAMES).map((one) => placed(one, of));
  return of.centre ? [bornAs(of.centre.id) ?? choice(of.centre, "the centre"), ...around] : around;
}

/** @returns {Choice[]} */
export const favourites = () => inOrder.value.flatMap((born) => born.individuals.filter((one) => one.favourite).map((one) => placed(one, born)));

/** @param {Choice} of */
export const isChosen = (of) => chosen.value.some(({ key }) => key === of.key);

/** Takes one in, or leaves it out again. @param {Choice} of */
export function toggle(of) {
  if (isChosen(of)) chosen.value = chosen.value.filter(({ key }) => key !== of.key);
  else if (chosen.value.length < MOST) chosen.value = [...chosen.value, of];
  announcement.value = `${of.name} is ${isChosen(of) ? "" : "not "}compared; ${chosen.value.length} of ${MOST} are chosen.`;
}

/** Holds the others against it, at its exposure. @param {Choice} of */
export function putFirst(of) {
  chosen.value = [of, ...chosen.value.filter(({ key }) => key !== of.key)];
  announcement.value = `${of.name} is the first.`;
}

/** The hash or id that the server knows one by. @param {Choice} of */
const named = async ({ key, preset }) => (preset ? (await api.createGenome(new Blob([preset.text]))).hash : key);

/** Asks for what is chosen. */
export async function compareChosen() {
  const of = chosen.value;
  const { id, scene } = lineage.value ?? {};
  if (waiting.value || of.length < FEWEST || !scene) return;
  waiting.value = true;
  forget("comparison");
  try {
    await guarded("comparison", async () => {
      const materials = await Promise.all(of.map(named));
      const found = await api.compare(materials, scene, SIDE_PX);
      if (lineage.value?.id !== id) return;
      compared.value = { of, found };
      offering.value = false;
      announcement.value = `${of.length} materials are compared.`;
    });
  } finally {
    waiting.value = false;
  }
}

/** Opens with what was chosen before, else with the centre and B. */
export function openComparison() {
  comparing.value = true;
  void guarded("comparison", listPresets);
  if (chosen.value.length >= FEWEST) return void compareChosen();
  const centre = large.value;
  const b = pinned.value;
  const first = centre ? [bornAs(centre.id) ?? choice(centre, "the centre")] : [];
  chosen.value = b && b.id !== centre?.id ? [...first, bornAs(b.id) ?? choice(b, "B")] : first;
  void compareChosen();
}

export function closeComparison() {
  comparing.value = false;
  forget("comparison");
}

/** Another lineage has another scene, and other individuals to choose from. */
export function watchComparison() {
  let before = lineage.peek()?.id;
  return effect(() => {
    const now = lineage.value?.id;
    if (now !== before) {
      closeComparison();
      chosen.value = [];
      compared.value = null;
      offering.value = true;
    }
    before = now;
  });
}
