/** Places of several objects, what cameras see of them, and the exposure of a ground. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { isDrawable, materialsOf, viewOf } from "../live/camera.js";
import { partPaths } from "../live/geometry.js";
import { gainBetween } from "../live/ground_exposure.js";
import { moved, stageOf, viewFrom } from "../live/stage.js";
import { fromDegrees } from "../scene/rotation.js";

/** @import { Scene, Vec3 } from "../model.js" */

/** @param {Vec3} centre @param {number} radius @param {number[]} [positions] */
const shape = (centre, radius, positions = [0, -1, 0, 0.6, 0.8, 0]) => ({
  extent: { centre, radius },
  positions: new Float32Array(positions),
});

/** @type {Scene} */
const SCENE = {
  mesh: "knob",
  rotation_deg: [0, 0, 0],
  scale: 1,
  camera: {},
  film: { exposure: "auto", tone: "none" },
};

/** @param {number[]} found @param {number[]} wanted */
function near(found, wanted) {
  assert.equal(found.length, wanted.length);
  found.forEach((value, k) =>
    assert.ok(Math.abs(value - wanted[k]) < 1e-6, `${found} is not ${wanted}`),
  );
}

test("objects are placed in the unit frame of a rotated and scaled subject", () => {
  const pose = { rotation: fromDegrees([0, 90, 0]), scale: 2 };
  const objects = [{ position: /** @type {Vec3} */ ([4, 0, 0]), scale: 3 }];
  const shapes = [shape([0, 0, 0], 1), shape([0, 1, 0], 0.5)];
  const { places, framed, reach, all } = stageOf({ objects }, pose, shapes);
  near(places[0].offset, [0, 0, 0]);
  near(places[1].offset, [0, 0.5, 2]);
  assert.equal(places[1].size, 0.75);
  near(moved(places[1], [0, 1, 0]), [0, 1.25, 2]);
  near(moved(places[1], [1, 0, 0]), [0, 0.5, 2.75]);
  near([framed, reach, all], Array(3).fill(Math.hypot(4, 1) + 1.5));
});

test("objects stand a gap above the ground, which is a gap below the subject", () => {
  const pose = { rotation: fromDegrees([0, 0, 180]), scale: 2 };
  const shapes = [shape([0, 3, 0], 2), shape([0, 0, 0], 1), shape([0, 0, 0], 1)];
  const objects = [{ stands: true, position: /** @type {Vec3} */ ([9, 77, 0]), scale: 4 }];
  const { places, reach, all } = stageOf({ objects, ground: {} }, pose, shapes);
  const gap = 1e-3;
  // Upside down, the lowest vertex of the subject is 0.8 below its centre; y points down there.
  near([moved(places[2], [0, 0, 0])[1]], [0.8 + gap]);
  near([moved(places[1], [0, -1, 0])[1]], [0.8]);
  assert.ok(all > 1000 && reach < 20, `${all} ${reach}`);
  const high = stageOf({ ground: { height: 5 } }, pose, [shapes[0], shapes[2]]);
  near(high.places[1].offset, [0, -0.5, 0]);
});

test("an object sees the camera as the subject does", () => {
  const pose = { rotation: fromDegrees([10, 20, 30]), scale: 1.5 };
  const objects = [
    { position: /** @type {Vec3} */ ([1, 2, 3]), rotation_deg: /** @type {Vec3} */ ([40, 5, 0]) },
  ];
  const shapes = [shape([0, 0, 0], 1), shape([0, 1, 0], 0.5)];
  const stage = stageOf({ objects }, pose, shapes);
  const view = viewOf({ orbit_deg: [30, 20], fov_y_deg: 30 }, shapes[0].extent, pose, stage);
  const own = viewFrom(view, stage.places[1]);
  near(moved(stage.places[1], own.eye), view.eye);
  near([own.far * stage.places[1].size, own.half], [view.far, view.half]);
  // The whole stage is between near and far.
  assert.ok(view.near < Math.hypot(...view.eye) - stage.reach / pose.scale);
});

test("stops of a ground are interpolated around the circle", () => {
  near([0, 45, 90, 315, -45, 360].map((at) => gainBetween([1, 4, 16, 4], at) ?? 0), [1, 2, 4, 2, 2, 1]);
  assert.equal(gainBetween([null, 4, null, null], 45), 4);
  assert.equal(gainBetween([null, 4, null, null], 200), null);
});

test("scenes with other objects are drawn live under point, spot and directional lights alone", () => {
  const beside = { ...SCENE, shadows: true, ground: {}, objects: [{ material: "gold" }] };
  assert.deepEqual(materialsOf(beside), ["gold", ""]);
  assert.deepEqual(partPaths(beside), [
    "/v1/meshes/knob/geometry", "/v1/meshes/sphere/geometry", "/v1/meshes/ground/geometry",
  ]);
  const lamp = { kind: /** @type {const} */ ("point") };
  const environment = { kind: /** @type {const} */ ("environment"), image: "studio" };
  const sun = { kind: /** @type {const} */ ("directional"), irradiance_w_m2: 3 };
  assert.equal(isDrawable({ ...beside, lights: [lamp, lamp] }), true);
  assert.equal(isDrawable({ ...beside, lights: [lamp, sun, { kind: "spot" }] }), true);
  assert.equal(isDrawable({ ...beside, lights: [{ ...sun, illuminance_lx: 5 }] }), false);
  assert.equal(isDrawable({ ...beside, lights: [lamp, environment] }), false);
  assert.equal(isDrawable({ ...beside, shadows: false, lights: [environment] }), false);
  assert.equal(isDrawable({ ...SCENE, lights: [lamp, environment] }), true);
  assert.equal(isDrawable({ ...beside, lights: [{ kind: "sphere" }] }), false);
  assert.equal(isDrawable({ ...beside, backdrop: { kind: "environment", blur_deg: 0 } }), false);
});
