/** Searches: forms, logs, charts, and states in words. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { bytesInWords } from "../page/format.js";
import {
  axisOfErrors, axisOfLengths, byOperations, courseOf, leadersOf, nearestTo, stepOn,
} from "../search/chart.js";
import { dialectMismatch, requestOf } from "../search/draft.js";
import { mergeLines, progressLine, thinLines } from "../search/log.js";
import { BLANK } from "../search/store.js";
import {
  budgetInWords, canBe, choiceInWords, counted, duration, errorInWords, hasEnded, kindOf,
  reasonInWords,
} from "../search/words.js";

const TARGET = /** @type {any} */ ({ id: "t-1", name: "gold" });
const DRAFT = { ...BLANK, kind: /** @type {const} */ ("samples"), target: TARGET };

/** @param {number} generation @param {number|null} held */
const line = (generation, held) => ({
  generation,
  evaluations: 96 * generation,
  fitted: held,
  held,
  seconds: generation / 2,
});
/** @param {string} individual @param {number} operations @param {number} e_log */
const found = (individual, operations, e_log) =>
  /** @type {any} */ ({ individual, operations, e_log });

test("an unchanged form requests only a target and a budget", () => {
  assert.deepEqual(requestOf(DRAFT, "l-1"), { json: { kind: "fit", target: "t-1", seconds: 25 } });
});

test("a request has all fields of the form, with the seed as text", () => {
  const of = {
    ...DRAFT,
    name: " mine ",
    strategy: "gp",
    measure: "generations",
    seed: "18446744073709551615",
    threads: "2",
    islands: "4",
    mirrored: true,
    into: "open",
    start: { of: { id: "i-1" }, name: "the centre" },
  };
  assert.deepEqual(requestOf(of, "l-1"), {
    json: {
      kind: "fit",
      target: "t-1",
      generations: 40,
      name: "mine",
      strategy: "gp",
      seed: "18446744073709551615",
      threads: 2,
      islands: 4,
      mirrored: true,
      lineage: "l-1",
      start: ["i-1"],
    },
  });
  assert.deepEqual(requestOf({ ...DRAFT, measure: "evaluations" }, null), {
    json: { kind: "fit", target: "t-1", evaluations: 20000 },
  });
  assert.deepEqual(requestOf({ ...DRAFT, into: "open" }, null), {
    json: { kind: "fit", target: "t-1", seconds: 25 },
  });
});

test("an objective is requested only from strategies that have one", () => {
  const of = (/** @type {string} */ strategy) => {
    const asked = requestOf({ ...DRAFT, strategy, objective: "e_log" }, null);
    return "json" in asked && asked.json.objective;
  };
  assert.deepEqual(["", "hybrid", "lobes"].map(of), ["e_log", "e_log", "e_log"]);
  assert.deepEqual(["gp", "analytic"].map(of), [undefined, undefined]);
});

test("an invalid form names its wrong field", () => {
  for (const [change, field] of /** @type {[any, string][]} */ ([
    [{ target: null }, "target"],
    [{ seconds: "" }, "seconds"],
    [{ seconds: "soon" }, "seconds"],
    [{ seconds: "0" }, "seconds"],
    [{ measure: "generations", generations: "2.5" }, "generations"],
    [{ measure: "evaluations", evaluations: "1e-3" }, "evaluations"],
    [{ seed: "-1" }, "seed"],
    [{ threads: "0" }, "threads"],
    [{ threads: "two" }, "threads"],
    [{ islands: "0" }, "islands"],
  ])) {
    const asked = requestOf({ ...DRAFT, ...change }, null);
    assert.equal("field" in asked && asked.field, field, JSON.stringify(change));
  }
});

test("results fit lineages of the same machine, and those without programs", () => {
  /** @type {any} */
  const paper = { opcodes: "paper", parametrisation: "smooth", registers: 7, length: 100 };
  assert.match(dialectMismatch(paper), /paper, 7 registers/);
  assert.equal(dialectMismatch({ ...paper, length: 0 }), "");
  assert.equal(dialectMismatch({ ...paper, opcodes: "extended", registers: 16, length: 120 }), "");
  assert.notEqual(
    dialectMismatch({ ...paper, opcodes: "extended", registers: 16, length: 100 }),
    "",
  );
});

test("events and log lines are merged, each generation once", () => {
  const log = [line(1, 0.5), line(2, 0.4)];
  const later = mergeLines(log, [line(5, 0.2)]);
  assert.deepEqual(
    later.map(({ generation }) => generation),
    [1, 2, 5],
  );
  const whole = mergeLines(later, [
    { ...line(3, 0.3), best: "a" },
    { ...line(5, 0.2), best: "b" },
    line(4, 0.25),
  ]);
  assert.deepEqual(
    whole.map(({ generation }) => generation),
    [1, 2, 3, 4, 5],
  );
  assert.equal(
    mergeLines(whole, [line(5, 0.2)])[4].best,
    "b",
    "an event does not take away what the log knew",
  );
  assert.equal(mergeLines(whole, []), whole);
  assert.deepEqual(
    progressLine({ generation: 0, evaluations: 0, seconds: 0, fitted: null, held: null }),
    [],
  );
});

test("thinLines keeps both ends", () => {
  const many = Array.from({ length: 10001 }, (_, at) => at);
  const few = thinLines(many, 300);
  assert.deepEqual([few.length, few[0], few.at(-1)], [300, 0, 10000]);
  assert.equal(thinLines(few, 300), few);
});

