/**
 * What the open genomes hold, by hash: how many instructions, of which machine, which models with which parameters. The server
 * tells it with a genome alone, which is asked for where its models are shown or crossed. Owns what is known and who is asked
 * for; knows nothing of drawing. Which models an individual has, it says itself (layers.js).
 *
 * @import { Genome, Individual } from "./types.js"
 */
import { computed, effect, signal } from "./vendor/signals-core.js";
import { getGenomeText } from "./api.js";
import { genomeIn, isLayered } from "./layers.js";
import { inOrder, large, lineage } from "./state.js";

/** The oldest go. */
const KEPT = 400;

/** @type {import("./vendor/signals-core.js").Signal<Map<string, Genome>>} */
export const genomes = signal(new Map());

/** Asked for and not answered, or in vain: not asked for again. @type {Set<string>} */
const asked = new Set();

/** @param {Individual} of @returns {Promise<Genome>} */
export async function genomeOf(of) {
  const known = genomes.peek().get(of.hash) ?? genomeIn(await getGenomeText(of.hash));
  if (!genomes.peek().has(of.hash)) genomes.value = new Map([...genomes.peek(), /** @type {const} */ ([of.hash, known])].slice(-KEPT));
  return known;
}

/** Asks for what is not known yet; what cannot be had stays unknown. @param {Individual} of */
async function learn(of) {
  if (genomes.peek().has(of.hash) || asked.has(of.hash)) return;
  asked.add(of.hash);
  try {
    await genomeOf(of);
    asked.delete(of.hash);
  } catch {
    // Its parameters are then not shown.
  }
}

/** Whether nothing in the open lineage has models: it began with programs, and only programs were brought in. */
export const programsOnly = computed(() => (lineage.value?.dialect.length ?? 0) > 0 && !inOrder.value.some((born) => born.individuals[0]?.operator === "adopt" && born.individuals.some(isLayered)));

/** Learns what the centre holds. */
export function watchGenomes() {
  return effect(() => {
    if (large.value && !programsOnly.value) void learn(large.value);
  });
}
