/**
 * Store of comparisons: the individual pinned as B, what the centre shows, and the materials that
 * are measured side by side.
 *
 * @import { Comparison, Individual } from "../model.js"
 * @import { Signal } from "../vendor/signals-core.js"
 * @import { Choice } from "./comparison.js"
 */
import { computed, signal } from "../vendor/signals-core.js";

/** @param {Choice[]} of */
const keysOf = (of) => of.map(({ key }) => key).join();

class CompareStore {
  /** B; kept while generations and lineages change. @type {Signal<Individual|null>} */
  pinned = signal(null);
  /** True while the centre shows B in place of A. @type {Signal<boolean>} */
  flipped = signal(false);
  /** True while the centre shows the target of a search in place of A. @type {Signal<boolean>} */
  targetInCentre = signal(false);
  /** True while the form that names B is open. @type {Signal<boolean>} */
  choosingOther = signal(false);

  /** True while the comparison dialog is open. @type {Signal<boolean>} */
  comparisonOpen = signal(false);
  /** Chosen materials in order; the first is the reference. @type {Signal<Choice[]>} */
  chosen = signal([]);
  /**
   * The server's answer, with the choice that it was asked for.
   * @type {Signal<{of: Choice[], found: Comparison}|null>}
   */
  result = signal(null);
  /** True if the list of possible choices is unfolded. @type {Signal<boolean>} */
  choicesOpen = signal(true);
  /** True while the server compares. @type {Signal<boolean>} */
  comparing = signal(false);

  /** True if the result is of the present choice. @type {Signal<boolean>} */
  resultIsCurrent = computed(
    () => this.result.value !== null && keysOf(this.result.value.of) === keysOf(this.chosen.value),
  );
}

export const compareStore = new CompareStore();