test("axisOfErrors has steps of 1, 2, 5, or whole decades over a wide range", () => {
  assert.deepEqual(axisOfErrors([0.013, 0.31]), {
    low: 0.01,
    high: 0.5,
    ticks: [0.01, 0.02, 0.05, 0.1, 0.2, 0.5],
    log: true,
  });
  assert.deepEqual(axisOfErrors([0.02]).ticks, [0.02, 0.05]);
  const wide = axisOfErrors([3e-6, 4, null, Number.NaN, 0]);
  assert.deepEqual([wide.low, wide.high], [2e-6, 5]);
  assert.deepEqual(wide.ticks, [1e-5, 1e-4, 1e-3, 0.01, 0.1, 1]);
  assert.deepEqual(axisOfErrors([null, undefined]).ticks, [0.1, 0.2, 0.5, 1]);
  for (const [low, high] of [
    [1e-4, 1e-4],
    [0.00025, 0.00045],
    [7, 9],
  ]) {
    const axis = axisOfErrors([low, high]);
    assert.ok(axis.low <= low && axis.high >= high && axis.ticks.length >= 2, `${axis.ticks}`);
  }
});

test("courseOf has a point per generation with an error", () => {
  const { fitted, held, x } = courseOf([line(1, null), line(2, 0.4), line(4, 0.2)], "generation");
  assert.deepEqual(held, [
    [1, null],
    [2, 0.4],
    [4, 0.2],
  ]);
  assert.equal(fitted.length, 3);
  assert.equal(x.high, 4);
  assert.equal(courseOf([line(1, 0.3)], "seconds").x.high, 0.5);
});

test("axisOfLengths begins at 0, or near the shortest of similar lengths", () => {
  assert.equal(axisOfLengths([5, 300]).low, 0);
  const near = axisOfLengths([183, 233]);
  assert.ok(near.low > 150 && near.low <= 183 && near.high >= 233, `${near.ticks}`);
  assert.ok(near.ticks.every(Number.isInteger));
  assert.ok(axisOfLengths([200]).high >= 200);
  assert.ok(axisOfLengths([]).high > 0);
  assert.ok(axisOfLengths([200, 201]).high >= 201);
});

test("a front is sorted by length, and keys step along it", () => {
  const front = byOperations([
    found("a", 200, 0.1),
    found("b", 50, 0.3),
    found("c", 100, 0.4),
    found("d", 50, 0.2),
  ]);
  assert.deepEqual(
    front.map(({ individual }) => individual),
    ["d", "b", "c", "a"],
  );
  assert.deepEqual(
    leadersOf(front).map(({ individual }) => individual),
    ["d", "a"],
  );
  assert.deepEqual(
    ["ArrowRight", "ArrowLeft", "Home", "End", "Enter"].map((key) => stepOn(front, 1, key)),
    [2, 0, 0, 3, null],
  );
  assert.equal(stepOn(front, 3, "ArrowRight"), 3);
});

test("nearestTo finds the nearest point within reach", () => {
  const places = /** @type {[number, number][]} */ ([
    [0, 0],
    [10, 0],
    [100, 100],
  ]);
  assert.equal(nearestTo(places, [7, 1], 22), 1);
  assert.equal(nearestTo(places, [60, 60], 22), -1);
  assert.equal(nearestTo([], [0, 0], 22), -1);
});

test("kindOf recognises files by their names", () => {
  assert.deepEqual(
    [
      "a.CSV",
      "b.exr",
      "gold.binary",
      "x_rgb.bsdf",
      "paint.brdf",
      "c.obj",
      "d.PNG",
      "e.jpeg",
      "f.hdr",
    ].map(kindOf),
    ["samples", "slice", "merl", "rgl", "cornell", "", "image", "image", "image"],
  );
});

test("canBe depends on the state", () => {
  assert.deepEqual(canBe({ state: "running" }), { paused: true, resumed: false, cancelled: true });
  assert.deepEqual(canBe({ state: "paused" }), { paused: false, resumed: true, cancelled: true });
  assert.deepEqual(canBe({ state: "succeeded" }), {
    paused: false,
    resumed: false,
    cancelled: false,
  });
  assert.ok(hasEnded({ state: "failed" }) && !hasEnded({ state: "queued" }));
});

test("durations, budgets, errors and sizes are written in words", () => {
  assert.deepEqual([0.4, 25, 60, 185, 7800, 90000].map(duration), [
    "0.4 s",
    "25 s",
    "1 min",
    "3 min 5 s",
    "2 h 10 min",
    "1 d 1 h",
  ]);
  assert.deepEqual(
    [{ seconds: 25 }, { generations: 1 }, { evaluations: 100000 }].map(budgetInWords),
    ["25 s", "1 generation", "100,000 evaluations"],
  );
  assert.deepEqual([0.012345, 1.5, 0.00036276, 2e-7, null].map(errorInWords), [
    "0.0123",
    "1.5",
    "0.000363",
    "2 × 10⁻⁷",
    "–",
  ]);
  assert.equal(counted(2, "find"), "2 finds");
  assert.deepEqual([500, 104000, 33e6].map(bytesInWords), ["500 bytes", "102 KiB", "31.5 MiB"]);
  assert.match(reasonInWords("worker_lost"), /worker/);
  assert.equal(reasonInWords("the target is gone"), "the target is gone");
});

test("the best result is explained where another has a lower held-out error", () => {
  const front = (/** @type {number[]} */ ...errors) =>
    /** @type {any[]} */ (errors.map((e_log) => ({ e_log })));
  assert.equal(choiceInWords(front(0.1)), "");
  assert.equal(choiceInWords(front(0.1, 0.2, 0.3)), "");
  assert.match(choiceInWords(front(0.2, 0.1, 0.3)), /one other result has a lower held-out error/);
  assert.match(choiceInWords(front(0.3, 0.1, 0.2)), /2 other results have/);
});
