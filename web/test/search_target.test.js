/** Target of a new search: uploads, replacement, refusals. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { pageStore } from "../page/store.js";
import { updateDraft } from "../search/draft.js";
import { searchStore } from "../search/store.js";
import {
  addPictures, addTargetFiles, changeView, chooseTarget, readAs, readPictures, removeView,
  restoreSetAside, stopSending, useSceneFile,
} from "../search/target.js";

/**
 * @type {{specs: any[], parts: string[][], deleted: string[], answer: (spec: any) => any, hold:
 *   boolean}}
 */
const server = { specs: [], parts: [], deleted: [], answer: () => null, hold: false };

/** Stands for the server that receives the uploads. */
class Fake extends EventTarget {
  upload = new EventTarget();
  status = 0;
  statusText = "";
  response = new Blob();
  open() {}
  setRequestHeader() {}
  getAllResponseHeaders() {
    return "";
  }
  /** @param {FormData} body */
  send(body) {
    const spec = JSON.parse(String(body.get("spec")));
    server.specs.push(spec);
    server.parts.push([...body.keys()].filter((name) => name !== "spec"));
    if (server.hold) return;
    const refused = server.answer(spec);
    this.status = refused ? 422 : 201;
    this.response = new Blob([
      JSON.stringify(
        refused ?? {
          id: `t-${server.specs.length}`,
          kind: spec.kind,
          name: spec.name,
          views: spec.views ?? [],
        },
      ),
    ]);
    setTimeout(() => this.dispatchEvent(new Event("load")));
  }
  abort() {
    this.dispatchEvent(new Event("abort"));
  }
}
globalThis.XMLHttpRequest = /** @type {any} */ (Fake);
globalThis.fetch = async (path, init) => {
  if (init?.method === "DELETE") server.deleted.push(String(path));
  return new Response(null, { status: 204 });
};

/** @param {string} name @param {string} [text] */
const file = (name, text = "x") => new File([text], name);
/** Waits until no upload is running. */
async function settled() {
  do await new Promise((next) => setTimeout(next, 5));
  while (searchStore.upload.value);
}
const trouble = () => pageStore.problems.value.target?.problem.detail ?? "";

beforeEach(() => {
  Object.assign(server, { specs: [], parts: [], deleted: [], answer: () => null, hold: false });
  stopSending();
  updateDraft({ file: null, kind: "", views: [], target: null, own: null });
  [
    searchStore.targets.value,
    pageStore.problems.value,
    searchStore.picturesChanged.value,
    searchStore.setAside.value,
    searchStore.wrongPicture.value,
  ] = [[], {}, false, null, null];
});

test("a measured file is read at once, and its target is replaced when read as another kind", async () => {
  await addTargetFiles([file("gold.exr")]);
  await settled();
  assert.deepEqual(server.specs, [{ kind: "slice", name: "gold" }]);
  assert.equal(searchStore.draft.value.target?.id, "t-1");
  readAs("image");
  assert.equal(searchStore.draft.value.target, null);
  assert.deepEqual(searchStore.targets.value, [], "it is not offered any more");
  await settled();
  assert.deepEqual(server.deleted, ["/v1/targets/t-1"]);
  assert.equal(server.specs.length, 1, "a picture waits for its scene");
  readPictures();
  await settled();
  assert.equal(server.specs[1].kind, "image");
  assert.deepEqual(server.parts[1], ["picture-0"]);
  assert.equal(searchStore.draft.value.target?.id, "t-2");
});

test("settings of pictures survive another kind, another target, and a refusal", async () => {
  await addTargetFiles([file("a.exr")]);
  readAs("image");
  changeView(searchStore.draft.value.views[0].key, { light: "33", text: "{" });
  readAs("slice");
  readAs("image");
  assert.deepEqual(
    [searchStore.draft.value.views[0].light, searchStore.draft.value.views[0].text],
    ["33", "{"],
  );
  chooseTarget(/** @type {any} */ ({ id: "t-9", kind: "merl" }));
  assert.deepEqual(
    [searchStore.draft.value.target?.id, searchStore.draft.value.file],
    ["t-9", null],
  );
  restoreSetAside();
  assert.equal(searchStore.draft.value.views[0].light, "33");
  assert.equal(searchStore.draft.value.target, null);
  server.answer = () => ({
    title: "Refused",
    status: 422,
    detail: "the mask is empty",
    pointer: "/views/0/mask",
  });
  readPictures();
  await settled();
  assert.deepEqual(searchStore.wrongPicture.value, { view: 0, field: "mask" });
  assert.match(trouble(), /mask is empty/);
  assert.equal(searchStore.draft.value.views[0].light, "33");
});

