/**
 * What the server finds when it looks into a genome, by the genome's hash: asked for once, kept while the page is open. Owns
 * what is known and its bound; knows nothing of who asks.
 *
 * @import { Individual, Inspection } from "./types.js"
 */
import { signal } from "./vendor/signals-core.js";
import { getInspection } from "./api.js";

/** Each takes some 50 kB; the oldest go. */
const KEPT = 100;

/** @type {import("./vendor/signals-core.js").Signal<Map<string, Inspection>>} */
export const inspections = signal(new Map());

/** Asked for and not yet answered. @type {Map<string, Promise<Inspection>>} */
const asked = new Map();

/** @param {Individual} of */
async function ask(of) {
  try {
    const found = await getInspection(of.id);
    inspections.value = new Map([...inspections.peek(), /** @type {const} */ ([of.hash, found])].slice(-KEPT));
    return found;
  } finally {
    asked.delete(of.hash);
  }
}

/** @param {Individual} of @returns {Promise<Inspection>} */
export async function inspect(of) {
  const known = inspections.peek().get(of.hash);
  if (known) return known;
  const answer = asked.get(of.hash) ?? ask(of);
  asked.set(of.hash, answer);
  return answer;
}
