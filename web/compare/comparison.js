/**
 * Comparison of several materials by measurement: which are chosen, and the request to the server.
 *
 * @import { Cell, Comparison, Individual, Outline, Preset } from "../model.js"
 */
import { effect } from "../vendor/signals-core.js";
import * as api from "../api/routes.js";
import { birthOf } from "../lineage/individuals.js";
import { listPresets } from "../lineage/presets.js";
import { FRAMES, lineageStore } from "../lineage/store.js";
import { clearProblems, guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { compareStore } from "./store.js";

/**
 * A material that can be compared.
 *
 * @typedef {{key: string, name: string, picture: string, preset?: Preset}} Choice `key`: id of an
 *   individual, or name of a preset, whose genome is sent to the server first.
 */

/** Least and largest number of materials in a comparison. */
export const FEWEST = 2;
export const MOST = 6;
/** Side of the compared pictures. */
const SIDE_PX = 256;

/** @param {Individual} of @param {string} name @returns {Choice} */
const choice = (of, name) => ({ key: of.id, name, picture: of.thumbnail });

/**
 * Choice of an individual, named by its place in its generation.
 * @param {Individual} of
 * @param {Outline} born
 */
const choiceFor = (of, born) => choice(of, `generation ${born.index}, frame ${of.slot + 1}`);

/** @param {Preset} preset @returns {Choice} */
export const presetChoice = (preset) => ({
  key: preset.name,
  name: preset.title,
  picture: `/web/presets/${preset.name}.png`,
  preset,
});

/**
 * Choice of an individual, named by the place where it was born in the open lineage.
 * @param {Individual} of
 * @param {string} other its name if it was not born there
 */
function choiceByBirth(of, other) {
  const born = birthOf(of.id);
  return born ? choiceFor(of, born) : choice(of, other);
}

/** Choices of the shown generation: the centre, then the frames, each once. @returns {Choice[]} */
export function shownChoices() {
  const of = lineageStore.generation.value;
  if (!of) return [];
  const around = of.individuals.filter((one) => one.slot < FRAMES).map((one) => choiceFor(one, of));
  return of.centre
    ? [choiceByBirth(of.centre, "the centre"), ...around]
    : around;
}

/** @returns {Choice[]} */
export const favouriteChoices = () =>
  lineageStore.ordered.value.flatMap((born) =>
    born.individuals.filter((one) => one.favourite).map((one) => choiceFor(one, born)),
  );

/** @param {Choice} of */
export const isChosen = (of) => compareStore.chosen.value.some(({ key }) => key === of.key);

/** Adds a choice, or removes it. @param {Choice} of */
export function toggle(of) {
  if (isChosen(of))
    compareStore.chosen.value = compareStore.chosen.value.filter(({ key }) => key !== of.key);
  else if (compareStore.chosen.value.length < MOST)
    compareStore.chosen.value = [...compareStore.chosen.value, of];
  pageStore.announcement.value = `${of.name} is ${isChosen(of) ? "" : "not "}compared; ${compareStore.chosen.value.length} of ${MOST} are chosen.`;
}

/** Makes a choice the reference for differences and exposure. @param {Choice} of */
export function setReference(of) {
  compareStore.chosen.value = [
    of,
    ...compareStore.chosen.value.filter(({ key }) => key !== of.key),
  ];
  pageStore.announcement.value = `${of.name} is the reference.`;
}

/** Hash or id of a choice on the server. @param {Choice} of */
const materialKey = async ({ key, preset }) =>
  preset ? (await api.createGenome(new Blob([preset.text]))).hash : key;

/** Asks the server to compare the chosen materials. */
export async function compareChosen() {
  const of = compareStore.chosen.value;
  const { id, scene } = lineageStore.lineage.value ?? {};
  if (compareStore.comparing.value || of.length < FEWEST || !scene) return;
  compareStore.comparing.value = true;
  clearProblems("comparison");
  try {
    await guarded("comparison", async () => {
      const materials = await Promise.all(of.map(materialKey));
      const found = await api.compare(materials, scene, SIDE_PX);
      if (lineageStore.lineage.value?.id !== id) return;
      compareStore.result.value = { of, found };
      compareStore.choicesOpen.value = false;
      pageStore.announcement.value = `${of.length} materials are compared.`;
    });
  } finally {
    compareStore.comparing.value = false;
  }
}

/** Opens with the last choice, else with the centre and B. */
export function openComparison() {
  compareStore.comparisonOpen.value = true;
  void guarded("comparison", listPresets);
  if (compareStore.chosen.value.length >= FEWEST) return void compareChosen();
  const centre = lineageStore.centre.value;
  const b = compareStore.pinned.value;
  const first = centre ? [choiceByBirth(centre, "the centre")] : [];
  compareStore.chosen.value =
    b && b.id !== centre?.id ? [...first, choiceByBirth(b, "B")] : first;
  void compareChosen();
}

export function closeComparison() {
  compareStore.comparisonOpen.value = false;
  clearProblems("comparison");
}

/** Clears the choice when another lineage is opened, which has another scene. */
export function watchComparison() {
  let before = lineageStore.lineage.peek()?.id;
  return effect(() => {
    const now = lineageStore.lineage.value?.id;
    if (now !== before) {
      closeComparison();
      compareStore.chosen.value = [];
      compareStore.result.value = null;
      compareStore.choicesOpen.value = true;
    }
    before = now;
  });
}
