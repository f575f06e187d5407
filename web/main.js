/**
 * Starts the page: draws it, and connects the stores with storage, server, address and keyboard.
 *
 * State is in stores, the `store.js` of each folder: objects whose fields are signals. If a signal
 * changes, the components of `view` that have read it are drawn again, and the effects that have
 * read it, which the `watch` functions create, run again. Folders: `api` (requests to the server),
 * `page` (address, settings, problems), `lineage` (breeding and history), `scene` (object and
 * light), `live` (drawing by WebGL 2), `search`, `favourites`, `compare`, `view` (components). The
 * server's pictures are shown first; `live` draws over them.
 */
import { render } from "./vendor/preact.js";
import { effect } from "./vendor/signals-core.js";
import { loadTokenState } from "./api/session.js";
import { watchCompare } from "./compare/ab.js";
import { watchComparison } from "./compare/comparison.js";
import { followFavouritesAddress, watchFavourites } from "./favourites/list.js";
import { pauseWhileHidden } from "./lineage/events.js";
import { watchEdit } from "./lineage/edit.js";
import { watchGenomes } from "./lineage/genomes.js";
import { watchInspector } from "./lineage/inspector.js";
import { watchListed } from "./lineage/listed.js";
import { followAddress, openFromAddress, watchLineage } from "./lineage/open.js";
import { watchReady } from "./lineage/pictures.js";
import { watchSync } from "./lineage/sync.js";
import { watchDraftPicture } from "./live/draft_picture.js";
import { watchLight } from "./live/light_circle.js";
import { watchLive } from "./live/loop.js";
import { loadSetting, saveSetting } from "./page/memory.js";
import { pageStore } from "./page/store.js";
import { loadMeshes, watchMeshes } from "./scene/edit.js";
import { watchExtent } from "./scene/light_controls.js";
import { watchActiveTarget } from "./search/active_target.js";
import { pauseJobWhileHidden } from "./search/events.js";
import { watchJob } from "./search/job.js";
import { watchPictures } from "./search/picture.js";
import { followSearchAddress, watchSearches } from "./search/searches.js";
import { App } from "./view/app.js";
import { listenToFiles } from "./view/file_drop.js";
import { html } from "./view/html.js";
import { keyAnywhere, keyUpAnywhere } from "./view/keys.js";
import { watchLightDot } from "./view/light.js";
import { watchDetails } from "./view/lineage/details.js";
import { watchStrip } from "./view/lineage/strip.js";

const root = document.getElementById("app");
if (!root) throw new Error("index.html has no #app");

pageStore.greySurround.value = loadSetting("grey", false);
pageStore.clippingShown.value = loadSetting("clipped", false);
pageStore.hintShown.value = loadSetting("hint", true);
loadMeshes();
loadTokenState();
render(html`<${App} />`, root);
effect(() => {
  document.body.dataset.surround = pageStore.greySurround.value ? "grey" : "dark";
  saveSetting("grey", pageStore.greySurround.value);
});
effect(() => saveSetting("clipped", pageStore.clippingShown.value));
effect(() => saveSetting("hint", pageStore.hintShown.value));
watchLineage();
watchListed();
watchSync();
watchMeshes();
watchCompare();
watchComparison();
watchInspector();
watchDetails();
watchGenomes();
watchEdit();
watchReady();
watchLight();
watchExtent();
watchLive();
watchDraftPicture();
watchLightDot();
watchStrip();
followSearchAddress();
followFavouritesAddress();
watchFavourites();
watchSearches();
watchJob();
watchPictures();
watchActiveTarget();
pauseJobWhileHidden();
pauseWhileHidden();
listenToFiles();
addEventListener("hashchange", () => {
  followSearchAddress();
  followFavouritesAddress();
  void followAddress();
});
addEventListener("keydown", keyAnywhere);
addEventListener("keyup", keyUpAnywhere);
void openFromAddress();
