// Exported programs in a browser.

import { execFile } from "node:child_process";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { promisify } from "node:util";

/** Runs the page of `brood bench export` with random programs; resolves to its result. */
export async function runExports(page, binary, programs) {
  const folder = await mkdtemp(join(tmpdir(), "brood-export-"));
  try {
    const file = join(folder, "export.html");
    const options = ["--programs", String(programs), "--output", file];
    await promisify(execFile)(binary, ["bench", "export", ...options]);
    await page.goto(`file://${file}`);
    await page.waitForFunction(() => document.getElementById("result").textContent.startsWith("{"));
    return JSON.parse(await page.locator("#result").innerText());
  } finally {
    await rm(folder, { recursive: true, force: true });
  }
}
