/**
 * The list of lineages: search, hidden lineages, and changes of names, tags, notes and covers.
 *
 * @import { Lineage } from "../model.js"
 */
import { effect } from "../vendor/signals-core.js";
import * as api from "../api/routes.js";
import { guarded } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { replaceListed } from "./open.js";
import { lineageStore } from "./store.js";

/** Pause in typing after which the server searches. */
const PAUSE_MS = 200;

/** Number of requests so far: an answer is dropped if another request was sent since. */
let requests = 0;

/** Reads the list of visible lineages, or those that the filter selects. */
export const readLineages = () =>
  guarded("lineages", async () => {
    const filter = lineageStore.listFilter.value;
    requests += 1;
    const mine = requests;
    const read = await api.listLineages(filter);
    if (mine !== requests) return;
    if (filter.search === "" && !filter.hidden) lineageStore.lineages.value = read;
    lineageStore.found.value = read;
  }, true);

/**
 * Lineages to show, newest first. A filtered list shows what was read; the whole list also what was
 * created since.
 */
export function listedLineages() {
  const { search, hidden } = lineageStore.listFilter.value;
  const of = search === "" && !hidden ? lineageStore.lineages.value : lineageStore.found.value;
  const kept = of.filter((one) => one.hidden === hidden);
  return kept.sort((a, b) => b.created_ms - a.created_ms);
}

/** Reads the list when it is opened and when its filter changes. */
export function watchListed() {
  let isOpen = false;
  effect(() => {
    if (!pageStore.lineagesOpen.value) {
      isOpen = false;
      return;
    }
    void lineageStore.listFilter.value;
    // At once when it is opened, after a pause while the user types.
    const timer = setTimeout(() => void readLineages(), isOpen ? PAUSE_MS : 0);
    isOpen = true;
    return () => clearTimeout(timer);
  });
}

/**
 * Tags from a text in which commas separate them; each once.
 * @param {string} text
 */
export function tagsIn(text) {
  /** @type {string[]} */
  const tags = [];
  for (const part of text.split(",")) {
    const tag = part.trim().replaceAll(/\s+/g, " ");
    const isKnown = tags.some((one) => one.toLowerCase() === tag.toLowerCase());
    if (tag && !isKnown) tags.push(tag);
  }
  return tags;
}

/** @param {Lineage} changed */
function store(changed) {
  replaceListed(changed);
  lineageStore.found.value = lineageStore.found.value.map((one) =>
    one.id === changed.id ? { ...one, ...changed } : one,
  );
}

/**
 * Saves what was changed of name, tags and notes.
 * @param {Lineage} of
 * @param {{name: string, tags: string[], notes: string}} words
 */
export async function describe(of, { name, tags, notes }) {
  const change = {
    ...(name && name !== of.name ? { name } : {}),
    ...(tags.join() === of.tags.join() ? {} : { tags }),
    ...(notes === of.notes ? {} : { notes }),
  };
  if (Object.keys(change).length > 0) store(await api.patchLineage(of, change));
}

/** Shows a hidden lineage in lists again. @param {Lineage} of */
export async function restore(of) {
  const restored = await api.patchLineage(of, { hidden: false });
  lineageStore.found.value = lineageStore.found.value.filter(({ id }) => id !== of.id);
  lineageStore.lineages.value = [...lineageStore.lineages.value, { ...of, ...restored }];
  pageStore.announcement.value = `${of.name} is restored.`;
}

/**
 * Makes an individual of the open lineage its cover, or removes the choice.
 * @param {string} id
 */
export const toggleOwnCover = (id) =>
  guarded("centre", async () => {
    const of = lineageStore.lineage.value;
    if (!of) return;
    const isCover = of.cover_individual === id;
    store(await api.patchLineage(of, { cover_individual: isCover ? null : id }));
    pageStore.announcement.value = `The centre is ${isCover ? "no longer" : "now"} the cover of ${of.name}.`;
  });
