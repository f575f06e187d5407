import assert from "node:assert/strict";
import test from "node:test";

import { post, request } from "../api/request.js";

test("a proxy's answer for a lost server is repeated with the same key", async () => {
  const keys = [];
  const send = async (_, { headers }) => {
    keys.push(headers["Idempotency-Key"]);
    return new Response("{}", { status: keys.length === 1 ? 502 : 200 });
  };
  const response = await post("/v1/lineages", { json: {}, send });
  assert.equal(response.status, 200);
  assert.equal(keys.length, 2);
  assert.equal(keys[0], keys[1]);
});

/**
 * Lets a request run with the clock of a test. Returns the time until its end in milliseconds.
 * @param {import("node:test").TestContext} context
 * @param {() => Promise<unknown>} start
 */
async function clocked(context, start) {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  let ms = 0;
  context.mock.method(performance, "now", () => ms);
  let ended = false;
  const answer = start().finally(() => (ended = true));
  answer.catch(() => {});
  for (;;) {
    // Lets the answer arrive, and the next timer start.
    await new Promise((done) => setImmediate(done));
    if (ended) break;
    context.mock.timers.tick(50);
    ms += 50;
  }
  return { ms, answer };
}

test("a server that is away is asked again each second", async (context) => {
  for (const isRefused of [true, false]) {
    let tries = 0;
    const send = async () => {
      tries += 1;
      if (tries === 9) return new Response("{}");
      if (!isRefused) throw new TypeError("connection refused");
      // A proxy without a server.
      return new Response("", { status: 503 });
    };
    const { ms, answer } = await clocked(context, () => post("/v1/lineages", { json: {}, send }));
    assert.equal((await answer).status, 200);
    assert.equal(ms, 500 + 7 * 1000);
    context.mock.reset();
  }
});

test("a busy server is asked five times", async (context) => {
  let tries = 0;
  const send = async () => {
    tries += 1;
    return new Response("{}", { status: 503, headers: { "Retry-After": "5" } });
  };
  const { ms, answer } = await clocked(context, () => post("/v1/lineages", { json: {}, send }));
  await assert.rejects(answer);
  assert.deepEqual([tries, ms], [5, 4 * 5000]);
});

test("only a conflict with an attempt that still runs is repeated", async (context) => {
  for (const [type, expected] of [
    ["/problems/still-running", 2],
    ["/problems/conflict", 1],
  ]) {
    let tries = 0;
    const send = async () => {
      tries += 1;
      return new Response(JSON.stringify({ type }), { status: tries === 1 ? 409 : 200 });
    };
    await (await clocked(context, () => post("/v1/jobs", { json: {}, send }))).answer.catch(() => {});
    assert.equal(tries, expected);
    context.mock.reset();
  }
});

test("a DELETE whose answer was lost succeeds when it is repeated", async (context) => {
  const remove = async (first) => {
    let tries = 0;
    const send = async () => new Response(null, { status: (tries += 1) === 1 ? first : 404 });
    const { answer } = await clocked(context, () => request("DELETE", "/v1/targets/a", { send }));
    context.mock.reset();
    return answer;
  };
  assert.equal(await remove(502), null);
  await assert.rejects(remove(404));
});
