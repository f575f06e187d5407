// Searches: from a file of samples to a result that is bred from; bad files, pause, resume and
// cancel.

import { strict as assert } from "node:assert";

/**
 * Samples of a diffuse material with two lobes around the half vector and a few percent of noise,
 * as in measurements: an exact target would have a front of one.
 */
export function samples(count) {
  let state = 7;
  const draw = () => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648;
  const direction = () => {
    const [z, turn] = [0.15 + 0.8 * draw(), 2 * Math.PI * draw()];
    return [Math.sqrt(1 - z * z) * Math.cos(turn), Math.sqrt(1 - z * z) * Math.sin(turn), z];
  };
  const rows = Array.from({ length: count }, () => {
    const [wi, wo] = [direction(), direction()];
    const half = wi.map((value, at) => value + wo[at]);
    const cos = half[2] / Math.hypot(...half);
    const values = [0.3, 0.2, 0.1].map(
      (albedo) => (albedo / Math.PI + 0.4 * cos ** 120 + 0.2 * cos ** 8) * (0.975 + 0.05 * draw()),
    );
    return [...wi, ...wo, ...values].join();
  });
  return ["wix,wiy,wiz,wox,woy,woz,r,g,b", ...rows].join("\n");
}

const GENERATIONS = 3;

const file = (name, text) => ({ name, mimeType: "text/csv", buffer: Buffer.from(text) });
const GOOD = file("lobe.csv", samples(600));
const BAD = file("bad.csv", samples(600).replace(/[^\n]*$/, "0,0,1,0,0,1,nan,1,1"));

/** Waits for a state of the search that is looked at. */
const stands = (app, words) => app.id("job-state").filter({ hasText: words }).waitFor();

/** Id of the search in the address. */
const present = (app) => app.api(`/v1/jobs/${/search\/([^/]+)$/.exec(app.page.url())[1]}`);

/** Fills the required fields of the form, and starts. */
async function start(app, generations) {
  await app.page.getByRole("radio", { name: "generations" }).check();
  await app.id("search-budget").fill(String(generations));
  await app.id("search-start").click();
  await app.id("job-state").waitFor();
}

