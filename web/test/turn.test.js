/** Rotation by hand: angles and matrices, and drags. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { axes, dragged, fromDegrees, toDegrees } from "../scene/rotation.js";

const apply = (m, v) =>
  [0, 1, 2].map((row) => m[3 * row] * v[0] + m[3 * row + 1] * v[1] + m[3 * row + 2] * v[2]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

test("toDegrees inverts fromDegrees for y within 90 degrees", () => {
  for (const angles of [
    [0, 0, 0],
    [10, 20, 30],
    [-170, 45.5, 99.9],
    [5, -89, 12],
  ])
    assert.deepEqual(toDegrees(fromDegrees(angles)), angles);
});

test("toDegrees returns the same rotation at the poles of y", () => {
  const before = fromDegrees([25, 90, 10]);
  const after = fromDegrees(toDegrees(before));
  before.forEach((value, at) =>
    assert.ok(Math.abs(value - after[at]) < 2e-3, `${before} ${after}`),
  );
});

test("fromDegrees rotates about x first, then y, then z", () => {
  // y to z by x; z is unchanged by y.
  const turned = apply(fromDegrees([90, 0, 90]), [0, 1, 0]);
  assert.ok(Math.abs(turned[2] - 1) < 1e-12, String(turned));
});

test("the front of the object follows the pointer for every camera", () => {
  for (const camera of [
    { orbit_deg: [30, 20] },
    { orbit_deg: [-120, -40] },
    { orbit_deg: [10, 90] },
    { orthographic: 1 },
    { eye: [1, 2, 3], target: [0, 0, 0], up: [0, 1, 0] },
  ]) {
    const { right, up, back } = axes(camera);
    assert.ok(Math.abs(dot(right, up)) < 1e-12 && Math.abs(dot(right, back)) < 1e-12);
    const front = (m) => apply(m, back);
    const still = fromDegrees([0, 0, 0]);
    assert.ok(dot(front(dragged(still, camera, 20, 0)), right) > 0.3, JSON.stringify(camera));
    assert.ok(dot(front(dragged(still, camera, 0, 20)), up) < -0.3, JSON.stringify(camera));
  }
});

test("an azimuth rotates the default camera from +z towards +x", () => {
  const { back } = axes({ orbit_deg: [90, 0] });
  assert.ok(Math.abs(back[0] - 1) < 1e-12, String(back));
});
