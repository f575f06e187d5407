// Genome inspector, locks, energy limit, covers, and animated exports.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

import { allLit, asServerDraws, hold, noneLit, slide } from "./live.mjs";

/** Waits for the inspector with the server's answer. */
async function openedInspector(app) {
  await app.id("listing").waitFor();
  await app.page.waitForFunction(() => {
    const image = document.querySelector("[data-testid=slice] img");
    return image?.complete && image.naturalWidth > 0;
  });
  return app.id("inspector");
}

/** A fact by its name in a part of the page. */
const fact = (within, name) =>
  within
    .locator("dl > div")
    .filter({ has: within.page().locator("dt", { hasText: new RegExp(`^${name}$`) }) })
    .locator("dd");

const inspection = (app, individual) => app.api(`/v1/individuals/${individual.id}/inspection`);

/** Instruction lines of a genome. */
const instructionsOf = ({ source, counts }) =>
  source.trimEnd().split("\n").slice(-counts.instructions);

/** Breeds from a frame; returns the request and the brood. */
async function bred(app, act) {
  const sent = app.page.waitForRequest(
    (it) => it.method() === "POST" && it.url().endsWith("/generations"),
  );
  const generation = await app.generation(await app.becomes(act));
  return { sent: (await sent).postDataJSON(), generation };
}

/** Sets the energy limit and waits until the lineage has stored it; off before if it is on. */
async function limit(app) {
  const control = app.page.getByRole("switch", { name: "energy limit" });
  for (const on of (await control.isChecked()) ? [false, true] : [true]) {
    const patched = app.page.waitForResponse((it) => it.request().method() === "PATCH");
    await control.setChecked(on);
    const answer = await patched;
    assert.equal(answer.status(), 200);
    assert.equal((await answer.json()).energy_limit, on);
  }
}

