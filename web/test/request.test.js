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
