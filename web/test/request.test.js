import assert from "node:assert/strict";
import test from "node:test";

import { post } from "../api/request.js";

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

test("a server that is away is asked again each second", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  let tries = 0;
  const send = async () => {
    tries += 1;
    // A proxy without a server.
    return new Response("{}", { status: tries === 9 ? 200 : 503 });
  };
  const answer = post("/v1/lineages", { json: {}, send });
  const waits = [];
  while (tries < 9) {
    const before = tries;
    // Lets the answer arrive, and the next timer start.
    await new Promise((done) => setImmediate(done));
    let ms = 0;
    while (tries === before) {
      context.mock.timers.tick(50);
      ms += 50;
      await new Promise((done) => setImmediate(done));
    }
    waits.push(ms);
  }
  assert.equal((await answer).status, 200);
  assert.deepEqual(waits, [500, ...Array(7).fill(1000)]);
});