test("pictures are collected, and must be read again after a change", async () => {
  await addTargetFiles([file("a.png"), file("b.exr")]);
  await addTargetFiles([file("c.hdr")]);
  assert.deepEqual(
    searchStore.draft.value.views.map((one) => one.file.name),
    ["a.png", "b.exr", "c.hdr"],
  );
  readPictures();
  await settled();
  assert.equal(searchStore.draft.value.own, "t-1");
  changeView(searchStore.draft.value.views[1].key, { held_out: true });
  assert.ok(searchStore.picturesChanged.value && searchStore.draft.value.target === null);
  assert.deepEqual(server.deleted, []);
  readPictures();
  await settled();
  assert.deepEqual(
    [searchStore.draft.value.target?.id, server.deleted],
    ["t-2", ["/v1/targets/t-1"]],
  );
  assert.equal(searchStore.picturesChanged.value, false);
  for (const { key } of searchStore.draft.value.views) removeView(key);
  assert.deepEqual([searchStore.draft.value.kind, searchStore.draft.value.file], ["", null]);
});

test("a scene's file applies to pictures without a scene of their own", async () => {
  await addTargetFiles([file("scene.json", "{}")]);
  assert.match(trouble(), /choose the picture first/);
  await addTargetFiles([file("a.png"), file("b.png"), file("scene.json", '{"mesh":"knob"}')]);
  assert.deepEqual(
    searchStore.draft.value.views.map(({ from, text }) => [from, text]),
    [
      ["given", '{"mesh":"knob"}'],
      ["given", '{"mesh":"knob"}'],
    ],
  );
  await useSceneFile(file("other.json", "{}"), searchStore.draft.value.views[1].key);
  assert.deepEqual(
    searchStore.draft.value.views.map(({ text }) => text),
    ['{"mesh":"knob"}', "{}"],
  );
});

test("a JSON list adds its pictures with their scenes and masks", async () => {
  const list = {
    views: [
      { picture: "left.exr", scene: "left.json", mask: "m/mask.png", gain: true },
      { picture: "right.png", scene: { mesh: "knob" }, samples: 16, held_out: true },
    ],
  };
  const json = file("list.json", JSON.stringify(list));
  await addTargetFiles([json, file("left.exr"), file("mask.png"), file("right.png")]);
  assert.match(trouble(), /left\.json is the scene of left\.exr/);
  await addTargetFiles([
    json,
    file("left.exr"),
    file("mask.png"),
    file("right.png"),
    file("left.json", '{"mesh":"cube"}'),
  ]);
  assert.deepEqual(
    searchStore.draft.value.views.map((of) => [
      of.file.name,
      JSON.parse(of.text),
      of.mask?.name,
      of.samples,
      of.gain,
      of.held_out,
    ]),
    [
      ["left.exr", { mesh: "cube" }, "mask.png", "adaptive", true, false],
      ["right.png", { mesh: "knob" }, undefined, "16", false, true],
    ],
  );
});

test("files that cannot be combined are refused with a reason, and nothing is sent", async () => {
  await addTargetFiles([file("a.csv"), file("b.csv")]);
  assert.match(trouble(), /2 files/);
  addPictures(Array.from({ length: 17 }, (_, at) => file(`${at}.png`)));
  assert.match(trouble(), /at most 16 pictures/);
  const large = /** @type {any} */ ({ name: "large.csv", size: 70 * 2 ** 20 });
  await addTargetFiles([large]);
  assert.match(trouble(), /70 MiB/);
  assert.deepEqual([server.specs, searchStore.draft.value.file], [[], null]);
});

test("a stopped upload keeps the file and shows no problem", async () => {
  server.hold = true;
  await addTargetFiles([file("gold.csv")]);
  assert.deepEqual(searchStore.upload.value, { sent: 0, whole: 1 });
  stopSending();
  await settled();
  assert.deepEqual(
    [searchStore.draft.value.file?.name, searchStore.draft.value.target, trouble()],
    ["gold.csv", null, ""],
  );
});
