/**
 * A/B comparison of the centre (A) with a pinned individual (B), which takes the centre's place on
 * demand.
 *
 * @import { Cell, Individual } from "../model.js"
 */
import { effect } from "../vendor/signals-core.js";
import { ProblemError, problemOf } from "../api/request.js";
import * as api from "../api/routes.js";
import { individualIn } from "../lineage/individuals.js";
import { centreOf, lineageStore } from "../lineage/store.js";
import { loadSetting, saveSetting } from "../page/memory.js";
import { clearProblems, guarded, showProblem } from "../page/problem.js";
import * as route from "../page/route.js";
import { pageStore } from "../page/store.js";
import { makeFlipKey } from "./flip_key.js";
import { compareStore } from "./store.js";

const ID = /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/i;
/** Width of the window below which the details would cover the comparison. */
const ROOM_PX = 900;

/** The individual visible in a frame; null where the target is visible. @param {Cell} cell */
export function individualSeenIn(cell) {
  if (cell === "centre" && compareStore.targetInCentre.value) return null;
  return cell === "centre" && compareStore.flipped.value && compareStore.pinned.value
    ? compareStore.pinned.value
    : individualIn(cell);
}

/** @param {Individual} of @param {string} name */
export function pin(of, name) {
  clearProblems("compare");
  compareStore.pinned.value = of;
  compareStore.flipped.value = false;
  compareStore.choosingOther.value = false;
  if (globalThis.innerWidth > ROOM_PX) pageStore.detailsOpen.value = true;
  pageStore.announcement.value = `${name} is B. X shows it in place of the centre, Escape unpins it.`;
}

/** @param {Cell} cell @param {string} name */
export function pinCell(cell, name) {
  const of = individualIn(cell);
  if (of && of.id === compareStore.pinned.value?.id) unpin();
  else if (of) pin(of, name);
}

export function unpin() {
  if (!compareStore.pinned.value) return;
  clearProblems("compare");
  compareStore.pinned.value = null;
  compareStore.flipped.value = false;
  pageStore.announcement.value = "Nothing is pinned as B.";
}

/** @param {boolean} toB */
export function flip(toB) {
  if (!compareStore.pinned.value) return;
  compareStore.targetInCentre.value = false;
  compareStore.flipped.value = toB;
  pageStore.announcement.value = `The centre shows ${toB ? "B" : "A"}.`;
}

/** Key X, and the button that does the same. */
export const flipKeyB = makeFlipKey(() => flip(!compareStore.flipped.value));

/**
 * Finds what a pasted text names.
 * @param {string} text an id, or an address of this page or of the API
 * @param {string} origin of this page
 * @returns {{individual: string}|{generation: string}|{lineage: string}|{wrong: string}}
 */
export function parsePasted(text, origin) {
  const pasted = text.trim();
  if (ID.test(pasted)) return { individual: pasted.toLowerCase() };
  /** @type {URL} */
  let address;
  try {
    address = new URL(pasted, origin);
  } catch {
    return { wrong: "This is neither an individual's id nor a share link." };
  }
  if (address.origin !== origin)
    return {
      wrong: `The link leads to ${address.host || "another place"}; only individuals of this server can be compared.`,
    };
  const single = /\/v1\/individuals\/([^/]+)/.exec(address.pathname)?.[1];
  if (single && ID.test(single)) return { individual: single.toLowerCase() };
  const { lineage, generation } = route.parse(address.hash);
  if (generation && ID.test(generation)) return { generation };
  if (lineage && ID.test(lineage)) return { lineage };
  return { wrong: "This is neither an individual's id nor a share link." };
}

/** @param {string} text @returns {Promise<Individual|null>} */
async function fetchPasted(text) {
  const named = parsePasted(text, location.origin);
  if ("wrong" in named)
    throw new ProblemError({ title: "Nothing to compare with", status: 400, detail: named.wrong });
  if ("individual" in named) return api.getIndividual(named.individual);
  if ("generation" in named) return centreOf(await api.getGeneration(named.generation));
  const newest = await api.getNewestGeneration(await api.getLineage(named.lineage));
  return newest ? centreOf(newest) : null;
}

/**
 * Pins the individual that a pasted id or link names.
 * @param {string} text
 * @returns {Promise<boolean>} true on success
 */
export async function pinPasted(text) {
  if (!text.trim()) return false;
  let done = false;
  await guarded("compare", async () => {
    try {
      const found = await fetchPasted(text);
      if (!found)
        throw new ProblemError({
          title: "Nothing to compare with",
          status: 404,
          detail: "The lineage of that link has no individuals yet.",
        });
      pin(found, "The individual");
      done = true;
    } catch (error) {
      const problem = problemOf(error);
      if (problem.status !== 404) throw error;
      showProblem("compare", {
        problem: {
          ...problem,
          title: "Not on this server",
          detail:
            "This server has nothing with that id; it may be of another server or of a hidden lineage.",
        },
      });
    }
  });
  return done;
}

/** Keeps B as long as the window is open; a new centre is first shown as it is. */
export function watchCompare() {
  compareStore.pinned.value = loadSetting(
    "pinned",
    /** @type {Individual|null} */ (null),
    "sessionStorage",
  );
  effect(() => saveSetting("pinned", compareStore.pinned.value, "sessionStorage"));
  effect(() => {
    void [lineageStore.shownId.value, lineageStore.centre.value?.id];
    compareStore.flipped.value = false;
    compareStore.targetInCentre.value = false;
  });
}
