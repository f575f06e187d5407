/**
 * Starts the page: draws it from the state whenever the state changes, and connects hands, keys, files, events and address.
 * Owns the order of starting and nothing else.
 */
import { effect } from "./vendor/signals-core.js";
import { render } from "./vendor/preact.js";
import { watchCompare } from "./compare.js";
import { watchComparison } from "./comparison.js";
import { restWhileHidden } from "./events.js";
import { listenToFiles } from "./files.js";
import { watchGenomes } from "./genomes.js";
import { html } from "./html.js";
import { watchInspector } from "./inspector.js";
import { keyAnywhere, keyUpAnywhere } from "./keys.js";
import { follow, start, watchLineage } from "./lineage.js";
import { watchLighting } from "./lighting.js";
import { watchLight } from "./live/light.js";
import { watchLive } from "./live/live.js";
import { keep, recall } from "./memory.js";
import { watchReady } from "./pictures.js";
import { recallMeshes, watchMeshes } from "./scene.js";
import { clipped, greySurround, hinting } from "./state.js";
import { restJobWhileHidden } from "./search_events.js";
import { watchJob } from "./search_job.js";
import { watchPicture } from "./search_picture.js";
import { followSearch, watchSearches } from "./searches.js";
import { watchSought } from "./sought.js";
import { askOnce } from "./token.js";
import { App } from "./view/app.js";

const root = document.getElementById("app");
if (!root) throw new Error("index.html has no #app");

greySurround.value = recall("grey", false);
clipped.value = recall("clipped", false);
hinting.value = recall("hint", true);
recallMeshes();
askOnce();
// One synchronous pass over the whole tree: every signal that is read while drawing is tracked, with no second library.
effect(() => render(html`<${App} />`, root));
effect(() => {
  document.body.dataset.surround = greySurround.value ? "grey" : "dark";
  keep("grey", greySurround.value);
});
effect(() => keep("clipped", clipped.value));
effect(() => keep("hint", hinting.value));
watchLineage();
watchMeshes();
watchCompare();
watchComparison();
watchInspector();
watchGenomes();
watchReady();
watchLight();
watchLighting();
watchLive();
followSearch();
watchSearches();
watchJob();
watchPicture();
watchSought();
restJobWhileHidden();
restWhileHidden();
listenToFiles();
addEventListener("hashchange", () => {
  followSearch();
  void follow();
});
addEventListener("keydown", keyAnywhere);
addEventListener("keyup", keyUpAnywhere);
void start();
