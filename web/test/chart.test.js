/** Line charts: round ticks, positions, and lines with gaps. */
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  areFarApart, axisOfDecades, axisTo, largestOf, lineThrough, placeOn,
} from "../page/chart.js";

test("an axis has round ticks from 0 to past the largest value", () => {
  assert.deepEqual(axisTo(1, 5).ticks, [0, 0.2, 0.4, 0.6, 0.8, 1]);
  assert.deepEqual(axisTo(0.93, 5).ticks, [0, 0.2, 0.4, 0.6, 0.8, 1]);
  assert.deepEqual(axisTo(22, 5).ticks, [0, 5, 10, 15, 20, 25]);
  assert.deepEqual(axisTo(0.31, 3).ticks, [0, 0.2, 0.4]);
  for (const largest of [1e-7, 0.017, 0.7, 3, 9.99, 1234, 8e9]) {
    const { high, ticks } = axisTo(largest, 5);
    assert.ok(high >= largest && ticks.length >= 3 && ticks.length <= 7, `${largest}: ${ticks}`);
  }
});

test("axisTo returns an axis when there is no value", () => {
  for (const nothing of [0, -1, Number.NaN, Infinity]) assert.equal(axisTo(nothing, 5).high, 1);
  assert.equal(largestOf([[], [[0, null]]]), 0);
  assert.equal(
    largestOf([
      [
        [0, 2],
        [1, null],
      ],
      [[0, 3]],
    ]),
    3,
  );
});

test("placeOn maps values between the ends, in either direction", () => {
  const axis = axisTo(10, 5);
  assert.equal(placeOn(axis, 5, 100, 200), 150);
  assert.equal(placeOn(axis, 10, 200, 100), 100);
});

test("lineThrough interrupts the path at missing values", () => {
  const box = { left: 0, top: 0, width: 100, height: 50 };
  const x = axisTo(10, 5);
  const y = axisTo(1, 5);
  assert.equal(
    lineThrough(
      [
        [0, 0],
        [5, 1],
        [6, null],
        [10, 0.5],
      ],
      x,
      y,
      box,
    ),
    "M0.0 50.0L50.0 0.0M100.0 25.0",
  );
});

test("axisOfDecades spans all values and places 0 at its low end", () => {
  const axis = axisOfDecades([
    [
      [0, 0],
      [5, 0.03],
    ],
    [
      [0, 900],
      [5, null],
      [6, 0.1],
    ],
  ]);
  assert.deepEqual(axis, {
    low: 0.01,
    high: 1000,
    ticks: [0.01, 0.1, 1, 10, 100, 1000],
    log: true,
  });
  assert.equal(placeOn(axis, 10, 0, 100).toFixed(9), "60.000000000");
  assert.equal(placeOn(axis, 0, 0, 100), 0);
  assert.deepEqual(
    axisOfDecades([
      [
        [0, 1e-12],
        [1, 1],
      ],
    ]).ticks,
    [1, 10],
    "too small to matter",
  );
  const wide = axisOfDecades([[[0, 0.5]], [[0, 4e9]]]);
  assert.ok(wide.low === 0.1 && wide.high >= 4e9 && wide.ticks.length <= 8, `${wide.ticks}`);
  assert.equal(axisOfDecades([]).ticks.length, 2);
});

test("areFarApart is true when a line would be invisible on a linear axis", () => {
  assert.equal(areFarApart([[[0, 1]], [[0, 20]]]), false);
  assert.equal(areFarApart([[[0, 1]], [[0, 30]]]), true);
  assert.equal(areFarApart([[[0, 0]], [[0, 30]]]), false);
});
