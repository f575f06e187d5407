// Downloads of several favourites, tags as they are typed, and names of new lineages.

import assert from "node:assert/strict";
import { test } from "node:test";

import { MOST_FILES, archivePath, archiveProblem, isLarge, jobRequest, keyOf } from "../export/archive.js";
import { tagsIn } from "../lineage/listed.js";
import { untitled } from "../lineage/open.js";

test("a download of several materials names its reason if it cannot be made", () => {
  assert.equal(archiveProblem(3, ["brood", "png"], "512"), "");
  assert.equal(archiveProblem(128, ["png"], "512"), "");
  assert.match(archiveProblem(MOST_FILES + 1, ["brood"], "512"), /256/);
  assert.match(archiveProblem(1, [], "512"), /format/);
  assert.equal(archiveProblem(1, ["brood", "wgsl"], "nonsense"), "");
  for (const side of ["", "15", "2049", "12.5", "x"])
    assert.match(archiveProblem(1, ["exr"], side), /16 to 2048/, side);
  assert.match(archiveProblem(64, ["png", "exr"], "1024"), /at most 512 pixels/);
});

test("a download of several materials has a size only if it has pictures", () => {
  assert.equal(
    archivePath({ individuals: ["a", "b"] }, { formats: ["brood", "png"], side: "512", limited: true }),
    "/v1/exports.zip?individuals=a,b&formats=brood,png&size=512&energy_limit=true",
  );
  assert.equal(
    archivePath({ generation: "a" }, { formats: ["wgsl"], side: "512", limited: false }),
    "/v1/exports.zip?generation=a&formats=wgsl&energy_limit=false",
  );
  const content = { formats: ["merl", "exr"], side: "64", limited: true };
  assert.deepEqual(jobRequest({ job: "a" }, content), {
    job: "a", formats: ["merl", "exr"], size: 64, energy_limit: true,
  });
  assert.equal(jobRequest({ job: "a" }, { ...content, formats: ["wgsl"] }).size, undefined);
});

test("a download of many tables is made by a job", () => {
  const known = [
    { name: "merl", media_type: "application/octet-stream" },
    { name: "wgsl", media_type: "text/wgsl" },
  ];
  assert.equal(isLarge(20, ["wgsl", "png"], known), false);
  assert.equal(isLarge(20, ["merl"], known), true);
  assert.equal(isLarge(2, ["merl", "wgsl"], known), false);
  assert.equal(keyOf({ individuals: ["a"] }), "individuals");
  assert.equal(keyOf({ job: "a" }), "job-a");
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
