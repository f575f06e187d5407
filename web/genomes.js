/**
 * What individuals are made of, by the hash of their genome: how many instructions, which models. The server tells it only with
 * the genome, which is asked for where there may be models. Owns what is known and who is asked for; knows nothing of drawing.
 *
 * @import { Genome, Individual, Layer } from "./types.js"
 */
import { computed, effect, signal } from "./vendor/signals-core.js";
import { getGenomeText } from "./api.js";
import { pinned } from "./compare.js";
import { genomeIn } from "./layers.js";
import { ready } from "./pictures.js";
import { FRAMES, generation, inOrder, large, lineage } from "./state.js";

/** Browsers open six connections to a server, and pictures come first. */
const FETCHES = 3;
/** The oldest go. */
const KEPT = 4000;
/** Where more than these were brought in, each individual is asked for itself. */
const ADOPTED = 40;

/** @type {import("./vendor/signals-core.js").Signal<Map<string, Genome>>} */
export const genomes = signal(new Map());

/** Asked for and not answered, or in vain: not asked for again. @type {Set<string>} */
const asked = new Set();

/** Asks for what is not known yet; what cannot be had stays unknown. @param {Individual[]} individuals */
async function learn(individuals) {
  const left = [...new Set(individuals.map((one) => one.hash))].filter((hash) => !genomes.peek().has(hash) && !asked.has(hash));
  if (left.length === 0) return;
  for (const hash of left) asked.add(hash);
  /** @type {[string, Genome][]} */
  const found = [];
  const work = async () => {
    for (let hash = left.shift(); hash; hash = left.shift()) {
      try {
        found.push([hash, genomeIn(await getGenomeText(hash))]);
      } catch {
        // Its models are then not told, and it is not drawn live.
      }
    }
  };
  await Promise.all(Array.from({ length: FETCHES }, work));
  // At once, so that the page is drawn once.
  genomes.value = new Map([...genomes.peek(), ...found].slice(-KEPT));
  for (const [hash] of found) asked.delete(hash);
}

/** @param {Individual} of @returns {Promise<Genome>} */
export async function genomeOf(of) {
  const known = genomes.peek().get(of.hash) ?? genomeIn(await getGenomeText(of.hash));
  if (!genomes.peek().has(of.hash)) genomes.value = new Map(genomes.peek()).set(of.hash, known);
  return known;
}

/** Individuals of the open lineage that were brought in. */
const adopted = computed(() => inOrder.value.flatMap((born) => (born.individuals[0]?.operator === "adopt" ? born.individuals : [])));

/** Whether nothing in the open lineage has models: it began with programs, and only programs were brought in. */
export const programsOnly = computed(() => (lineage.value?.dialect.length ?? 0) > 0 && adopted.value.every((one) => genomes.value.get(one.hash)?.layers.length === 0));

/** The models of an individual; null while nobody knows. @param {Individual} of @returns {Layer[]|null} */
export function layersOf(of) {
  const known = genomes.value.get(of.hash);
  if (known) return known.layers;
  // B may be of another lineage.
  return programsOnly.value && pinned.value?.id !== of.id ? [] : null;
}

/** Whether it certainly has models. @param {Individual|null} of */
export const isLayered = (of) => of !== null && (layersOf(of)?.length ?? 0) > 0;

/** Learns what the shown individuals are made of, once their pictures are there. */
export function watchGenomes() {
  return effect(() => {
    const of = generation.value;
    if (!of || ready.value !== of.id) return;
    const known = (/** @type {Individual} */ one) => genomes.value.has(one.hash) || asked.has(one.hash);
    const strangers = programsOnly.value || adopted.value.length > ADOPTED ? [] : adopted.value.filter((one) => !known(one));
    const shown = [large.value, ...of.individuals.filter((one) => one.slot < FRAMES)].filter((one) => one !== null);
    const wanted = strangers.length > 0 ? strangers : programsOnly.value ? [] : shown;
    void learn(pinned.value ? [pinned.value, ...wanted] : wanted);
  });
}
