// Downloads of several favourites, tags as they are typed, and names of new lineages.

import assert from "node:assert/strict";
import { test } from "node:test";

import { MOST_FILES, archivePath, archiveProblem } from "../favourites/chosen.js";
import { tagsIn } from "../lineage/listed.js";
import { untitled } from "../lineage/open.js";

test("a download of several materials names its reason if it cannot be made", () => {
  assert.equal(archiveProblem(3, ["brood", "png"], "512"), "");
  assert.equal(archiveProblem(MOST_FILES, ["png"], "512"), "");
  assert.match(archiveProblem(MOST_FILES + 1, ["brood"], "512"), /128/);
  assert.match(archiveProblem(1, [], "512"), /format/);
  assert.equal(archiveProblem(1, ["brood", "wgsl"], "nonsense"), "");
  for (const side of ["", "15", "2049", "12.5", "x"])
    assert.match(archiveProblem(1, ["exr"], side), /16 to 2048/, side);
  assert.match(archiveProblem(64, ["png", "exr"], "1024"), /at most 512 pixels/);
});

test("a download of several materials has a size only if it has pictures", () => {
  assert.equal(
    archivePath(["a", "b"], ["brood", "png"], "512", true),
    "/v1/exports.zip?individuals=a,b&formats=brood,png&size=512&energy_limit=true",
  );
  assert.equal(
    archivePath(["a"], ["wgsl"], "512", false),
    "/v1/exports.zip?individuals=a&formats=wgsl&energy_limit=false",
  );
});

test("tags are separated by commas and kept once", () => {
  assert.deepEqual(tagsIn(" gold, car  paint,,GOLD , "), ["gold", "car paint"]);
  assert.deepEqual(tagsIn(""), []);
});

test("a new lineage has the first number that is free", () => {
  assert.equal(untitled([]), "Untitled 1");
  assert.equal(untitled([{ name: "Untitled 1" }, { name: "gold" }]), "Untitled 2");
  assert.equal(untitled([{ name: "Untitled 2" }]), "Untitled 1");
});
