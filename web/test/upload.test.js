/** Uploads with progress that can be stopped. */
import assert from "node:assert/strict";
import { afterEach, beforeEach, test } from "node:test";
import { request } from "../api/request.js";
import { sendingBy, wasStopped } from "../api/upload.js";

/** Stands for XMLHttpRequest; the test answers. */
class Fake extends EventTarget {
  /** @type {Fake[]} */
  static all = [];
  upload = new EventTarget();
  status = 0;
  statusText = "";
  response = new Blob();
  /** @type {Record<string, string>} */
  headers = {};
  constructor() {
    super();
    Fake.all.push(this);
  }
  /** @param {string} method @param {string} path */
  open(method, path) {
    this.asked = `${method} ${path}`;
  }
  /** @param {string} name @param {string} value */
  setRequestHeader(name, value) {
    this.headers[name] = value;
  }
  getAllResponseHeaders() {
    return "content-type: application/problem+json\r\nretry-after: 0\r\n";
  }
  send() {}
  abort() {
    this.dispatchEvent(new Event("abort"));
  }
  /** @param {number} status @param {unknown} json */
  answer(status, json) {
    this.status = status;
    this.response = new Blob([JSON.stringify(json)]);
    this.dispatchEvent(new Event("load"));
    this.dispatchEvent(new Event("loadend"));
  }
}

const before = globalThis.XMLHttpRequest;
beforeEach(() => {
  Fake.all = [];
  globalThis.XMLHttpRequest = /** @type {any} */ (Fake);
});
afterEach(() => {
  globalThis.XMLHttpRequest = before;
});

/** @param {AbortController} [stopping] */
function sending(stopping = new AbortController()) {
  /** @type {[number, number][]} */
  const told = [];
  const send = sendingBy({
    progress: (sent, whole) => told.push([sent, whole]),
    signal: stopping.signal,
  });
  return { told, stopping, done: request("POST", "/v1/targets", { body: new FormData(), send }) };
}

test("an upload reports progress and returns the server's answer", async () => {
  const { told, done } = sending();
  const [sent] = Fake.all;
  sent.upload.dispatchEvent(Object.assign(new Event("progress"), { loaded: 3, total: 10 }));
  sent.answer(201, { id: "t-1" });
  assert.deepEqual(await done, { id: "t-1" });
  assert.deepEqual(told, [[3, 10]]);
  assert.equal(sent.asked, "POST /v1/targets");
  assert.ok(sent.headers["Idempotency-Key"]);
});

test("a refused upload is a problem, and a temporary one is retried", async () => {
  const { done } = sending();
  Fake.all[0].answer(503, {});
  while (Fake.all.length < 2) await new Promise((next) => setTimeout(next));
  Fake.all[1].answer(422, {
    title: "Refused",
    status: 422,
    detail: "not square",
    pointer: "/views/0/picture",
  });
  await assert.rejects(
    done,
    (/** @type {any} */ error) => error.problem.pointer === "/views/0/picture",
  );
  assert.equal(Fake.all[0].headers["Idempotency-Key"], Fake.all[1].headers["Idempotency-Key"]);
});

test("a stopped upload is not retried", async () => {
  const { done, stopping } = sending();
  stopping.abort();
  await assert.rejects(done, wasStopped);
  assert.equal(Fake.all.length, 1);
  await assert.rejects(sending(stopping).done, wasStopped);
  assert.equal(Fake.all.length, 1, "nor begun");
});
