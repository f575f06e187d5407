/** Images of painted materials: places, words, reading; genomes with an image set or removed. */
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  imageIn, imageInLine, imageName, percent, placeInWords, placeKey, placesOf, withImage, withoutImage,
} from "../lineage/images.js";
import { genomeIn, locksFor } from "../lineage/layers.js";
import { onlyTwinsInWords } from "../lineage/locks.js";
import { noLocks } from "../lineage/store.js";

const ID = "ab".repeat(32);
const OTHER = "cd".repeat(32);

const PAINTED = genomeIn(`brood 1
.model lambert
albedo 0.3 0.13 0.05
.effect light
palette #2b1e46 #f2a65a
by brdf
brush 0
dark ${ID} 0.8
map ${OTHER} 1
.effect glass
color #1f4e5f
`);

/** @returns {import("../model.js").GenomeJson} */
const json = () =>
  /** @type {any} */ ({
    limit: true,
    effects: [
      { kind: "light", parameters: { palette: ["#2b1e46", "#f2a65a"], brush: 0 } },
      { kind: "silhouette", parameters: { color: "#1a1020" } },
    ],
  });

test("images are read from a genome's text apart from parameters", () => {
  const [light, glass] = PAINTED.effects;
  assert.deepEqual(light.images, [
    { name: "dark", image: ID, share: 0.8 },
    { name: "map", image: OTHER, share: 1 },
  ]);
  assert.deepEqual(light.parameters.map(({ name }) => name), ["palette", "by", "brush"]);
  assert.deepEqual(glass.images, []);
  assert.deepEqual(imageInLine(`map ${ID}`), { name: "map", image: ID, share: 1 });
  for (const line of ["palette #2b1e46", "brush 0.5", "map abc", `map ${ID}0`])
    assert.equal(imageInLine(line), null, line);
  assert.equal(imageIn(PAINTED.effects, { effect: "light", name: "map" })?.image, OTHER);
  assert.equal(imageIn(PAINTED.effects, { effect: "glass", name: "map" }), null);
  assert.equal(imageIn(PAINTED.effects, { effect: "silhouette", name: "map" }), null);
});

test("each effect has its places, in words", () => {
  assert.deepEqual(placesOf(PAINTED.effects).map(placeInWords), [
    "dark colour of the light",
    "bright colour of the light",
    "brush of the light",
    "strength of the glass",
  ]);
  const others = ["silhouette", "highlight", "distance"].map((effect) => ({ effect }));
  assert.deepEqual(placesOf(others).map(placeKey), [
    "silhouette.image",
    "silhouette.map",
    "highlight.image",
    "highlight.map",
    "distance.image",
    "distance.map",
  ]);
  assert.equal(placeInWords({ effect: "distance", name: "image" }), "colour of the distance");
  assert.deepEqual(placesOf([{ effect: "unknown" }]), []);
  assert.deepEqual(["dark", "bright", "map", "image"].map(imageName), [
    "dark image",
    "bright image",
    "map",
    "image",
  ]);
  assert.equal(percent(0.805), "81 %");
});

test("a genome gets an image in one place, and keeps all else", () => {
  const of = json();
  const set = withImage(of, { effect: "silhouette", name: "image" }, { image: ID, share: 0.5 });
  assert.deepEqual(set, {
    ...of,
    effects: [
      of.effects?.[0],
      { kind: "silhouette", parameters: { color: "#1a1020", image: { image: ID, share: 0.5 } } },
    ],
  });
  assert.deepEqual(of, json(), "the genome itself is not changed");
  assert.deepEqual(withoutImage(set, { effect: "silhouette", name: "image" }), of);
  assert.deepEqual(withoutImage(of, { effect: "silhouette", name: "image" }), of);
});

test("a map of the light gets a brush unless there is one", () => {
  const place = { effect: "light", name: "map" };
  const image = { image: ID, share: 1 };
  const brushOf = (/** @type {any} */ of) => of.effects[0].parameters.brush;
  assert.equal(brushOf(withImage(json(), place, image)), 0.5);
  assert.equal(brushOf(withImage(json(), { ...place, name: "dark" }, image)), 0);
  const brushed = /** @type {any} */ (json());
  brushed.effects[0].parameters.brush = 0.2;
  assert.equal(brushOf(withImage(brushed, place, image)), 0.2);
  delete brushed.effects[0].parameters.brush;
  assert.equal(brushOf(withImage(brushed, place, image)), 0.5);
});

test("images are locked like parameters", () => {
  const locks = {
    ...noLocks(),
    effect_parameters: [
      { effect: "light", name: "dark" },
      { effect: "light", name: "bright" },
      { effect: "glass", name: "map" },
    ],
  };
  const { kept, gone } = locksFor(locks, PAINTED);
  assert.deepEqual(kept.effect_parameters, [{ effect: "light", name: "dark" }]);
  assert.deepEqual(gone, ["bright image of light", "map of glass"]);
  const [light] = PAINTED.effects;
  const named = [...light.parameters, ...light.images];
  const all = {
    ...noLocks(),
    layers: [0],
    effects: ["glass"],
    effect_parameters: named.map(({ name }) => ({ effect: "light", name })),
  };
  const of = { mutation: 0.3, recombination: 0.5, hasMate: false, genome: PAINTED, recoloured: false };
  assert.match(onlyTwinsInWords({ ...of, locks: all }), /Everything is locked/);
  const fewer = { ...all, effect_parameters: all.effect_parameters.slice(0, -1) };
  assert.equal(onlyTwinsInWords({ ...of, locks: fewer }), "");
});