/** Runs the journey; `shot` saves a screenshot. */
export async function search(app, step, shot, base) {
  const { page } = app;
  const dialog = app.id("searches-dialog");
  app.ignores = (text) => text.includes("422");

  await step("opens the searches by key, and explains them", async () => {
    await app.open();
    await page.keyboard.press("s");
    await dialog.waitFor();
    await page.getByText("A search breeds by machine").waitFor();
    await shot("50-searches-none");
    await app.accessible("no searches");
    await dialog.getByRole("button", { name: "New search" }).first().click();
    await app.id("target-file").waitFor({ state: "attached" });
    assert.equal(await page.evaluate(() => document.activeElement?.id), "searches-title");
    assert.ok(await app.id("search-start").isDisabled(), "there is nothing to match yet");
  });

  await step("explains what is wrong with a bad file, and keeps the form", async () => {
    await app.id("search-seed").fill("5");
    await app.id("target-file").setInputFiles(BAD);
    const error = page.locator("[data-testid=error][data-place=target]");
    await error.filter({ hasText: "row 600" }).waitFor();
    assert.equal(await app.id("search-seed").inputValue(), "5");
    assert.ok(await app.id("search-start").isDisabled());
    await shot("51-search-bad-file");
    await app.id("target-file").setInputFiles(file("unnamed.dat", samples(600)));
    await app.id("target-kind").selectOption("samples");
    await app.id("target-understood").waitFor();
    assert.equal(await error.count(), 0);
  });

  await step("shows what the server read before a search starts", async () => {
    await app.id("target-file").setInputFiles(GOOD);
    const understood = app.id("target-understood");
    await understood.waitFor();
    await page.getByText("lobe.csv").waitFor();
    const words = await understood.innerText();
    const [fitted, held] = [/fitted to\s+(\d+)/, /held out\s+(\d+)/].map((pattern) =>
      Number(pattern.exec(words)?.[1]),
    );
    assert.ok(fitted + held === 600 && held > 0, words);
    await page.waitForFunction(() => {
      const images = [...document.querySelectorAll("[data-testid=understood-measured] img")];
      return images.length === 2 && images.every((it) => it.complete && it.naturalWidth === 256);
    });
    assert.equal((await app.api("/v1/jobs")).items.length, 0);
    await shot("52-search-understood");
    await app.accessible("a new search");
  });

  await step("names the wrong field", async () => {
    await app.id("search-budget").fill("soon");
    await app.id("search-start").click();
    await page.locator("[data-testid=error][data-place=search]").waitFor();
    assert.equal(await app.id("search-budget").getAttribute("aria-invalid"), "true");
  });

  const job = await step("searches, and shows the progress", async () => {
    await app.id("search-strategy").selectOption("lobes");
    await start(app, GENERATIONS);
    // A horizontal path has no height and counts as hidden, so the chart must be visible and the
    // path have a stroke.
    await app.id("search-course").locator("svg[role=img]").first().waitFor();
    const curve = app.id("search-course").locator("svg[role=img] > path.curve").first();
    await curve.waitFor({ state: "attached" });
    const drawn = await curve.evaluate((path) => {
      const { visibility, display, stroke, opacity } = getComputedStyle(path);
      return visibility === "visible" && display !== "none" && stroke !== "none" && opacity !== "0";
    });
    assert.ok(drawn, "the curve is drawn");
    await app.id("found-picture").locator("img").first().waitFor();
    await shot("53-search-running");
    await stands(app, "done");
    const ended = await present(app);
    assert.equal(ended.state, "succeeded");
    assert.equal(String(ended.seed), "5");
    assert.equal(ended.strategy, "lobes");
    assert.equal(ended.generation, GENERATIONS);
    assert.match(
      await app.id("job-figures").innerText(),
      new RegExp(`100 % of ${GENERATIONS} generations`),
    );
    return ended;
  });

  const { items: front } = await app.api(`/v1/jobs/${job.id}/front`);
  const shortest = [...front].sort((a, b) => a.operations - b.operations || a.e_log - b.e_log)[0];

  await step("steps along the front by key, and shows a result under another light", async () => {
    assert.ok(front.length > 1, "there is more than one find");
    const points = page.getByRole("radiogroup", { name: /^Front/ }).getByRole("radio");
    await points.first().waitFor();
    assert.equal(await points.count(), front.length);
    await points.and(page.getByRole("radio", { checked: true })).focus();
    await page.keyboard.press("Home");
    assert.equal(
      await page.evaluate(() => document.activeElement?.getAttribute("aria-checked")),
      "true",
    );
    await page.getByTestId("found-picture").locator(`img[src*="${shortest.individual}"]`).waitFor();
    await app.id("found-light").fill("90");
    await app.id("found-light").blur();
    await page.getByTestId("found-picture").locator("img[src*='light_deg=90']").first().waitFor();
    await shot("54-search-front");
    await app.accessible("a search that is done");
    await app.id("found-light-rest").click();
    await app.id("front-table").locator("tbody button").first().click();
    await page.getByTestId("found-picture").locator(`img[src*="${front[0].individual}"]`).waitFor();
  });

  await step("shows the target beside and over the result under the same light", async () => {
    const pair = app.id("found-pair");
    const sources = await pair
      .locator("img")
      .evaluateAll((images) => images.map((image) => image.getAttribute("src")));
    const [beside, find, over] = sources.map((source) => new URL(source, base));
    assert.equal(beside.href, over.href);
    assert.ok(
      beside.pathname.includes(job.target) && find.pathname.includes(front[0].individual),
      sources.join(),
    );
    assert.deepEqual(
      ["scene", "size", "light_deg"].map((name) => beside.searchParams.get(name)),
      ["scene", "size", "light_deg"].map((name) => find.searchParams.get(name)),
    );
    const seen = () => pair.locator("[data-seen]").getAttribute("data-seen");
    await page.keyboard.down("x");
    assert.equal(await seen(), "100");
    await page.keyboard.up("x");
    await app.id("found-pair-flip").click();
    assert.equal(await seen(), "0");
    await app.id("found-pair-blend").fill("40");
    assert.equal(await seen(), "40");
    await app.accessible("a find and its target");
  });

  await step("restores a search from its link, and lists it", async () => {
    await page.reload();
    await stands(app, "done");
    await app.id("front-0").waitFor();
    await app.id("searches-all").click();
    await app.id(`job-${job.id}`).filter({ hasText: "done" }).waitFor();
    await shot("55-searches");
    await app.accessible("the list of searches");
    await app.id(`job-${job.id}`).click();
    await stands(app, "done");
    await page.goBack();
    await app.id(`job-${job.id}`).click();
  });

  await step("inspects a result, and breeds from it", async () => {
    await app.id("found-inspect").click();
    await app.id("inspector").getByRole("heading", { name: "Physical checks" }).waitFor();
    await app.id("inspector-close").click();
    const child = await app.generation(await app.becomes(() => app.id("found-breed").click()));
    // The result's generation is shown first.
    const bred =
      child.parents[0] === front[0].individual
        ? child
        : await app.generation(await app.ready(child.id));
    assert.deepEqual(bred.parents, [front[0].individual]);
    assert.equal(bred.lineage, job.lineage);
    assert.equal(bred.individuals.length, 20);
    assert.equal(await dialog.count(), 0);
    await shot("56-search-bred");
  });

  await step(
    "pauses, resumes and cancels a longer search that starts from the centre",
    async () => {
      await page.getByTestId("search-from").click();
      await app.id("search-start-clear").waitFor();
      // The last target is still chosen.
      await app
        .id("target-understood")
        .or(app.id(`target-${job.target}`))
        .first()
        .waitFor();
      if (await app.id(`target-${job.target}`).isVisible())
        await app.id(`target-${job.target}`).click();
      await start(app, 5000);
      await stands(app, "searching");
      await app.id("job-pause").click();
      await stands(app, "paused");
      assert.equal((await present(app)).state, "paused");
      await app.id("job-resume").click();
      await stands(app, /searching|queued/);
      await app.id("job-cancel").click();
      await page.getByRole("group", { name: "Cancel the search?" }).waitFor();
      await app.accessible("whether to cancel a search");
      await app.id("job-cancel-yes").click();
      await stands(app, "cancelled");
      const ended = await present(app);
      assert.equal(ended.state, "cancelled");
      assert.equal(ended.lineage, job.lineage, "its finds are born beside what it started from");
      assert.ok(
        (await app.id("job-pause").isDisabled()) && (await app.id("job-cancel").isDisabled()),
      );
      await shot("57-search-cancelled");
      await app.id("searches-close").click();
      await dialog.waitFor({ state: "detached" });
      assert.ok(!page.url().includes("/search/"));
    },
  );
  app.quiet();
}

/** The same on a small touch screen, with the target that the server has. */
export async function searchByFinger(app, step, shot) {
  const { page } = app;
  await step("searches by finger on a screen of 360 pixels", async () => {
    await app.id("searches").tap();
    await app.id("searches-dialog").getByRole("button", { name: "New search" }).first().tap();
    await app.id("target-file").setInputFiles(GOOD);
    await app.id("target-understood").waitFor();
    await app.fits(app.id("searches-dialog"));
    await shot("58-narrow-search-new");
    await app.accessible("360 x 740, a new search");
    await start(app, 1);
    await stands(app, "done");
    await app.id("found-picture").locator("img").first().waitFor();
    await app.fits(app.id("searches-dialog"));
    await shot("59-narrow-search");
    await app.id("search-front").scrollIntoViewIfNeeded();
    await shot("60-narrow-search-front");
    await app.accessible("360 x 740, a search");
    await app.id("searches-close").tap();
    await page.getByTestId("searches-dialog").waitFor({ state: "detached" });
  });
}
