/** Controls of a light's shape. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { shapeControls } from "../scene/light_shape.js";

const extent = { centre: /** @type {[number, number, number]} */ ([0, 0, 0]), radius: 2 };

test("sizes of lights are relative to the object", () => {
  const [radius] = shapeControls({ kind: "sphere" }, extent);
  assert.deepEqual([radius.value, radius.shown], [0.5, "0.5 ×"]);
  assert.deepEqual(radius.change(1.5), { radius: 3 });
  const sides = shapeControls({ kind: "rectangle", width: 1 }, extent);
  assert.deepEqual(
    sides.map(({ id, value }) => [id, value]),
    [
      ["light-width", 0.5],
      ["light-height", 1],
    ],
  );
});

test("a spot has a cone, and a softness that keeps while the cone changes", () => {
  const [cone, softness] = shapeControls({ kind: "spot", hotspot_deg: 10, falloff_deg: 20 }, extent);
  assert.deepEqual([cone.value, softness.value], [20, 0.5]);
  assert.deepEqual(cone.change(40), { falloff_deg: 40, hotspot_deg: 20 });
  assert.deepEqual(softness.change(0), { falloff_deg: 20, hotspot_deg: 20 });
  assert.equal(shapeControls({ kind: "spot" }, extent)[0].value, 15);
});

test("other lights have no shape", () => {
  assert.deepEqual(shapeControls({ kind: "point" }, extent), []);
  assert.deepEqual(shapeControls({}, extent), []);
});
