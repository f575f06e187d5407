/**
 * The server's picture of an edited genome that is not stored, where it cannot be drawn live: the
 * newest values, one request at a time.
 *
 * @import { Draft } from "../model.js"
 */
import { effect } from "../vendor/signals-core.js";
import { problemOf } from "../api/request.js";
import { renderGenome } from "../api/routes.js";
import { lineageStore } from "../lineage/store.js";
import { forNewest } from "../page/newest.js";
import { showProblem } from "../page/problem.js";
import { liveStore } from "./store.js";

/** Side of the picture in pixels, small enough to follow a slider. */
const SIDE = 384;
/** Time in which the page has drawn the next picture and needs the one before no more. */
const DRAWN_MS = 1000;

/** Id of the individual whose picture is shown or requested; empty if none. */
let shownFor = "";

/** @param {string|null} url */
function replace(url) {
  const before = liveStore.draftPicture.peek();
  liveStore.draftPicture.value = url;
  if (before) setTimeout(() => URL.revokeObjectURL(before), DRAWN_MS);
}

const render = forNewest(
  /** @param {{draft: Draft, sceneId: string}} newest */ async ({ draft, sceneId }) => {
    try {
      const picture = await renderGenome(draft.text, sceneId, SIDE);
      if (shownFor === draft.of.id) replace(URL.createObjectURL(picture));
    } catch (error) {
      if (shownFor === draft.of.id) showProblem("edit", { problem: problemOf(error) });
    }
  },
);

/** Requests a picture whenever the draft or the scene changes. */
export const watchDraftPicture = () =>
  effect(() => {
    const draft = lineageStore.draft.value;
    const sceneId = lineageStore.lineage.value?.scene;
    const isLive =
      liveStore.supported.value !== false &&
      liveStore.sceneDrawable.value &&
      !liveStore.draftRefused.value;
    const wanted = draft && sceneId && !isLive ? { draft, sceneId } : null;
    const id = wanted?.draft.of.id ?? "";
    if (id !== shownFor) replace(null);
    shownFor = id;
    if (wanted) void render(wanted);
  });
