// The page beside a busy server or a broken connection, with slow uploads and downloads: nothing
// stays broken, and the last choice wins.

import { strict as assert } from "node:assert";

import { slide } from "./live.mjs";
import { poster } from "./server.mjs";

/** A tiny environment picture. */
const SKY = {
  name: "sky.hdr",
  mimeType: "image/vnd.radiance",
  buffer: Buffer.concat([
    Buffer.from("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"),
    Buffer.from(Array(8).fill([90, 110, 140, 128]).flat()),
  ]),
};

/** Holds requests back until `release` is called; resolves `arrived` at the first. */
async function held(page, path) {
  let release, arrived;
  const gate = new Promise((done) => (release = done));
  const came = new Promise((done) => (arrived = done));
  const hold = async (route) => {
    arrived();
    await gate;
    await route.fallback().catch(() => {});
  };
  await page.route(path, hold);
  return {
    came,
    release: async () => {
      release();
      await page.unroute(path, hold);
    },
  };
}

/** Pictures outside the frames that are not loaded. */
const broken = (page) =>
  page.$$eval(
    "[data-testid=history] img, .gallery img, [data-testid=compare-sides] img",
    (all) => all.filter((image) => !image.complete || image.naturalWidth === 0).length,
  );

/** Runs the journey; `shot` saves a screenshot. */
export async function troubled(app, step, shot, base) {
  const { page } = app;
  app.ignores = (text) => ["503", "ERR_FAILED", "ERR_INTERNET_DISCONNECTED", "ERR_ABORTED"].some((known) => text.includes(known));

  await step("asks a busy server again for pictures beside the frames", async () => {
    await app.open();
    await app.becomes(() => app.cell(4).click());
    await app.cell(2).focus();
    await page.keyboard.press("f");
    await page.keyboard.press("b");
    await app.id("compare-sides").waitFor();
    const tries = new Map();
    const busy = (route) => {
      const url = route.request().url();
      const before = tries.get(url) ?? 0;
      tries.set(url, before + 1);
      return before < 2
        ? route.fulfill({ status: 503, headers: { "Retry-After": "1" }, body: "busy" })
        : route.continue();
    };
    const pictures = /\/v1\/(thumbnails\/|individuals\/[^/]+\/render\.png)/;
    await page.route(pictures, busy);
    await page.reload();
    await app.ready();
    await app.id("compare-sides").waitFor();
    await page.waitForFunction(
      () =>
        [...document.querySelectorAll("[data-testid=history] img, .gallery img, [data-testid=compare-sides] img")].length >= 5,
    );
    for (let tried = 0; tried < 100 && (await broken(page)) > 0; tried += 1)
      await page.waitForTimeout(100);
    assert.equal(await broken(page), 0, "pictures stay broken");
    assert.equal(await app.id("error").count(), 0, "nothing is said to be gone");
    await page.unroute(pictures, busy);
    app.complaints = app.complaints.filter((text) => !text.includes("503"));
  });

  await step("shows and stops the upload of a light, and the last choice wins", async () => {
    const first = await held(page, "**/v1/environments");
    await app.id("light-environment").setInputFiles(SKY);
    await first.came;
    await app.id("light-sending").waitFor();
    const spot = await app.reshown(() => app.id("light-kind").selectOption("spot"));
    assert.equal(spot.lights[0].kind, "spot");
    await app.id("light-sending").waitFor({ state: "detached" });
    await first.release();
    const second = await held(page, "**/v1/environments");
    await app.id("light-environment").setInputFiles(SKY);
    await second.came;
    await app.id("light-sending-stop").click();
    await app.id("light-sending").waitFor({ state: "detached" });
    await second.release();
    assert.equal(await app.id("error").count(), 0, "a stopped upload is no error");
    const generation = await app.generation(await app.ready());
    const sceneOf = async () => (await app.api(`/v1/lineages/${generation.lineage}`)).scene;
    assert.equal(await sceneOf(), spot.id, "the older choices are dropped");
    const sky = await app.reshown(() => app.id("light-environment").setInputFiles(SKY));
    assert.deepEqual(
      sky.lights.map(({ kind }) => kind),
      ["spot", "environment"],
    );
    assert.match(sky.lights[1].image, /^[0-9a-f]{64}$/);
    await app.reshown(() => app.id("light-kind").selectOption("point"));
  });

  await step("saves exports of a favourite under names of its lineage, with progress", async () => {
    const favourite = page.locator(".gallery li").first();
    await favourite.hover();
    await favourite.getByTestId("favourite-inspect").click();
    const inspector = app.id("inspector");
    await inspector.getByText("Export", { exact: true }).click();
    const slow = await held(page, "**/exports/**");
    const link = inspector.getByRole("link", { name: /^GLSL ES/ });
    const coming = page.waitForEvent("download");
    await link.click();
    await inspector.getByTestId("export-glsl-es-300-progress").waitFor();
    await shot("45-download");
    await slow.release();
    assert.match((await coming).suggestedFilename(), /^[\p{L}\p{N}-]+-[0-9a-f]{4}\.es300\.glsl$/u);
    await link.waitFor();
    const png = page.waitForEvent("download");
    await inspector.getByTestId("export-png").click();
    assert.match((await png).suggestedFilename(), /^[\p{L}\p{N}-]+-[0-9a-f]{4}\.png$/u);
    const stopped = await held(page, "**/exports/**");
    await inspector.getByRole("link", { name: /^WGSL/ }).click();
    await inspector.getByTestId("export-wgsl-progress").getByRole("button").click();
    await inspector.getByRole("link", { name: /^WGSL/ }).waitFor();
    await stopped.release();
    assert.equal(await inspector.getByRole("alert").count(), 0);
    await app.id("inspector-close").click();
    await inspector.waitFor({ state: "detached" });
  });

  await step("exports what the screen shows", async () => {
    const scene = await app.reshown(() => slide(app, "light", 120));
    await page.getByText("Export", { exact: true }).click();
    const asked = [];
    page.on("request", (request) => asked.push(request.url()));
    for (const id of ["export-png", "export-exr", "export-sheet"]) {
      const coming = page.waitForEvent("download");
      await app.id(id).click();
      await coming;
    }
    const files = asked.filter((url) => /render\.(png|exr)\?size=1024x|sheet\.png/.test(url));
    assert.equal(files.length, 3, asked.join(" "));
    for (const url of files) assert.ok(url.includes(`scene=${scene.id}`), url);
  });

  await step("says before the click that children would be identical", async () => {
    const warning = app.id("twins-warning");
    assert.equal(await warning.count(), 0);
    await slide(app, "mutation", 0);
    assert.match(await warning.innerText(), /^Mutation 0 gives 20 identical children/);
    await shot("46-twins");
    await app.cell(3).click({ button: "right" });
    await warning.waitFor({ state: "detached" });
    await page.keyboard.press("Escape");
    await slide(app, "mutation", 0.3);
    await warning.waitFor({ state: "detached" });
    for (const channel of ["r", "g", "b"]) await app.id(`lock-${channel}`).check();
    assert.match(await warning.innerText(), /^All channels are locked/);
    await app.id("locks-unlock").click();
    await warning.waitFor({ state: "detached" });
  });

  await step("lists the keys, skips to the pictures, and resets the view", async () => {
    await page.locator("body").press("?");
    const help = app.id("help");
    await help.waitFor();
    await shot("47-keys");
    await app.accessible("keys");
    await app.id("help-close").click();
    await help.waitFor({ state: "detached" });
    await app.id("skip").focus();
    await page.keyboard.press("Enter");
    assert.ok(await page.evaluate(() => document.activeElement?.matches("[data-cell]")));
    assert.equal(await app.id("reset-view").count(), 1, "the light was turned");
    const generation = await app.ready();
    const scene = await app.reshown(() => app.id("centre").dblclick());
    assert.deepEqual([scene.light_deg, scene.scale], [0, 1]);
    assert.equal(await app.ready(), generation, "nothing was bred");
    await app.id("reset-view").waitFor({ state: "detached" });
  });

  await step("removes error boxes when the server answers again", async () => {
    const context = page.context();
    await context.setOffline(true);
    await app.cell(5).click();
    await app.id("error").waitFor();
    assert.match(await app.id("error").innerText(), /cannot be reached/);
    await context.setOffline(false);
    await app.id("error").waitFor({ state: "detached" });
    await app.becomes(() => app.cell(5).click());
    app.complaints = app.complaints.filter((text) => !text.includes("ERR_"));
  });
  await step("draws only the visible part of a long history", async () => {
    const post = poster(base);
    const own = await post("/v1/lineages", { name: "a long history", thumbnail_px: 32 });
    let last = await post(`/v1/lineages/${own.id}/generations`, { parents: [], count: 2 });
    for (let index = 1; index < 50; index += 1)
      last = await post(`/v1/lineages/${own.id}/generations`, {
        parents: [last.individuals[0].id],
        count: 2,
      });
    await page.goto("about:blank");
    await app.open(`#/lineage/${own.id}`);
    await app.id("history-49").waitFor();
    const drawn = () => app.id("history").locator("li").count();
    assert.ok((await drawn()) < 45, `${await drawn()} generations are drawn`);
    assert.equal(await app.id("history-0").count(), 0);
    await app.id("history").evaluate((strip) => strip.scrollTo({ left: 0, behavior: "instant" }));
    await app.id("history-3").click();
    await app.id("history-3").and(page.locator("[aria-current]")).waitFor();
    assert.ok((await drawn()) < 45, `${await drawn()} generations are drawn`);
  });

  app.quiet();
}
