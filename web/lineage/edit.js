/**
 * Editing of the parameters of the centre's models by hand. The edited genome is a draft on the
 * page until it is stored as a child.
 *
 * @import { Edit, Individual, ParameterInfo, Place } from "../model.js"
 */
import { effect, untracked } from "../vendor/signals-core.js";
import * as api from "../api/routes.js";
import { clearProblems, guarded, showProblem } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { sceneSettled } from "../scene/edit.js";
import { navigationCount, show, storeBred } from "./generations.js";
import { genomeIn, isLayered } from "./layers.js";
import { makeGeneration } from "./making.js";
import { pickedChannels, readValue, valueAt, withValue } from "./parameters.js";
import { toonShape } from "./toon_shape.js";
import { startClock } from "./pictures.js";
import { lineageStore } from "./store.js";

/** Number of edits kept; the oldest are dropped. */
const KEPT = 50;

/**
 * Edits that are not stored, by id of the individual: they are there again after the user has bred
 * from another frame and come back.
 * @type {Map<string, Edit>}
 */
const kept = new Map();

/** Names of the channels of a colour. */
export const CHANNEL_NAMES = ["red", "green", "blue"];

/**
 * Key of a parameter's field.
 * @param {number} layer
 * @param {string} name
 * @param {number} channel 0 for a parameter of one number
 */
export const fieldKey = (layer, name, channel) => `${layer}-${name}-${channel}`;

/** Shows or hides the controls. */
export function toggleEditing() {
  lineageStore.editing.value = !lineageStore.editing.value;
  if (!lineageStore.editing.value) clearProblems("edit");
}

/** Reads the models once. */
async function readModels() {
  if (lineageStore.models.peek().size > 0) return;
  const all = await api.listModels();
  lineageStore.models.value = new Map(all.map((one) => [one.name, one]));
}

/** Begins an edit of an individual, or takes up the last one. @param {Individual} of */
async function begin(of) {
  const [text] = await Promise.all([api.getGenomeText(of.hash), readModels()]);
  if (lineageStore.centre.peek()?.id !== of.id) return;
  lineageStore.edit.value = kept.get(of.id) ?? {
    of,
    text,
    layers: genomeIn(text).layers,
    typed: new Map(),
    wrong: new Map(),
  };
}

/** Reads what is needed to edit the centre while the controls are shown. */
export const watchEdit = () =>
  effect(() => {
    const of = lineageStore.centre.value;
    if (!lineageStore.editing.value || !of || !isLayered(of)) return;
    if (lineageStore.edit.peek()?.of.id === of.id) return;
    untracked(() => void guarded("edit", () => begin(of), true));
  });

/**
 * The edit of the centre; null where the controls are hidden or its genome is not read yet. Tracks
 * signals.
 */
export function presentEdit() {
  const edit = lineageStore.edit.value;
  const isShown = lineageStore.editing.value && edit?.of.id === lineageStore.centre.value?.id;
  return isShown ? edit : null;
}

/** @param {Edit} edit */
function store(edit) {
  lineageStore.edit.value = edit;
  kept.delete(edit.of.id);
  kept.set(edit.of.id, edit);
  const [oldest] = kept.keys();
  if (kept.size > KEPT) kept.delete(oldest);
}

/**
 * @param {Map<string, string>} map
 * @param {string} key
 * @param {string} value nothing to remove the key
 */
function withEntry(map, key, value) {
  const next = new Map(map);
  if (value) next.set(key, value);
  else next.delete(key);
  return next;
}

/**
 * Parameter of an edit as the genome has it.
 * @param {Edit} edit
 * @param {number} layer
 * @param {string} name
 */
const valueOf = (edit, layer, name) =>
  edit.layers[layer].parameters.find((one) => one.name === name)?.value ?? "";

/**
 * Replaces one number of a parameter.
 * @param {Edit} edit
 * @param {number} layer
 * @param {string} name
 * @param {number} channel
 * @param {number} to
 * @returns {Edit}
 */
function withNumber(edit, layer, name, channel, to) {
  const now = valueOf(edit, layer, name);
  if (typeof now === "string") return edit;
  return { ...edit, layers: withValue(edit.layers, layer, name, now.with(channel, to)) };
}

/**
 * Sets a number by its slider.
 * @param {ParameterInfo} of
 * @param {number} layer
 * @param {number} channel
 * @param {number} position 0 to 1
 */
export function slideValue(of, layer, channel, position) {
  const edit = presentEdit();
  if (!edit) return;
  const key = fieldKey(layer, of.name, channel);
  store({
    ...withNumber(edit, layer, of.name, channel, valueAt(of, position)),
    typed: withEntry(edit.typed, key, ""),
    wrong: withEntry(edit.wrong, key, ""),
  });
}

/**
 * Sets a number by its text; keeps the value before while the text is not valid.
 * @param {ParameterInfo} of
 * @param {number} layer
 * @param {number} channel
 * @param {string} text
 */
