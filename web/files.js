/**
 * Files dropped anywhere on the window: objects, genomes and what was measured. Owns the drag events of the window; what a file leads to is done elsewhere.
 */
import { takeMaterial } from "./presets.js";
import { takeTarget } from "./search_draft.js";
import { kindOf } from "./search_words.js";
import { NEW, looking, openSearches } from "./searches.js";
import { uploadObj } from "./scene.js";
import { fileOver, knobsOpen, tell } from "./state.js";

/** @param {DragEvent} event */
const carriesFile = (event) => event.dataTransfer?.types.includes("Files") ?? false;

/** @param {FileList|null|undefined} files */
export async function takeFiles(files) {
  if (!files || files.length === 0) return;
  if (files.length > 1) {
    const place = looking.value === NEW ? "target" : "object";
    if (place === "object") knobsOpen.value = true;
    tell(place, { problem: { title: "One file at a time", status: 0, detail: `${files.length} files were dropped; drop one.` } });
    return;
  }
  const [file] = files;
  // While a search is asked for, whatever is dropped is meant as its target.
  if (looking.value === NEW || kindOf(file.name)) {
    openSearches(NEW);
    return takeTarget(file);
  }
  await (/\.(brood|json)$/i.test(file.name) ? takeMaterial(file) : uploadObj(file));
}

export function listenToFiles() {
  addEventListener("dragover", (event) => {
    if (!carriesFile(event)) return;
    event.preventDefault();
    fileOver.value = true;
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) fileOver.value = false;
  });
  addEventListener("drop", (event) => {
    if (!carriesFile(event)) return;
    event.preventDefault();
    fileOver.value = false;
    void takeFiles(event.dataTransfer?.files);
  });
}
