/** Two pictures over each other, the pictures that belong together, and the scenes in which they do. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { holdable } from "../flip_key.js";
import { pairOf, rest } from "../pair.js";
import { pairUrls } from "../search_picture.js";
import { isSame } from "../sought.js";

test("a flip shows the upper picture alone, and the lower one where the upper was already there", () => {
  const pair = pairOf();
  for (const [share, there] of [[0, 1], [0.5, 1], [1, 0]]) {
    pair.share.value = share;
    assert.equal(pair.seen.value, share);
    pair.key.down(1000);
    assert.equal(pair.seen.value, there);
    pair.key.up(2000);
    assert.equal(pair.seen.value, share, "held, it only glanced");
  }
  pair.key.down(3000);
  pair.key.up(3100);
  assert.equal(pair.flipped.value, true, "tapped, it stays");
  rest(pair);
  assert.equal(pair.seen.value, 0);
});

test("a button flips once by hand, by key, and by a click that nothing pressed", () => {
  const pair = pairOf();
  const { onPointerDown, onPointerUp, onPointerLeave, onClick, onKeyDown, onKeyUp } = holdable(pair.key);
  const event = (/** @type {any} */ of) => ({ timeStamp: 1000, button: 0, preventDefault() {}, ...of });
  onPointerDown(event({}));
  onPointerUp(event({ timeStamp: 1100 }));
  onPointerLeave(event({ timeStamp: 9000 }));
  onClick(event({ detail: 1 }));
  assert.equal(pair.flipped.value, true);
  onKeyDown(event({ key: "Enter" }));
  onKeyDown(event({ key: "Enter", repeat: true }));
  assert.equal(pair.flipped.value, false);
  onKeyUp(event({ key: "Enter", timeStamp: 1900 }));
  assert.equal(pair.flipped.value, true);
  onKeyDown(event({ key: "Tab" }));
  onPointerDown(event({ button: 2 }));
  onClick(event({ detail: 0 }));
  assert.equal(pair.flipped.value, false);
});

const OF = /** @type {any} */ ({ individual: "i-1", thumbnail: "/thumb.png" });
const DONE = /** @type {any} */ ({ state: "succeeded" });
const GOLD = /** @type {any} */ ({ id: "t-1", kind: "merl", views: [] });
const KNOB = /** @type {any} */ ({ id: "t-2", kind: "image", views: [{}, {}] });
/** @param {any} change */
const urls = (change) => pairUrls({ of: OF, within: DONE, to: GOLD, scene: "s-1", view: 0, viewScene: null, light: null, ...change });

test("a measured target is drawn in the scene of the find, at any light", () => {
  assert.deepEqual(urls({}), { find: "/v1/individuals/i-1/render.png?target=t-1&size=384&scene=s-1", target: "/v1/targets/t-1/render.png?size=384&scene=s-1" });
  assert.deepEqual(urls({ light: 90 }), {
    find: "/v1/individuals/i-1/render.png?target=t-1&size=384&scene=s-1&light_deg=90", target: "/v1/targets/t-1/render.png?size=384&scene=s-1&light_deg=90",
  });
  assert.match(urls({ within: { state: "running" } }).find ?? "", /size=256/);
  assert.deepEqual(urls({ of: null }), { find: null, target: "/v1/targets/t-1/render.png?size=384&scene=s-1" });
});

test("a find is drawn into the picture that it is held against, and alone under a light that the picture did not have", () => {
  assert.deepEqual(urls({ to: KNOB, view: 1 }), { find: "/v1/individuals/i-1/render.png?target=t-2&view=1", target: "/v1/targets/t-2/render.png?view=1" });
  assert.deepEqual(urls({ to: KNOB, view: 1, light: 45 }), { find: null, target: null }, "the scene is not known yet");
  assert.deepEqual(urls({ to: KNOB, view: 1, light: 45, viewScene: "s-9" }), { find: "/v1/individuals/i-1/render.png?size=384&scene=s-9&light_deg=45", target: null });
});

test("without its target a find is drawn as it was before", () => {
  assert.deepEqual(urls({ to: null }), { find: "/v1/individuals/i-1/render.png?size=384", target: null });
  assert.deepEqual(urls({ to: null, within: { state: "running" } }), { find: "/thumb.png", target: null });
  assert.deepEqual(urls({ to: null, of: null }), { find: null, target: null });
});

test("scenes are the same whatever order their fields come in", () => {
  const scene = /** @type {any} */ ({ id: "a", mesh: "knob", light_deg: 45, lights: [{ kind: "point", position: null }] });
  assert.ok(isSame(scene, /** @type {any} */ ({ lights: [{ kind: "point" }], light_deg: 45, mesh: "knob", id: "b" })));
  assert.ok(!isSame(scene, { ...scene, light_deg: 46 }));
  assert.ok(!isSame(scene, { ...scene, lights: [...scene.lights, { kind: "ambient" }] }));
});