export function typeValue(of, layer, channel, text) {
  const edit = presentEdit();
  if (!edit) return;
  const key = fieldKey(layer, of.name, channel);
  const { value, wrong } = readValue(of, text);
  const next = value === null ? edit : withNumber(edit, layer, of.name, channel, value);
  // A reason is first shown when the field is left, because half a number is often wrong.
  const shown = edit.wrong.has(key) ? wrong : "";
  const typed = new Map(edit.typed).set(key, text);
  store({ ...next, typed, wrong: withEntry(edit.wrong, key, shown) });
}

/**
 * Ends the typing in a field: a valid text is replaced by the value, another gets its reason.
 * @param {ParameterInfo} of
 * @param {number} layer
 * @param {number} channel
 * @param {string} name in the reason
 */
export function leaveField(of, layer, channel, name) {
  const edit = presentEdit();
  const key = fieldKey(layer, of.name, channel);
  const text = edit?.typed.get(key);
  if (!edit || text === undefined) return;
  const { wrong } = readValue(of, text, name);
  store({
    ...edit,
    typed: withEntry(edit.typed, key, wrong ? text : ""),
    wrong: withEntry(edit.wrong, key, wrong),
  });
}

/** @param {ParameterInfo} of @param {number} layer @param {string} word */
export function chooseWord(of, layer, word) {
  const edit = presentEdit();
  if (edit) store({ ...edit, layers: withValue(edit.layers, layer, of.name, word) });
}

/** @param {ParameterInfo} of @param {number} layer @param {string} color `#rrggbb` */
export function pickColor(of, layer, color) {
  const edit = presentEdit();
  if (!edit) return;
  let { typed, wrong } = edit;
  for (const channel of CHANNEL_NAMES.keys()) {
    typed = withEntry(typed, fieldKey(layer, of.name, channel), "");
    wrong = withEntry(wrong, fieldKey(layer, of.name, channel), "");
  }
  const layers = withValue(edit.layers, layer, of.name, pickedChannels(color));
  store({ ...edit, layers, typed, wrong });
}

/** Brings the stored values back. */
export function resetEdit() {
  const edit = presentEdit();
  if (!edit) return;
  kept.delete(edit.of.id);
  clearProblems("edit");
  lineageStore.edit.value = {
    ...edit,
    layers: genomeIn(edit.text).layers,
    typed: new Map(),
    wrong: new Map(),
  };
  pageStore.announcement.value = "The stored parameters are shown again.";
}

/**
 * Stores the edited centre as a child of the centre, and shows it.
 * @returns {Promise<Individual|null>} null if nothing was stored
 */
export async function makeChild() {
  const of = lineageStore.lineage.value;
  const [edit, draft] = [presentEdit(), lineageStore.draft.value];
  if (!of || !edit || (!draft && edit.wrong.size === 0)) return null;
  if (edit.wrong.size > 0 || !draft) {
    const detail = [...edit.wrong.values()].join("; ");
    showProblem("edit", { problem: { title: "Correct the marked values", status: 422, detail } });
    return null;
  }
  const child = await storeChild("edit", edit.of, {
    text: draft.text,
    name: "The edited material",
  });
  if (child) kept.delete(edit.of.id);
  return child;
}

/**
 * Stores a genome as a child of an individual of the open lineage, and shows it unless the user has
 * navigated elsewhere meanwhile.
 * @param {Place} place of problems
 * @param {Individual} parent
 * @param {{text: string, name: string, startedAt?: number}} what `text`: genome as text or JSON;
 *   `name`: of the material in the announcement; `startedAt`: number of navigations before
 * @returns {Promise<Individual|null>} null if nothing was stored
 */
export async function storeChild(place, parent, { text, name, startedAt = navigationCount() }) {
  const of = lineageStore.lineage.value;
  if (!of) return null;
  /** @type {Individual|null} */
  let child = null;
  await guarded(place, () =>
    makeGeneration(async () => {
      startClock();
      await sceneSettled();
      const sceneId = lineageStore.lineage.value?.scene ?? of.scene;
      const { hash } = await api.createGenome(new Blob([text]));
      const made = await api.adopt(of.id, { genomes: [hash], parent: parent.id });
      if (lineageStore.lineage.value?.id !== of.id) return;
      storeBred(made, sceneId);
      child = made.individuals[0];
      if (startedAt === navigationCount()) await show(made.id, "visit");
      pageStore.announcement.value =
        `${name} is stored as a child. Choose the centre to breed from it.`;
    }),
  );
  return child;
}

/** Stores a toon shape of the centre as its child: effects that paint what its BRDF reflects. */
export async function makeToonShape() {
  const of = lineageStore.centre.value;
  if (!of) return null;
  /** @type {Individual|null} */
  let child = null;
  await guarded("centre", async () => {
    const text = toonShape(await api.getGenomeText(of.hash));
    child = await storeChild("centre", of, { text, name: "The toon shape" });
  });
  return child;
}
