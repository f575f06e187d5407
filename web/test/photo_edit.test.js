/** Changes of a photograph in the form: guesses follow, what was set by hand stays. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { findSpot, setCircle, setCrop, setFov, setLens, setSpot, settle, uncrop } from "../photo/edit.js";
import { BALL, BALL_EXTENT, cropAround } from "../photo/setup.js";
import { photoStore } from "../photo/store.js";
import { updateDraft } from "../search/draft.js";
import { searchStore } from "../search/store.js";
import { newPicture } from "../search/views.js";

const SIZE = { width: 400, height: 300 };
const CIRCLE = { x: 200, y: 150, radius: 100 };

/** A ball with one bright pixel block in a copy of half the size. */
function codes() {
  const data = new Uint8ClampedArray(4 * 200 * 150);
  for (let y = 0; y < 150; y += 1) {
    for (let x = 0; x < 200; x += 1) {
      const inside = Math.hypot(x + 0.5 - 100, y + 0.5 - 75) < 50;
      const spot = Math.abs(x + 0.5 - 115) < 3 && Math.abs(y + 0.5 - 60) < 3;
      data.fill(spot ? 240 : inside ? 60 : 0, 4 * (y * 200 + x), 4 * (y * 200 + x) + 3);
    }
  }
  return { width: 200, height: 150, data };
}

const view = () => searchStore.draft.value.views[0];
let key = 0;

beforeEach(() => {
  const picture = newPicture(new File(["x"], "ball.png"), undefined, false);
  key = picture.key;
  photoStore.shown.value = new Map([[key, { url: "", codes: codes() }]]);
  const placed = {
    size: SIZE,
    mesh: BALL,
    extent: BALL_EXTENT,
    circle: CIRCLE,
    rotation_deg: /** @type {[number, number, number]} */ ([0, 0, 0]),
    fov_y_deg: 30,
    surface: /** @type {const} */ ("glossy"),
    spot: { x: 200, y: 150 },
    light: null,
    spotByHand: false,
    cropByHand: false,
    found: true,
  };
  updateDraft({ views: [{ ...picture, from: "placed", placed }], file: picture.file, kind: "image" });
  settle(key);
});

test("crop and light are guessed from the circle", () => {
  assert.deepEqual(view().crop, cropAround(CIRCLE, SIZE));
  const { spot, light } = view().placed;
  assert.ok(Math.hypot(spot.x - 230, spot.y - 120) < 1.5, JSON.stringify(spot));
  assert.ok(light[0] > 0.2 && light[1] > 0.2);
});

test("the spot moves with the circle while it is dragged", () => {
  const before = view().placed.spot;
  setCircle(key, { ...CIRCLE, x: CIRCLE.x + 10, radius: 50 });
  const { circle, spot } = view().placed;
  assert.deepEqual(circle, { x: 210, y: 150, radius: 50 });
  assert.ok(Math.abs(spot.x - (210 + (before.x - 200) / 2)) < 0.2);
});

test("spot and crop that were set by hand are not guessed again", () => {
  setSpot(key, { x: 180, y: 170 });
  setCrop(key, { x: 20, y: 30, width: 340, height: 250 });
  setCircle(key, { ...CIRCLE, radius: 90 });
  settle(key);
  assert.deepEqual(view().placed.spot, { x: 180, y: 170 });
  assert.deepEqual(view().crop, { x: 20, y: 30, width: 340, height: 250 });
  findSpot(key);
  assert.ok(Math.abs(view().placed.spot.x - 230) < 1.5);
  uncrop(key);
  assert.deepEqual(view().crop, { x: 0, y: 0, ...SIZE });
});

test("the lens changes the light of the same spot", () => {
  setSpot(key, { x: 260, y: 150 });
  setFov(key, 60);
  const near = view().placed.light;
  setLens(key, "far");
  const far = view().placed.light;
  assert.ok(view().placed.fov_y_deg < 2);
  assert.ok(far[0] > near[0] - 0.2 && Math.abs(far[0] - near[0]) > 0.01, `${near} ${far}`);
});

test("changes do not void what the server has read of another scene", () => {
  const target = /** @type {any} */ ({ id: "t", kind: "image" });
  updateDraft({ views: [{ ...view(), from: "default" }], target });
  settle(key);
  setSpot(key, { x: 180, y: 170 });
  assert.equal(searchStore.draft.value.target, target);
  setCrop(key, { x: 20, y: 30, width: 340, height: 250 });
  assert.equal(searchStore.draft.value.target, null);
});
