/**
 * Inspections of genomes by the server, by genome hash: requested once, kept while the page is
 * open.
 *
 * @import { Individual, Inspection } from "../model.js"
 */
import { getInspection } from "../api/routes.js";
import { lineageStore } from "./store.js";

/** Number of inspections kept, about 50 kB each; the oldest are dropped. */
const KEPT = 100;

/** Requests without an answer yet. @type {Map<string, Promise<Inspection>>} */
const asked = new Map();

/** @param {Individual} of */
async function ask(of) {
  try {
    const found = await getInspection(of.id);
    lineageStore.inspections.value = new Map(
      [...lineageStore.inspections.peek(), /** @type {const} */ ([of.hash, found])].slice(-KEPT),
    );
    return found;
  } finally {
    asked.delete(of.hash);
  }
}

/** @param {Individual} of @returns {Promise<Inspection>} */
export async function inspect(of) {
  const known = lineageStore.inspections.peek().get(of.hash);
  if (known) return known;
  const answer = asked.get(of.hash) ?? ask(of);
  asked.set(of.hash, answer);
  return answer;
}
