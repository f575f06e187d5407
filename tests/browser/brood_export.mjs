// Exports of a whole brood and of the front of a search: at once, and by a job.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

import { samples } from "./search.mjs";
import { poster } from "./server.mjs";

/** Runs the journey; `shot` saves a screenshot, `base` is the server's address. */
export async function broodExport(app, step, shot, base) {
  const { page } = app;

  await step("exports a whole brood, large tables by a job that a reload does not end", async () => {
    await app.open();
    await app.ready();
    const menu = app.id("brood-export");
    const saved = async () => {
      const [download] = await Promise.all([
        page.waitForEvent("download"),
        app.id("brood-export-save").click(),
      ]);
      return { name: download.suggestedFilename(), bytes: await readFile(await download.path()) };
    };
    await menu.locator("summary").click();
    await app.id("brood-export-png").uncheck();
    await app.id("brood-export-samples-csv").waitFor();
    const small = await saved();
    assert.match(small.name, /brood\.zip$/);
    assert.ok(small.bytes.includes("manifest.json"), "the manifest");
    await app.id("brood-export-rgl-bsdf").check();
    await menu.scrollIntoViewIfNeeded();
    await shot("34-export-all");
    await app.accessible("export of a brood");
    await app.id("brood-export-start").click();
    await app.id("brood-export-job").filter({ hasText: "of 40 files made" }).waitFor();
    await page.waitForFunction(
      () => document.querySelector("[data-testid=brood-export-job] progress")?.value > 0,
    );
    await menu.scrollIntoViewIfNeeded();
    await shot("34-export-job");
    await page.reload();
    await app.ready();
    await menu.locator("summary").click();
    // Tables are made at the lowest priority.
    await app.id("brood-export-ready").waitFor({ timeout: 600_000 });
    await menu.scrollIntoViewIfNeeded();
    await shot("34-export-ready");
    const large = await saved();
    assert.ok(large.bytes.length > small.bytes.length + 1e6, `${large.bytes.length}`);
    assert.equal(large.bytes.toString("latin1", 0, 2), "PK");
    await app.id("brood-export-forget").click();
    await app.id("brood-export-rgl-bsdf").check();
    await app.id("brood-export-start").click();
    await app.id("brood-export-cancel").click();
    await menu.getByText("The export was cancelled.").waitFor();
    await app.id("brood-export-forget").click();
    await app.id("brood-export-rgl-bsdf").uncheck();
  });

  await step("exports the front of a search, with errors in the manifest", async () => {
    const target = new FormData();
    target.append("spec", JSON.stringify({ kind: "samples", name: "diffuse" }));
    target.append("file", new Blob([samples(600)]));
    const answer = await fetch(`${base}/v1/targets`, { method: "POST", body: target });
    const post = poster(base);
    const { id } = await post("/v1/jobs", {
      kind: "fit",
      target: (await answer.json()).id,
      generations: 3,
      threads: 1,
    });
    await app.open(`#/search/${id}`);
    await app.id("job-state").filter({ hasText: "done" }).waitFor();
    await app.id("front-export").locator("summary").click();
    const [download] = await Promise.all([
      page.waitForEvent("download"),
      app.id("front-export-save").click(),
    ]);
    assert.equal(download.suggestedFilename(), "diffuse-front.zip");
    const bytes = await readFile(await download.path());
    assert.ok(bytes.includes("diffuse-01-"), "the rank is in the names");
    await app.id("front-export").scrollIntoViewIfNeeded();
    await shot("34-export-front");
    await app.accessible("export of a front");
    await page.keyboard.press("Escape");
  });
}