/** Runs the journey; `shot` saves a screenshot. */
export async function inspect(app, step, shot, base) {
  const { page } = app;
  const details = page.getByRole("complementary", { name: "Details" });

  await step("breeds under the energy limit, and shows the largest albedo", async () => {
    await app.open();
    await app.id("lineage-menu").click();
    await app.id("lineage-name").fill("looked into");
    await app.id("lineage-start").getByRole("radio", { name: "wild" }).check();
    await app.becomes(() => app.id("lineage-new").click());
    await limit(app);
    const { sent, generation } = await bred(app, () => app.cell(4).click());
    assert.equal(sent.energy_limit, true);
    assert.equal(generation.energy_limit, true);
    await app.becomes(() => app.cell(3).click());
    await fact(details, "largest albedo").filter({ hasText: "(limited)" }).waitFor();
    const { energy } = await inspection(app, generation.individuals[3]);
    assert.ok(energy.max_albedo <= 1 + energy.error_bound, `${energy.max_albedo}`);
    const shown = await fact(details, "largest albedo").innerText();
    assert.equal(Number.parseFloat(shown), Number(energy.max_albedo.toPrecision(2)));
    await page.reload();
    await app.ready();
    assert.ok(await page.getByRole("switch", { name: "energy limit" }).isChecked());
    await shot("27-limited");
  });

  const looked = await step("inspects the genome of a frame by key", async () => {
    const generation = await app.generation(await app.ready());
    const individual = generation.individuals[5];
    await app.cell(5).focus();
    await page.keyboard.press("i");
    const inspector = await openedInspector(app);
    assert.ok(
      (await inspector.getByRole("heading", { level: 2 }).innerText())
        .toLowerCase()
        .includes(individual.hash.slice(0, 8)),
    );
    const found = await inspection(app, individual);
    assert.equal(await inspector.locator("[data-instruction]").count(), found.counts.instructions);
    assert.equal(
      await inspector.locator("[data-instruction].dead").count(),
      found.live.filter((live) => !live).length,
    );
    assert.equal(
      await fact(inspector, "instructions").innerText(),
      `${found.counts.live_instructions} of ${found.counts.instructions} live`,
    );
    assert.equal(await inspector.getByTestId("polar").locator("g > .curve").count(), 4);
    await shot("28-inspector");
    await app.accessible("inspector");
    return { generation, individual, found };
  });

  await step("changes the options of plot and listing", async () => {
    const inspector = app.id("inspector");
    // All of them: a single channel may have no curve, and missing curves all look alike.
    const drawn = () =>
      inspector
        .getByTestId("polar")
        .locator("g > .curve")
        .evaluateAll((curves) => curves.map((curve) => curve.getAttribute("d")).join());
    const seen = new Set([await drawn()]);
    const choices = ["log", "f cos θₒ", "red"];
    if (looked.found.planes.length > 1) choices.push("across u");
    for (const name of choices) {
      await inspector.getByRole("radio", { name, exact: true }).check();
      seen.add(await drawn());
    }
    assert.ok(seen.size > 2, "the curves change");
    await inspector.getByRole("switch", { name: "live code only" }).check();
    assert.equal(
      await inspector.locator("[data-instruction]").count(),
      looked.found.counts.live_instructions,
    );
    assert.equal(await inspector.locator(".dead").count(), 0);
    await inspector.getByRole("button", { name: "Copy" }).click();
    await inspector.getByRole("button", { name: "Copied" }).waitFor();
    assert.equal(await page.evaluate(() => navigator.clipboard.readText()), looked.found.source);
    await inspector.getByRole("radio", { name: "scalar code" }).check();
    assert.equal(
      (await app.id("listing").locator("pre").innerText()).trim(),
      looked.found.code.trim(),
    );
    await shot("29-scalar-code");
    await inspector.getByRole("radio", { name: "assembly" }).check();
    await page.keyboard.press("Escape");
    await inspector.waitFor({ state: "detached" });
    assert.equal(
      await page.evaluate(() => document.activeElement.dataset.cell),
      "5",
      "the focus is where it was",
    );
  });

  await step("locks instructions and constants, and children keep them", async () => {
    const parent = looked.individual;
    const live = looked.found.live.flatMap((is, at) => (is ? [at] : [])).slice(0, 12);
    await page.keyboard.press("i");
    const inspector = await openedInspector(app);
    for (const at of live)
      await inspector.getByRole("button", { name: `Lock instruction ${at}`, exact: true }).click();
    const constants = await inspector.locator("[data-constant] .lock").count();
    if (constants > 0) await inspector.locator("[data-constant] .lock").first().click();
    await shot("30-locks");
    await app.accessible("locks");
    await inspector.getByRole("button", { name: "Close" }).click();
    await app
      .id("lock-sign")
      .filter({ hasText: `${live.length} instructions` })
      .waitFor();
    const { sent, generation } = await bred(app, () => app.cell(5).click());
    assert.deepEqual(sent.parents, [parent.id]);
    assert.deepEqual(sent.locks.instructions, live);
    assert.equal(sent.locks.constants.length, Math.min(1, constants));
    assert.deepEqual(generation.locks.instructions, live);
    const kept = instructionsOf(looked.found);
    for (const slot of [0, 9, 19]) {
      const lines = instructionsOf(await inspection(app, generation.individuals[slot]));
      assert.deepEqual(
        live.map((at) => lines[at]),
        live.map((at) => kept[at]),
        `child ${slot}`,
      );
    }
    await shot("31-kept");
  });

  await step("sends no locks with a random brood, and keeps them", async () => {
    const { sent, generation } = await bred(app, () => app.id("afresh").click());
    assert.equal(sent.locks, undefined);
    assert.ok(!generation.locks);
    await page.reload();
    await app.ready();
    await app.id("lock-sign").waitFor();
  });

  await step("explains identical children by the lock", async () => {
    for (const name of ["Lock red", "Lock green", "Lock blue"])
      await app.id("locks").getByRole("switch", { name }).check();
    const { generation } = await bred(app, () => app.cell(2).click());
    assert.deepEqual(generation.locks.channels, ["r", "g", "b"]);
    const twins = generation.individuals.filter((it) => it.twin).length;
    assert.ok(twins > 0);
    await app
      .id("status")
      .filter({ hasText: `${twins} identical ${twins === 1 ? "child" : "children"}: the lock` })
      .waitFor();
    await shot("32-twins");
    await app.accessible("locked");
    await app.id("lock-sign").click();
    await page.getByRole("button", { name: "Unlock all" }).click();
    assert.equal(await app.id("lock-sign").count(), 0);
    await app.becomes(() => app.cell(2).click());
    assert.doesNotMatch(await app.id("status").innerText(), /identical/);
  });

  await step("shows the cover of each lineage", async () => {
    await app.id("lineage-menu").click();
    const { items } = await app.api("/v1/lineages");
    const covered = items.filter((it) => it.cover).length;
    assert.ok(covered > 0);
    await page.waitForFunction((count) => {
      const images = [...document.querySelectorAll(".lineages .cover img")];
      return images.length === count && images[0].naturalWidth > 0;
    }, covered);
    const dialog = page.getByRole("dialog", { name: "Lineages" });
    assert.ok(
      (await dialog.evaluate((it) => it.scrollWidth - it.clientWidth)) <= 0,
      "nothing sticks out sideways",
    );
    await shot("33-covers");
    await app.accessible("covers");
    await page.keyboard.press("Escape");
  });

  await step("exports animations of an individual and of the brood", async () => {
    await page.getByText("Export", { exact: true }).click();
    for (const [name, animated] of [
      [/^Animated PNG, light/, true],
      [/^PNG strip/, false],
      [/^PNG of the brood/, false],
      [/^Animated PNG of the brood/, true],
    ]) {
      const link = page.getByRole("link", { name });
      const [download] = await Promise.all([page.waitForEvent("download"), link.click()]);
      const bytes = await readFile(await download.path());
      assert.equal(bytes.toString("latin1", 1, 4), "PNG", `${name}`);
      assert.equal(bytes.includes("acTL"), animated, `${name}`);
      assert.match(download.suggestedFilename(), animated ? /\.a?png$/ : /\.png$/);
    }
    await app.id("export-width").fill("96");
    await app.id("export-height").fill("8");
    await page.getByText("must be 16 to 2048 pixels").waitFor();
    assert.equal(await app.id("export-png").count(), 0);
    await app.id("export-height").fill("64");
    const exported = async (id) => {
      const [download] = await Promise.all([page.waitForEvent("download"), app.id(id).click()]);
      return readFile(await download.path());
    };
    const png = await exported("export-png");
    assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [96, 64]);
    assert.equal((await exported("export-exr")).readUInt32LE(0), 20000630, "OpenEXR");
    await shot("34-exports");
  });

  await step("shows a failed inspection in the inspector", async () => {
    await page.route("**/inspection", (route) =>
      route.fulfill({
        status: 404,
        contentType: "application/problem+json",
        body: JSON.stringify({ title: "Not here", status: 404, detail: "it is gone" }),
      }),
    );
    await app.cell(11).focus();
    await page.keyboard.press("i");
    await page
      .locator("[data-testid=error][data-place=inspector]")
      .filter({ hasText: "it is gone" })
      .waitFor();
    await page.unroute("**/inspection");
    await page.keyboard.press("Escape");
    app.complaints = app.complaints.filter((text) => !text.includes("404"));
  });
  app.quiet();
}

