/**
 * OBJ files dropped anywhere on the window. Owns the drag events of the window; what a file leads to is done elsewhere.
 */
import { uploadObj } from "./scene.js";
import { fileOver, knobsOpen, tell } from "./state.js";

/** @param {DragEvent} event */
const carriesFile = (event) => event.dataTransfer?.types.includes("Files") ?? false;

/** @param {FileList|null|undefined} files */
export async function takeFiles(files) {
  if (!files || files.length === 0) return;
  if (files.length > 1) {
    knobsOpen.value = true;
    tell("object", { problem: { title: "One file at a time", status: 0, detail: `${files.length} files were dropped; drop one OBJ.` } });
    return;
  }
  await uploadObj(files[0]);
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
