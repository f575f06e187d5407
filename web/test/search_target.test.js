/** The target of a search being asked for: files become uploads, and what was read before does not stay to mislead. */
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { draft, fill } from "../search_draft.js";
import {
  addPictures, aside, changeView, chooseTarget, isStale, readAs, readPictures, removeView, sending, stopSending, takeScene, takeTargets, takeUpAgain, targets, wrongView,
} from "../search_target.js";
import { troubles } from "../state.js";

/** @type {{specs: any[], parts: string[][], deleted: string[], answer: (spec: any) => any, hold: boolean}} */
const server = { specs: [], parts: [], deleted: [], answer: () => null, hold: false };

/** The server as it is uploaded to. */
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
    this.response = new Blob([JSON.stringify(refused ?? { id: `t-${server.specs.length}`, kind: spec.kind, name: spec.name, views: spec.views ?? [] })]);
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
/** Until nothing is on its way. */
async function settled() {
  do await new Promise((next) => setTimeout(next, 5));
  while (sending.value);
}
const trouble = () => troubles.value.target?.problem.detail ?? "";

beforeEach(() => {
  Object.assign(server, { specs: [], parts: [], deleted: [], answer: () => null, hold: false });
  stopSending();
  fill({ file: null, kind: "", views: [], target: null, own: null });
  [targets.value, troubles.value, isStale.value, aside.value, wrongView.value] = [[], {}, false, null, null];
});

test("a measured file is read at once, and read as another kind it is a target in the place of the first", async () => {
  await takeTargets([file("gold.exr")]);
  await settled();
  assert.deepEqual(server.specs, [{ kind: "slice", name: "gold" }]);
  assert.equal(draft.value.target?.id, "t-1");
  readAs("image");
  assert.equal(draft.value.target, null);
  assert.deepEqual(targets.value, [], "it is not offered any more");
  await settled();
  assert.deepEqual(server.deleted, ["/v1/targets/t-1"]);
  assert.equal(server.specs.length, 1, "a picture waits for its scene");
  readPictures();
  await settled();
  assert.equal(server.specs[1].kind, "image");
  assert.deepEqual(server.parts[1], ["picture-0"]);
  assert.equal(draft.value.target?.id, "t-2");
});

test("what was said of pictures outlives another kind, another target, and a refusal", async () => {
  await takeTargets([file("a.exr")]);
  readAs("image");
  changeView(draft.value.views[0].key, { light: "33", text: "{" });
  readAs("slice");
  readAs("image");
  assert.deepEqual([draft.value.views[0].light, draft.value.views[0].text], ["33", "{"]);
  chooseTarget(/** @type {any} */ ({ id: "t-9", kind: "merl" }));
  assert.deepEqual([draft.value.target?.id, draft.value.file], ["t-9", null]);
  takeUpAgain();
  assert.equal(draft.value.views[0].light, "33");
  assert.equal(draft.value.target, null);
  server.answer = () => ({ title: "Refused", status: 422, detail: "the mask is empty", pointer: "/views/0/mask" });
  readPictures();
  await settled();
  assert.deepEqual(wrongView.value, { view: 0, field: "mask" });
  assert.match(trouble(), /mask is empty/);
  assert.equal(draft.value.views[0].light, "33");
});

test("pictures are gathered, and a change after they were read asks for reading again", async () => {
  await takeTargets([file("a.png"), file("b.exr")]);
  await takeTargets([file("c.hdr")]);
  assert.deepEqual(draft.value.views.map((one) => one.file.name), ["a.png", "b.exr", "c.hdr"]);
  readPictures();
  await settled();
  assert.equal(draft.value.own, "t-1");
  changeView(draft.value.views[1].key, { held_out: true });
  assert.ok(isStale.value && draft.value.target === null);
  assert.deepEqual(server.deleted, []);
  readPictures();
  await settled();
  assert.deepEqual([draft.value.target?.id, server.deleted], ["t-2", ["/v1/targets/t-1"]]);
  assert.equal(isStale.value, false);
  for (const { key } of draft.value.views) removeView(key);
  assert.deepEqual([draft.value.kind, draft.value.file], ["", null]);
});

test("a scene's file is for the pictures without one", async () => {
  await takeTargets([file("scene.json", "{}")]);
  assert.match(trouble(), /choose the picture first/);
  await takeTargets([file("a.png"), file("b.png"), file("scene.json", '{"mesh":"knob"}')]);
  assert.deepEqual(draft.value.views.map(({ from, text }) => [from, text]), [["given", '{"mesh":"knob"}'], ["given", '{"mesh":"knob"}']]);
  await takeScene(file("other.json", "{}"), draft.value.views[1].key);
  assert.deepEqual(draft.value.views.map(({ text }) => text), ['{"mesh":"knob"}', "{}"]);
});

test("a list of the command line's brings its pictures with their scenes and masks", async () => {
  const list = { views: [
    { picture: "left.exr", scene: "left.json", mask: "m/mask.png", gain: true }, { picture: "right.png", scene: { mesh: "knob" }, samples: 16, held_out: true },
  ] };
  const json = file("list.json", JSON.stringify(list));
  await takeTargets([json, file("left.exr"), file("mask.png"), file("right.png")]);
  assert.match(trouble(), /left\.json is the scene of left\.exr/);
  await takeTargets([json, file("left.exr"), file("mask.png"), file("right.png"), file("left.json", '{"mesh":"cube"}')]);
  assert.deepEqual(draft.value.views.map((of) => [of.file.name, JSON.parse(of.text), of.mask?.name, of.samples, of.gain, of.held_out]), [
    ["left.exr", { mesh: "cube" }, "mask.png", "adaptive", true, false], ["right.png", { mesh: "knob" }, undefined, "16", false, true],
  ]);
});

test("what cannot be taken together is refused with its reason, and nothing is sent", async () => {
  await takeTargets([file("a.csv"), file("b.csv")]);
  assert.match(trouble(), /2 files/);
  addPictures(Array.from({ length: 17 }, (_, at) => file(`${at}.png`)));
  assert.match(trouble(), /at most 16 pictures/);
  const large = /** @type {any} */ ({ name: "large.csv", size: 70 * 2 ** 20 });
  await takeTargets([large]);
  assert.match(trouble(), /70 MiB/);
  assert.deepEqual([server.specs, draft.value.file], [[], null]);
});

test("an upload that is stopped leaves the file to be sent again, and no trouble", async () => {
  server.hold = true;
  await takeTargets([file("gold.csv")]);
  assert.deepEqual(sending.value, { sent: 0, whole: 1 });
  stopSending();
  await settled();
  assert.deepEqual([draft.value.file?.name, draft.value.target, trouble()], ["gold.csv", null, ""]);
});
