/**
 * A and B: the centre and any other individual, looked at one in the place of the other. Owns what is pinned as B, what the
 * centre shows, and the reading of what a person pastes; knows nothing of drawing.
 *
 * @import { Cell, Individual } from "./types.js"
 */
import { effect, signal } from "./vendor/signals-core.js";
import * as api from "./api.js";
import { flipKey } from "./flip_key.js";
import { guarded } from "./lineage.js";
import { keep, recall } from "./memory.js";
import * as route from "./route.js";
import { announcement, detailsOpen, forget, individualIn, large, largeOf, shown, tell } from "./state.js";

/** @template T @typedef {import("./vendor/signals-core.js").Signal<T>} Signal */

/** B. It stays while generations and lineages change. @type {Signal<Individual|null>} */
export const pinned = signal(null);
/** Whether the centre shows B in the place of A. @type {Signal<boolean>} */
export const flipped = signal(false);
/** Whether the centre shows the target of a search in the place of A; which one is sought.js's. @type {Signal<boolean>} */
export const targetSeen = signal(false);
/** Whether a person is asked what to compare with. @type {Signal<boolean>} */
export const choosing = signal(false);

const ID = /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/i;
/** Below this the details would cover what is compared. */
const ROOM_PX = 900;

/** The individual to be seen in a frame; none where the target is seen. @param {Cell} cell */
export function seenIn(cell) {
  if (cell === "centre" && targetSeen.value) return null;
  return cell === "centre" && flipped.value && pinned.value ? pinned.value : individualIn(cell);
}

/** @param {Individual} of @param {string} name */
export function pin(of, name) {
  forget("compare");
  pinned.value = of;
  flipped.value = false;
  choosing.value = false;
  if (globalThis.innerWidth > ROOM_PX) detailsOpen.value = true;
  announcement.value = `${name} is B. X shows it in the place of the centre, Escape unpins it.`;
}

/** @param {Cell} cell @param {string} name */
export function pinCell(cell, name) {
  const of = individualIn(cell);
  if (of && of.id === pinned.value?.id) unpin();
  else if (of) pin(of, name);
}

export function unpin() {
  if (!pinned.value) return;
  forget("compare");
  pinned.value = null;
  flipped.value = false;
  announcement.value = "Nothing is pinned as B.";
}

/** @param {boolean} toB */
export function flip(toB) {
  if (!pinned.value) return;
  targetSeen.value = false;
  flipped.value = toB;
  announcement.value = `The centre shows ${toB ? "B" : "A"}.`;
}

/** X, and what does the same. */
export const keyOfB = flipKey(() => flip(!flipped.value));

/**
 * What a pasted text names.
 * @param {string} text an id, or an address of this page or of the interface
 * @param {string} origin of this page
 * @returns {{individual: string}|{generation: string}|{lineage: string}|{wrong: string}}
 */
export function namedIn(text, origin) {
  const pasted = text.trim();
  if (ID.test(pasted)) return { individual: pasted.toLowerCase() };
  /** @type {URL} */
  let address;
  try {
    address = new URL(pasted, origin);
  } catch {
    return { wrong: "That is neither an individual's id nor a link that Share gave." };
  }
  if (address.origin !== origin) return { wrong: `The link leads to ${address.host || "another place"}; only individuals of this server can be compared.` };
  const single = /\/v1\/individuals\/([^/]+)/.exec(address.pathname)?.[1];
  if (single && ID.test(single)) return { individual: single.toLowerCase() };
  const { lineage, generation } = route.parse(address.hash);
  if (generation && ID.test(generation)) return { generation };
  if (lineage && ID.test(lineage)) return { lineage };
  return { wrong: "That is neither an individual's id nor a link that Share gave." };
}

/** @param {string} text @returns {Promise<Individual|null>} */
async function find(text) {
  const named = namedIn(text, location.origin);
  if ("wrong" in named) throw new api.ProblemError({ title: "Nothing to compare with", status: 400, detail: named.wrong });
  if ("individual" in named) return api.getIndividual(named.individual);
  if ("generation" in named) return largeOf(await api.getGeneration(named.generation));
  const newest = (await api.listGenerations(named.lineage)).at(-1);
  return newest ? largeOf(newest) : null;
}

/** Pins what a pasted id or link names; answers whether it did. @param {string} text */
export async function pinPasted(text) {
  if (!text.trim()) return false;
  let done = false;
  await guarded("compare", async () => {
    try {
      const found = await find(text);
      if (!found) throw new api.ProblemError({ title: "Nothing to compare with", status: 404, detail: "The lineage of that link has no individuals yet." });
      pin(found, "The individual");
      done = true;
    } catch (error) {
      const problem = api.problemOf(error);
      if (problem.status !== 404) throw error;
      tell("compare", { problem: { ...problem, title: "Not on this server", detail: "Nothing on this server has that id; it may be of another one, or of one that was hidden." } });
    }
  });
  return done;
}

/** B stays for as long as the window does; another generation is first seen as it is. */
export function watchCompare() {
  pinned.value = recall("pinned", /** @type {Individual|null} */ (null), "sessionStorage");
  effect(() => keep("pinned", pinned.value, "sessionStorage"));
  effect(() => {
    void [shown.value, large.value?.id];
    flipped.value = false;
    targetSeen.value = false;
  });
}
