/** Parameters edited by hand: positions of sliders, typed values, colours, the genome's text. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { genomeIn } from "../lineage/layers.js";
import {
  hasValues, isPicked, pickedChannels, pickerColor, positionOf, readValue, shownChannel, shownValue,
  valueAt, withParameters, withValue,
} from "../lineage/parameters.js";
import { centreOf } from "../lineage/store.js";
import { madeBy } from "../page/format.js";
import { forNewest } from "../page/newest.js";

/**
 * @param {Partial<import("../model.js").ParameterInfo>} some
 * @returns {import("../model.js").ParameterInfo}
 */
const parameter = (some) => ({
  name: "metallic",
  about: "",
  unit: "",
  kind: "scalar",
  range: [0, 1],
  scale: "linear",
  default: [0.5],
  words: [],
  ...some,
});
const METALLIC = parameter({});
const ROUGHNESS = parameter({
  name: "roughness",
  range: [1e-4, 1],
  scale: "logarithmic",
  default: [0.2],
});
const STRETCH = parameter({ name: "stretch", range: [-4, 4], default: [0] });
const HEIGHT = parameter({ name: "a", kind: "color", range: [0, 1e6], default: [20, 20, 20] });
const F0 = parameter({ name: "f0", kind: "color", default: [0.04, 0.04, 0.04] });

test("a slider covers its range on the parameter's scale", () => {
  assert.deepEqual([0, 0.5, 1].map((at) => valueAt(METALLIC, at)), [0, 0.5, 1]);
  assert.deepEqual([0, 0.5, 1].map((at) => valueAt(ROUGHNESS, at)), [1e-4, 0.01, 1]);
  assert.deepEqual([0, 0.5, 1].map((at) => valueAt(STRETCH, at)), [-4, 0, 4]);
  assert.deepEqual([0, 1].map((at) => valueAt(HEIGHT, at)), [0, 1e6]);
  assert.equal(positionOf(ROUGHNESS, 0.01), 0.5);
  assert.equal(positionOf(STRETCH, 1), 0.625);
});

test("a range far wider than its default is logarithmic above it", () => {
  assert.ok(positionOf(HEIGHT, 20) > 0.15 && positionOf(HEIGHT, 20) < 0.3);
  assert.ok(positionOf(HEIGHT, 2000) > 0.4);
  const shadowing = parameter({ range: [0, 1e38], default: [1e-7] });
  assert.equal(valueAt(shadowing, 0), 0);
  assert.ok(Number.isFinite(valueAt(shadowing, 0.999)));
});

test("positions and values are inverse to each other, within the digits that are kept", () => {
  for (const of of [METALLIC, ROUGHNESS, STRETCH, HEIGHT])
    for (let at = 0; at <= 200; at += 1) {
      const value = valueAt(of, at / 200);
      assert.ok(value >= of.range[0] && value <= of.range[1], `${of.name} ${value}`);
      assert.equal(value, Number(value.toPrecision(4)), `${of.name} has few digits`);
      const off = Math.abs(positionOf(of, value) - at / 200);
      assert.ok(off < 0.002, `${of.name} at ${at}: ${value}`);
    }
});

test("typed values are read with either decimal mark, and others get a reason", () => {
  /** @type {[string, number][]} */
  const read = [["0.5", 0.5], [" 0,25 ", 0.25], [".5", 0.5], ["1e-2", 0.01], ["1", 1]];
  for (const [text, value] of read)
    assert.deepEqual(readValue(ROUGHNESS, text), { value, wrong: "" });
  const reason = (/** @type {string} */ text) => readValue(ROUGHNESS, text).wrong;
  assert.equal(reason("2"), "roughness must be between 0.0001 and 1, got 2");
  assert.equal(reason("0"), "roughness must be between 0.0001 and 1, got 0");
  assert.equal(reason(""), "roughness must be between 0.0001 and 1, and is empty");
  for (const text of ["shiny", "1,000.5", "0x1", "Infinity", "NaN", "1 2", "."])
    assert.match(reason(text), /^roughness must be a number between 0.0001 and 1, got “/, text);
  assert.equal(readValue(F0, "2", "red of f0").wrong, "red of f0 must be between 0 and 1, got 2");
  assert.equal(shownValue(0.384726), "0.3847");
});

test("colours that a screen can show have a picker, which keeps a picked colour", () => {
  assert.ok(isPicked(F0) && !isPicked(HEIGHT) && !isPicked(ROUGHNESS));
  assert.ok(!isPicked(parameter({ name: "eta", kind: "color", range: [0.02, 10] })));
  assert.ok(!isPicked(parameter({ name: "specular" })), "the principled model's is a number");
  for (let code = 0; code < 256; code += 1) {
    const color = `#${code.toString(16).padStart(2, "0")}80ff`;
    assert.equal(pickerColor(pickedChannels(color)), color);
  }
  assert.equal(pickerColor([-1, 2, 0]), "#00ff00");
  assert.deepEqual([0.0331, 0.13287, 0, 1].map(shownChannel), ["0.033", "0.133", "0", "1"]);
});

const TEXT = `brood 1
.dialect paper smooth registers 7
.limit on
.model lambert
albedo 0.3 0.13 0.05
.model cook-torrance
f0 1 0.7 0.3
roughness 0.0001
distribution ggx
MUL R2.x, R0.x, R0.x
`;

test("only edited parameters change in a genome's text", () => {
  const { layers } = genomeIn(TEXT);
  assert.equal(withParameters(TEXT, layers), TEXT);
  assert.ok(hasValues(TEXT, layers));
  const rough = withValue(layers, 1, "roughness", [0.25]);
  const edited = withParameters(TEXT, withValue(rough, 1, "distribution", "beckmann"));
  assert.equal(
    edited,
    TEXT.replace("roughness 0.0001", "roughness 0.25").replace("ggx", "beckmann"),
  );
  assert.ok(!hasValues(TEXT, rough) && hasValues(TEXT, withValue(rough, 1, "roughness", [1e-4])));
  assert.deepEqual(genomeIn(edited).layers[0], layers[0]);
  assert.equal(layers[1].parameters[1].value[0], 1e-4, "the layers before stay as they are");
});

test("an edited child is in the centre, and says that it was edited", () => {
  const child = /** @type {any} */ ({ id: "child", operator: "adopt", parents: ["parent"] });
  const centre = /** @type {any} */ ({ id: "parent" });
  /** @param {any} some @returns {any} */
  const of = (some) => ({ centre, parents: ["parent"], ...some });
  assert.equal(centreOf(of({ individuals: [child] })), child);
  assert.equal(centreOf(of({ individuals: [child, child] })), centre);
  assert.equal(centreOf(of({ individuals: [{ ...child, operator: "mutate" }] })), centre);
  assert.equal(madeBy(child), "editing its parent");
  assert.equal(madeBy({ ...child, parents: [] }), "imported");
});

test("work for the newest value runs once at a time and skips values in between", async () => {
  /** @type {number[]} */
  const done = [];
  /** @type {(() => void)[]} */
  const ends = [];
  const ask = forNewest(
    (/** @type {number} */ value) =>
      new Promise((end) => {
        done.push(value);
        ends.push(() => end(undefined));
      }),
  );
  const first = ask(1);
  void ask(2);
  void ask(3);
  assert.deepEqual(done, [1]);
  ends[0]();
  await Promise.resolve();
  assert.deepEqual(done, [1, 3]);
  ends[1]();
  await first;
  const last = ask(4);
  assert.deepEqual(done, [1, 3, 4]);
  ends[2]();
  await last;
});
