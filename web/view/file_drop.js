/** Files dropped on the window: objects, genomes, measurements, pictures, scenes. */
import { isPicture, usePainting } from "../lineage/painting.js";
import { openImage } from "../lineage/place_image.js";
import { importMaterial } from "../lineage/presets.js";
import { lineageStore } from "../lineage/store.js";
import { showProblem } from "../page/problem.js";
import { pageStore } from "../page/store.js";
import { uploadObj } from "../scene/edit.js";
import { openBackdrop, openNormalMap } from "../scene/images.js";
import { openSearches } from "../search/searches.js";
import { NEW, searchStore } from "../search/store.js";
import { addTargetFiles, changeView, useSceneFile } from "../search/target.js";
import { isScene } from "../search/views.js";
import { kindOf } from "../search/words.js";

const ACCEPTED =
  ".obj (an object), .brood (a material), .json (a saved lineage or material), .binary, .bsdf, .brdf, .csv (measured), .exr, .hdr, .png, .jpg (pictures)";

/** @param {DragEvent} event */
const carriesFile = (event) => event.dataTransfer?.types.includes("Files") ?? false;

/** @param {FileList|null|undefined} files */
export async function openFiles(files) {
  if (!files || files.length === 0) return;
  // While the form of a new search is open, every file is meant as its target.
  const all = [...files];
  const isSearching = searchStore.openView.value === NEW;
  // Painted materials cannot be searched for, so a picture is a painting for them.
  if (!isSearching && lineageStore.painted.value && all.length === 1 && isPicture(all[0]))
    return usePainting(all[0]);
  const isTarget =
    all.some(({ name }) => kindOf(name)) && all.every(({ name }) => kindOf(name) || isScene(name));
  if (isSearching || isTarget) {
    openSearches(NEW);
    return addTargetFiles(all);
  }
  // Dialogs are closed, because the result appears below them.
  for (const dialog of document.querySelectorAll("dialog")) if (dialog.open) dialog.close();
  if (files.length > 1)
    return showProblem("stage", {
      problem: {
        title: "One file at a time",
        status: 0,
        detail: `${files.length} files were dropped; drop one.`,
      },
    });
  const [file] = files;
  if (/\.(brood|json)$/i.test(file.name)) return importMaterial(file);
  if (/\.obj$/i.test(file.name)) return uploadObj(file);
  showProblem("stage", {
    problem: {
      title: "Unknown kind of file",
      status: 0,
      detail: `${file.name} must be one of: ${ACCEPTED}.`,
    },
  });
}

/**
 * Gives a file to the field below the pointer: of a picture, a painting, an image, the backdrop or
 * a normal map. Returns false if there is none.
 * @param {EventTarget|null} target
 * @param {FileList|undefined} files
 */
function openInField(target, files) {
  const field =
    target instanceof Element
      ? /** @type {HTMLElement|null} */ (target.closest("[data-takes]"))
      : null;
  if (!field || files?.length !== 1) return false;
  if (field.dataset.takes === "painting") {
    void usePainting(files[0]);
    return true;
  }
  if (field.dataset.takes === "image") {
    void openImage(files[0]);
    return true;
  }
  if (field.dataset.takes === "backdrop") {
    void openBackdrop(files[0]);
    return true;
  }
  if (field.dataset.takes === "normal-map") {
    const part = /** @type {import("../scene/normal_map.js").Part} */ (field.dataset.part);
    void openNormalMap(part, files[0]);
    return true;
  }
  const key = Number(field.dataset.key);
  if (field.dataset.takes === "mask") changeView(key, { mask: files[0] });
  else void useSceneFile(files[0], key);
  return true;
}

export function listenToFiles() {
  addEventListener("dragover", (event) => {
    if (!carriesFile(event)) return;
    event.preventDefault();
    pageStore.fileDragged.value = true;
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) pageStore.fileDragged.value = false;
  });
  addEventListener("drop", (event) => {
    if (!carriesFile(event)) return;
    event.preventDefault();
    pageStore.fileDragged.value = false;
    if (!openInField(event.target, event.dataTransfer?.files))
      void openFiles(event.dataTransfer?.files);
  });
}
