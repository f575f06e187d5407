/** Refusals of pictures. */
import assert from "node:assert/strict";
import { afterEach, test } from "node:test";
import { refusalOf } from "../api/request.js";

const fetchOfNode = globalThis.fetch;

afterEach(() => {
  globalThis.fetch = fetchOfNode;
});

/** @param {() => Promise<Response>} answer */
const answering = (answer) => {
  globalThis.fetch = answer;
  return refusalOf("/v1/thumbnails/x.png");
};

test("a refusal has the reason of the server", async () => {
  const problem = JSON.stringify({ detail: "it has 9 lights", status: 422 });
  assert.equal(await answering(async () => new Response(problem, { status: 422 })), "it has 9 lights");
  assert.match((await answering(async () => new Response("x", { status: 404 }))) ?? "", /404/);
});

test("a picture that comes, or may come later, is not refused", async () => {
  for (const status of [200, 401, 403, 429, 500, 503])
    assert.equal(await answering(async () => new Response("x", { status })), null);
  assert.equal(await answering(() => Promise.reject(new TypeError("no network"))), null);
});
