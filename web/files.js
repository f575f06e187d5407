/**
 * Files dropped anywhere on the window: objects, genomes, what was measured and pictures. Owns the drag events of the window; what a
 * file leads to is done elsewhere.
 */
import { takeMaterial } from "./presets.js";
import { changeView, takeScene, takeTargets } from "./search_target.js";
import { isScene } from "./search_views.js";
import { kindOf } from "./search_words.js";
import { NEW, looking, openSearches } from "./searches.js";
import { uploadObj } from "./scene.js";
import { fileOver, tell } from "./state.js";

const TAKEN = ".obj (an object), .brood (a material), .json (a saved lineage or material), .binary, .bsdf, .brdf, .csv (measured), .exr, .hdr, .png, .jpg (pictures)";

/** @param {DragEvent} event */
const carriesFile = (event) => event.dataTransfer?.types.includes("Files") ?? false;

/** @param {FileList|null|undefined} files */
export async function takeFiles(files) {
  if (!files || files.length === 0) return;
  // While a search is asked for, whatever is dropped is meant as its target.
  const all = [...files];
  const isTarget = all.some(({ name }) => kindOf(name)) && all.every(({ name }) => kindOf(name) || isScene(name));
  if (looking.value === NEW || isTarget) {
    openSearches(NEW);
    return takeTargets(all);
  }
  // What a file leads to is seen below whatever lies over it.
  for (const dialog of document.querySelectorAll("dialog")) if (dialog.open) dialog.close();
  if (files.length > 1) return tell("stage", { problem: { title: "One file at a time", status: 0, detail: `${files.length} files were dropped; drop one.` } });
  const [file] = files;
  if (/\.(brood|json)$/i.test(file.name)) return takeMaterial(file);
  if (/\.obj$/i.test(file.name)) return uploadObj(file);
  tell("stage", { problem: { title: "Unknown kind of file", status: 0, detail: `${file.name} is none of these: ${TAKEN}.` } });
}

/** A field of a picture that takes a file of its own; answers whether there is one below. @param {EventTarget|null} target @param {FileList|undefined} files */
function takeInto(target, files) {
  const field = target instanceof Element ? /** @type {HTMLElement|null} */ (target.closest("[data-takes]")) : null;
  if (!field || files?.length !== 1) return false;
  const key = Number(field.dataset.key);
  if (field.dataset.takes === "mask") changeView(key, { mask: files[0] });
  else void takeScene(files[0], key);
  return true;
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
    if (!takeInto(event.target, event.dataTransfer?.files)) void takeFiles(event.dataTransfer?.files);
  });
}