/** The same on a touch screen, where everything is stacked. */
export async function inspectByFinger(app, step, shot) {
  const { page } = app;
  await step("inspects the centre and locks by finger on a screen of 360 pixels", async () => {
    await app.id("details-toggle").tap();
    await page.getByRole("button", { name: "Inspect the genome" }).tap();
    const inspector = await openedInspector(app);
    await app.fits(inspector);
    await shot("35-narrow-inspector");
    await inspector.getByRole("button", { name: "Lock instruction 1", exact: true }).tap();
    await shot("36-narrow-locks");
    await app.accessible("360 x 740, inspector");
    await inspector.getByRole("button", { name: "Unlock all" }).tap();
    await inspector.getByRole("button", { name: "Close" }).tap();
    await app.id("details-toggle").tap();
  });
}

/** Under the energy limit live frames equal the server's pictures. */
export async function limitedLive(app, step, shot, base) {
  await step("draws children under the energy limit like the server", async () => {
    await limit(app);
    const generation = await app.generation(await app.becomes(() => app.cell(4).click()));
    assert.equal(generation.energy_limit, true);
    // Three stops above, as left by the steps of the film, borders that only the server antialiases
    // differ in eight times as many codes.
    await app.reshown(() => slide(app, "exposure", 0));
    await hold(app, "light", 75);
    await allLit(app.page);
    await asServerDraws(app, generation, 75, base);
    await shot("37-limited-live");
    await app.reshown(() => slide(app, "light", 1));
    await noneLit(app.page);
  });
}
