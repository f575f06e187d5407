/**
 * Import of materials: presets, `.brood` files, and saved lineages.
 *
 * @import { Dialect, Generation, Genome, Lineage, Preset } from "../model.js"
 */
import { problemOf } from "../api/request.js";
import * as api from "../api/routes.js";
import { guarded, showProblem } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { breedNext } from "./breed.js";
import { show, storeBred } from "./generations.js";
import { unlockAll } from "./locks.js";
import { STARTS, create, goesInto, open } from "./open.js";
import { lineageStore } from "./store.js";

/** Largest file of a genome that the server accepts; 1024 instructions take less. */
const TEXT_BYTES = 1024 * 1024;

/** True if a preset is a painted material. @param {Preset} of */
export const isPaint = ({ text }) => /^\.effect /m.test(text);

export async function listPresets() {
  if (lineageStore.presets.value.length === 0) lineageStore.presets.value = await api.listPresets();
}

/**
 * Shows imported genomes with a brood around the first.
 * @param {Generation} made
 * @param {string} sceneId scene of its pictures
 */
async function breedFrom(made, sceneId) {
  storeBred(made, sceneId);
  await show(made.id, "visit");
  await breedNext(made.lineage, [made.individuals[0].id]);
}

/**
 * Makes the first generations of an empty lineage from imported genomes.
 * @param {string} id
 * @param {{genomes?: string[], presets?: string[]}} what
 */
async function beginWith(id, what) {
  const sceneId = lineageStore.lineage.value?.scene ?? "";
  await breedFrom(await api.adopt(id, what), sceneId);
}

/**
 * Opens a new lineage for a preset, with the preset's dialect and its own colours.
 * @param {Preset} preset
 */
export async function startFrom(preset) {
  await create(preset.title, {
    ...(isPaint(preset) ? STARTS.painted : { dialect: preset.dialect, saturation: 1 }),
    begin: (id) => beginWith(id, { presets: [preset.name] }),
  });
  pageStore.presetsOpen.value = false;
  pageStore.announcement.value = `${preset.title}: opened in a new lineage.`;
}

/**
 * Opens a new lineage for a genome, with the genome's dialect.
 * @param {string} hash
 * @param {string} name of the lineage
 * @param {string} [scene] default: the scene of the open lineage
 */
export async function startFromGenome(hash, name, scene) {
  const { dialect, effects } = await api.getGenome(hash);
  const length = dialect.length && Math.max(100, dialect.length);
  await create(name, {
    ...(effects ? STARTS.painted : { dialect: { ...dialect, length }, saturation: 1 }),
    scene,
    begin: (id) => beginWith(id, { genomes: [hash] }),
  });
}

/**
 * Imports a preset into the open lineage, and crosses it with the centre.
 * @param {Preset} preset
 */
export async function crossWith(preset) {
  const of = lineageStore.lineage.value;
  const centre = lineageStore.centre.value;
  if (!of || !centre) return;
  const made = await api.adopt(of.id, { presets: [preset.name] });
  storeBred(made, of.scene);
  pageStore.presetsOpen.value = false;
  await breedNext(of.id, [centre.id, made.individuals[0].id]);
}

/**
 * True if a lineage accepts a material that can be crossed with its centre: models go with
 * everything, programs with programs of the same machine.
 * @param {Lineage} of
 * @param {Genome|null} centre null while unknown
 * @param {Dialect} dialect
 */
export function fits({ dialect: own }, centre, dialect) {
  if (own.length > 0 || dialect.length === 0) return goesInto(own, dialect);
  return (
    !centre ||
    centre.instructions === 0 ||
    centre.machine.startsWith(
      `${dialect.opcodes} ${dialect.parametrisation} registers ${dialect.registers}`,
    )
  );
}

/** Largest file of a lineage that the server accepts. */
const LINEAGE_BYTES = 256 * 1024 * 1024;

/**
 * True if a JSON file is a lineage and not a genome. A lineage has a field that says so, the first
 * field if a server wrote it.
 * @param {File} file
 */
async function isLineage(file) {
  const beginning = await file.slice(0, 200).text();
  if (!/^\s*\{/.test(beginning) || file.size > LINEAGE_BYTES)
    return beginning.includes('"brood_lineage"');
  return /"brood_lineage"\s*:/.test(await file.text());
}

/** Imports a `.brood` or `.json` file. @param {File} read */
export async function importMaterial(read) {
  // Some editors begin files with a byte order mark, which is not valid JSON.
  const marked = new Uint8Array(await read.slice(0, 3).arrayBuffer()).join() === "239,187,191";
  const file = marked ? new File([read.slice(3)], read.name) : read;
  if (await isLineage(file)) await importLineageFile(file);
  else await importGenomeFile(file);
}

/** Opens a saved lineage with its whole history. @param {File} file */
async function importLineageFile(file) {
  if (file.size > LINEAGE_BYTES) {
    showProblem("stage", {
      problem: {
        title: "The file is too large",
        status: 413,
        detail: `A lineage may have 256 MiB; ${file.name} has ${Math.round(file.size / 2 ** 20)} MiB.`,
      },
    });
    return;
  }
  await guarded("stage", async () => {
    const made = await api.importLineage(file);
    lineageStore.lineages.value = [...lineageStore.lineages.value, made];
    await open(made.id, null);
    pageStore.announcement.value = `${made.name}: ${made.generations} generations were read from ${file.name}.`;
  });
}

/**
 * Imports a genome into the open lineage, or into a new one if its dialect differs.
 * @param {File} file
 */
async function importGenomeFile(file) {
  if (file.size > TEXT_BYTES) {
    showProblem("stage", {
      problem: {
        title: "The file is too large",
        status: 413,
        detail: `A genome may have 1 MiB; ${file.name} has ${(file.size / 2 ** 20).toFixed(1)} MiB.`,
      },
    });
    return;
  }
  await guarded("stage", async () => {
    const { hash } = await api.createGenome(file);
    const of = lineageStore.lineage.value;
    /** @type {Generation|null} */
    let made = null;
    try {
      made = of && (await api.adopt(of.id, { genomes: [hash] }));
    } catch (error) {
      if (problemOf(error).status !== 422) throw error;
    }
    if (of && made) {
      // Locks name positions, and this genome has other parts there.
      unlockAll();
      return breedFrom(made, of.scene);
    }
    await startFromGenome(hash, file.name.replace(/\.[^.]*$/, ""));
    pageStore.announcement.value = `${file.name}: opened in a new lineage, because its dialect differs.`;
  });
}
