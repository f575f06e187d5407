/**
 * Genomes by hash: number of instructions, machine, models with parameters. Read from the server
 * where their models are shown or crossed; the names of an individual's models come with the
 * individual itself.
 *
 * @import { Genome, Individual } from "../model.js"
 */
import { effect } from "../vendor/signals-core.js";
import { getGenomeText } from "../api/routes.js";
import { genomeIn } from "./layers.js";
import { lineageStore } from "./store.js";

/** Number of genomes kept; the oldest are dropped. */
const KEPT = 100;

/** Hashes with a pending or failed request, which is not repeated. @type {Set<string>} */
const asked = new Set();

/** @param {Individual} of @returns {Promise<Genome>} */
export async function genomeOf(of) {
  const known = lineageStore.genomes.peek().get(of.hash) ?? genomeIn(await getGenomeText(of.hash));
  if (!lineageStore.genomes.peek().has(of.hash))
    lineageStore.genomes.value = new Map(
      [...lineageStore.genomes.peek(), /** @type {const} */ ([of.hash, known])].slice(-KEPT),
    );
  return known;
}

/** Reads a genome unless it is stored, requested or has failed before. @param {Individual} of */
async function learn(of) {
  if (lineageStore.genomes.peek().has(of.hash) || asked.has(of.hash)) return;
  asked.add(of.hash);
  try {
    await genomeOf(of);
    asked.delete(of.hash);
  } catch {
    // The parameters are then not shown.
  }
}

/** Reads the genome of the centre, unless it is a program without locked instructions. */
export function watchGenomes() {
  return effect(() => {
    const isLocked = lineageStore.locks.value.instructions.length > 0;
    if (lineageStore.centre.value && (isLocked || !lineageStore.programsOnly.value))
      void learn(lineageStore.centre.value);
  });
}
