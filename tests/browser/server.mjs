// A real server for the journeys: the built binary on a free port with its own data directory.

import { spawn } from "node:child_process";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("../..", import.meta.url));
const PREFIX = "brood is listening on ";
const START_TIMEOUT_MS = 60_000;

/** Path of the program under test. */
export const binary = process.env.BROOD_BIN ?? join(root, "target/debug/brood");

/** Posts JSON to a server and resolves to its answer. @param {string} base */
export const poster = (base) => async (path, json) => {
  const answer = await fetch(`${base}${path}`, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(json),
  });
  if (!answer.ok) throw new Error(`${path}: ${await answer.text()}`);
  return answer.json();
};

/**
 * Starts `$BROOD_BIN`, or target/debug/brood, and resolves when it listens.
 * @param {string[]} more options of `brood serve`
 */
export async function startServer(more = []) {
  const data = await mkdtemp(join(tmpdir(), "brood-journey-"));
  const options = [
    "serve",
    ...(process.env.BROOD_WEB ? ["--web-dir", process.env.BROOD_WEB] : []),
    "--listen",
    "127.0.0.1:0",
    "--data",
    data,
    "--workers",
    "1",
    "--backend",
    "cpu",
    ...more,
  ];
  const child = spawn(binary, options, { stdio: ["ignore", "pipe", "pipe"] });
  let log = "";
  child.stderr.on("data", (bytes) => (log += bytes));
  const ended = new Promise((resolve) => child.once("exit", resolve));

  const url = await new Promise((resolve, reject) => {
    const late = setTimeout(
      () => reject(new Error(`the server does not listen; its log:\n${log}`)),
      START_TIMEOUT_MS,
    );
    const failed = (why) => {
      clearTimeout(late);
      reject(new Error(`${why}; run cargo xtask test, or cargo build first\n${log}`));
    };
    child.once("error", (error) => failed(`${binary} cannot be started: ${error.message}`));
    child.once("exit", (code) => failed(`the server ended with ${code}`));
    createInterface({ input: child.stdout }).on("line", (line) => {
      if (line.startsWith(PREFIX)) {
        clearTimeout(late);
        resolve(line.slice(PREFIX.length));
      }
    });
  });

  return {
    url,
    log: () => log,
    async stop() {
      child.kill("SIGTERM");
      const code = await ended;
      await rm(data, { recursive: true, force: true });
      return code;
    },
  };
}
