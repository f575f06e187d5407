/**
 * Files dropped anywhere on the window: objects and genomes. Owns the drag events of the window; what a file leads to is done elsewhere.
 */
import { takeMaterial } from "./presets.js";
import { uploadObj } from "./scene.js";
import { fileOver, knobsOpen, tell } from "./state.js";

/** @param {DragEvent} event */
const carriesFile = (event) => event.dataTransfer?.types.includes("Files") ?? false;

/** @param {FileList|null|undefined} files */
export async function takeFiles(files) {
  if (!files || files.length === 0) return;
  if (files.length > 1) {
    knobsOpen.value = true;
    tell("object", { problem: { title: "One file at a time", status: 0, detail: `${files.length} files were dropped; drop one.` } });
    return;
  }
  const [file] = files;
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
