// Lights of painted materials: order, relative colours, environments as directions.

import assert from "node:assert/strict";
import { test } from "node:test";

import { rotationOf } from "../live/camera.js";
import { isStyle } from "../live/material.js";
import { paintLightsOf } from "../live/paint_lights.js";
import { genomeIn, isByBrdf, isPainted } from "../lineage/layers.js";
import { withParameters, withValue } from "../lineage/parameters.js";
import { toonShape } from "../lineage/toon_shape.js";

const EXTENT = { centre: [0, 0, 0], radius: 1 };
const MEAN = { radiance: [0.5, 0.25, 0.125], direction: [0, 0, 1] };

const lights = (scene, degrees = 0, mean = MEAN) => {
  const pose = { rotation: rotationOf({ rotation_deg: [0, 0, 0] }), scale: 1 };
  return paintLightsOf({ mesh: "sphere", ...scene }, EXTENT, pose, degrees, () => mean);
};

const near = (found, expected) =>
  found.forEach((value, k) => assert.ok(Math.abs(value - expected[k]) < 1e-9, `${found} ${expected}`));

test("lights keep their order, and colours are relative to the strongest", () => {
  const environment = { kind: "environment", image: "studio", scale: [1, 2, 1], fixed: true };
  const found = lights({ lights: [environment, { position: [0, 0, 2], intensity: [4, 8, 2] }] });
  assert.deepEqual(found.map(({ isDirection }) => isDirection), [true, false]);
  // At the centre: pi / 2 in red and green of the environment, 2 in green of the lamp.
  near(found[0].color, [Math.PI / 4, Math.PI / 4, Math.PI / 16]);
  near(found[1].color, [2, 4, 1]);
  near(found[0].place, [0, 0, 1]);
});

test("environments turn with the light unless they are fixed", () => {
  const environment = { kind: "environment", image: "studio", rotation_deg: 30 };
  near(lights({ lights: [environment] }, 60)[0].place, [1, 0, 0]);
  near(lights({ lights: [{ ...environment, fixed: true }] }, 60)[0].place, [0.5, 0, Math.cos(Math.PI / 6)]);
});

test("what cannot be drawn has no lights", () => {
  const environment = { kind: "environment", image: "studio" };
  assert.equal(lights({ lights: [environment] }, 0, null), null);
  assert.equal(lights({ lights: [environment] }, 0, { radiance: [1, 1, 1] }), null);
  assert.equal(lights({ lights: [{}], backdrop: { kind: "environment" } }), null);
  assert.equal(lights({ lights: Array(9).fill({}) }), null);
  assert.equal(lights({ lights: [] }).length, 1, "one dark light");
});

test("exported code tells painted materials from BRDFs", () => {
  assert.ok(isStyle("vec3 styled(StyledPoint at, StyledLight[2] lights) {"));
  assert.ok(!isStyle("vec3 evolved(vec3 wi, vec3 wo, vec3 n, vec3 x, vec3 y, vec2 uv) {"));
});

test("toon shapes are effects between models and instructions, and edits keep them", () => {
  const models = "brood 1\n.model phong\nexponent 30\n";
  const shape = toonShape(models);
  assert.ok(shape.startsWith(`${models}.effect light\n`) && shape.endsWith("\nto 0.82\n"), shape);
  const genome = genomeIn(shape);
  assert.deepEqual(genome.layers, genomeIn(models).layers);
  assert.ok(isPainted(genome) && isByBrdf(genome) && !isByBrdf(genomeIn(models)));
  const program = "brood 1\n.dialect paper smooth registers 7\n.const C0 1 2 3 4\nADD R0, R1, C0\n";
  const bumpy = models.replace(".model", ".bump strength 1\n.bump MOV R0, R0\n.model");
  assert.equal(toonShape(bumpy), shape, "a toon shape has no bumps");
  const lines = toonShape(program).split("\n");
  assert.equal(lines.at(-2), "ADD R0, R1, C0");
  assert.equal(lines[3], ".effect light");
  // `exponent` is also a parameter of the effect.
  const text = `${models}.effect light\nby brdf\nexponent 1\n`;
  const edited = withParameters(text, withValue(genomeIn(text).layers, 0, "exponent", [90]));
  assert.equal(edited, text.replace("exponent 30", "exponent 90"));
});
