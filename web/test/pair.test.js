/**
 * Two pictures over each other, addresses of pictures that belong together, and equality of scenes.
 */
import assert from "node:assert/strict";
import { test } from "node:test";
import { flipHandlers } from "../compare/flip_key.js";
import { pairOf, resetPair } from "../compare/pair.js";
import { pairUrls } from "../search/pair_urls.js";
import { sameScene } from "../search/same_scene.js";

test("a flip shows the upper picture alone, or the lower one if the upper was shown", () => {
  const pair = pairOf();
  for (const [share, there] of [
    [0, 1],
    [0.5, 1],
    [1, 0],
  ]) {
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
  resetPair(pair);
  assert.equal(pair.seen.value, 0);
});

test("a button flips once by pointer, by key, and by a click without a press", () => {
  const pair = pairOf();
  const { onPointerDown, onPointerUp, onPointerLeave, onClick, onKeyDown, onKeyUp } = flipHandlers(
    pair.key,
  );
  const event = (/** @type {any} */ of) => ({
    timeStamp: 1000,
    button: 0,
    preventDefault() {},
    ...of,
  });
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
const urls = (change) =>
  pairUrls({
    of: OF,
    within: DONE,
    to: GOLD,
    scene: "s-1",
    view: 0,
    viewScene: null,
    light: null,
    ...change,
  });

test("a measured target is drawn in the result's scene under any light", () => {
  assert.deepEqual(urls({}), {
    find: "/v1/individuals/i-1/render.png?target=t-1&size=384&scene=s-1",
    target: "/v1/targets/t-1/render.png?size=384&scene=s-1",
  });
  assert.deepEqual(urls({ light: 90 }), {
    find: "/v1/individuals/i-1/render.png?target=t-1&size=384&scene=s-1&light_deg=90",
    target: "/v1/targets/t-1/render.png?size=384&scene=s-1&light_deg=90",
  });
  assert.match(urls({ within: { state: "running" } }).find ?? "", /size=256/);
  assert.deepEqual(urls({ of: null }), {
    find: null,
    target: "/v1/targets/t-1/render.png?size=384&scene=s-1",
  });
});

test("a result is drawn like the target's picture, and alone under another light", () => {
  assert.deepEqual(urls({ to: KNOB, view: 1 }), {
    find: "/v1/individuals/i-1/render.png?target=t-2&view=1",
    target: "/v1/targets/t-2/render.png?view=1",
  });
  assert.deepEqual(
    urls({ to: KNOB, view: 1, light: 45 }),
    { find: null, target: null },
    "the scene is not known yet",
  );
  assert.deepEqual(urls({ to: KNOB, view: 1, light: 45, viewScene: "s-9" }), {
    find: "/v1/individuals/i-1/render.png?size=384&scene=s-9&light_deg=45",
    target: null,
  });
});

test("a result without a target keeps its own picture", () => {
  assert.deepEqual(urls({ to: null }), {
    find: "/v1/individuals/i-1/render.png?size=384",
    target: null,
  });
  assert.deepEqual(urls({ to: null, within: { state: "running" } }), {
    find: "/thumb.png",
    target: null,
  });
  assert.deepEqual(urls({ to: null, of: null }), { find: null, target: null });
});

test("scenes are the same whatever order their fields come in", () => {
  const scene = /** @type {any} */ ({
    id: "a",
    mesh: "knob",
    light_deg: 45,
    lights: [{ kind: "point", position: null }],
  });
  assert.ok(
    sameScene(
      scene,
      /** @type {any} */ ({ lights: [{ kind: "point" }], light_deg: 45, mesh: "knob", id: "b" }),
    ),
  );
  assert.ok(!sameScene(scene, { ...scene, light_deg: 46 }));
  assert.ok(!sameScene(scene, { ...scene, lights: [...scene.lights, { kind: "ambient" }] }));
});
