/**
 * Materials that come from outside a lineage: presets and `.brood` files. Owns the road from one of them to a brood around it;
 * knows nothing of dialogs and drops.
 *
 * @import { Dialect, Generation, Genome, Lineage, Preset } from "./types.js"
 */
import { signal } from "./vendor/signals-core.js";
import * as api from "./api.js";
import { breedNext } from "./breed.js";
import { create, guarded, open, putBred, show } from "./lineage.js";
import { unlockAll } from "./locks.js";
import { announcement, large, lineage, lineages, presetsOpen, tell } from "./state.js";

/** More than any genome of 1024 instructions takes; the server's limit. */
const TEXT_BYTES = 1024 * 1024;

/** @type {import("./vendor/signals-core.js").Signal<Preset[]>} */
export const presets = signal([]);

export async function listPresets() {
  if (presets.value.length === 0) presets.value = await api.listPresets();
}

/** Shows what was brought in, with a brood around it. @param {Generation} made @param {string} sceneId of its pictures */
async function breedFrom(made, sceneId) {
  putBred(made, sceneId);
  await show(made.id, "visit");
  await breedNext(made.lineage, [made.individuals[0].id]);
}

/** The first brood of a lineage that was just opened. @param {string} id @param {{genomes?: string[], presets?: string[]}} what */
async function beginWith(id, what) {
  const sceneId = lineage.value?.scene ?? "";
  await breedFrom(await api.adopt(id, what), sceneId);
}

/** A lineage of its own for a preset: it needs the preset's dialect, and its colours as they are. @param {Preset} preset */
export async function startFrom(preset) {
  await create(preset.title, {
    dialect: preset.dialect,
    saturation: 1,
    begin: (id) => beginWith(id, { presets: [preset.name] }),
  });
  presetsOpen.value = false;
  announcement.value = `${preset.title}: a new lineage begins with it.`;
}

/** Crosses what is in the centre with a preset, in the open lineage. @param {Preset} preset */
export async function crossWith(preset) {
  const of = lineage.value;
  const centre = large.value;
  if (!of || !centre) return;
  const made = await api.adopt(of.id, { presets: [preset.name] });
  putBred(made, of.scene);
  presetsOpen.value = false;
  await breedNext(of.id, [centre.id, made.individuals[0].id]);
}

/** What two programs must share to be crossed. @type {("opcodes"|"parametrisation"|"registers")[]} */
const MACHINE = ["opcodes", "parametrisation", "registers"];

/**
 * Whether a lineage takes a material, and what is in its centre can be crossed with it: models go with everything, programs with
 * those of their own machine.
 * @param {Lineage} of @param {Genome|null} centre null while nobody knows @param {Dialect} dialect
 */
export function fits({ dialect: own }, centre, dialect) {
  if (dialect.length === 0) return true;
  if (own.length > 0) return dialect.length <= own.length && MACHINE.every((part) => own[part] === dialect[part]);
  return !centre || centre.instructions === 0 || centre.machine.startsWith(`${dialect.opcodes} ${dialect.parametrisation} registers ${dialect.registers}`);
}

/** The server's limit, said before it is sent in vain. */
const LINEAGE_BYTES = 256 * 1024 * 1024;

/** Whether a JSON file is a lineage and not a genome: it says so in a field, the first of them where a server wrote it. @param {File} file */
async function isLineage(file) {
  const beginning = await file.slice(0, 200).text();
  if (!/^\s*\{/.test(beginning) || file.size > LINEAGE_BYTES) return beginning.includes('"brood_lineage"');
  return /"brood_lineage"\s*:/.test(await file.text());
}

/** A `.brood` or `.json` file. @param {File} read */
export async function takeMaterial(read) {
  // Editors put a mark of their own before the text, which is not part of JSON.
  const marked = new Uint8Array(await read.slice(0, 3).arrayBuffer()).join() === "239,187,191";
  const file = marked ? new File([read.slice(3)], read.name) : read;
  if (await isLineage(file)) await takeLineage(file);
  else await takeGenome(file);
}

/** Opens a lineage that was saved, with all its history. @param {File} file */
async function takeLineage(file) {
  if (file.size > LINEAGE_BYTES) {
    tell("stage", { problem: { title: "The file is too large", status: 413, detail: `${file.name} has ${Math.round(file.size / 2 ** 20)} MiB; a lineage may have 256.` } });
    return;
  }
  await guarded("stage", async () => {
    const made = await api.importLineage(file);
    lineages.value = [...lineages.value, made];
    await open(made.id, null);
    announcement.value = `${made.name}: ${made.generations} generations were read from ${file.name}.`;
  });
}

/** Brings a genome into the open lineage, or into one of its own where it is of another dialect. @param {File} file */
async function takeGenome(file) {
  if (file.size > TEXT_BYTES) {
    tell("stage", { problem: { title: "The file is too large", status: 413, detail: `${file.name} has ${(file.size / 2 ** 20).toFixed(1)} MiB; a genome has less than one.` } });
    return;
  }
  await guarded("stage", async () => {
    const { hash } = await api.createGenome(file);
    const of = lineage.value;
    /** @type {Generation|null} */
    let made = null;
    try {
      made = of && (await api.adopt(of.id, { genomes: [hash] }));
    } catch (error) {
      if (api.problemOf(error).status !== 422) throw error;
    }
    if (of && made) {
      // Locks name positions, and here other things stand there.
      unlockAll();
      return breedFrom(made, of.scene);
    }
    const { dialect } = await api.getGenome(hash);
    const length = dialect.length && Math.max(100, dialect.length);
    await create(file.name.replace(/\.[^.]*$/, ""), {
      dialect: { ...dialect, length },
      saturation: 1,
      begin: (id) => beginWith(id, { genomes: [hash] }),
    });
    announcement.value = `${file.name}: a new lineage begins with it, because it is of another dialect.`;
  });
}
