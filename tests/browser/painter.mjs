// A first visit of a painter, by visible words: a painted lineage, bred, in the colours of a
// painting, on the ground beside a glass ball, and exported.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

import { drop, painting } from "./painted.mjs";

/** Number of frames that the painter picks. */
const PICKS = 5;

/** Runs the part of the journey; `shot` saves a screenshot. */
export async function painter(app, step, shot) {
  const { page } = app;
  const knobs = page.getByRole("complementary", { name: "Knobs" });
  const details = page.getByRole("complementary", { name: "Details" });

  await step("a painter starts a painted lineage, and breeds it five times", async () => {
    await app.id("lineage-menu").click();
    await page.getByLabel("Name of a new lineage").fill("A painter's");
    await page.getByRole("radio", { name: "painted" }).check();
    await app.generation(await app.becomes(() => page.getByRole("button", { name: "New", exact: true }).click()));
    for (let pick = 1; pick <= PICKS; pick += 1)
      await app.generation(await app.becomes(() => app.cell(2 * pick).click()));
    await shot("43-painter-breeds");
  });

  await step("a painter drops a painting, and gets children in its palette", async () => {
    const own = knobs.getByRole("group", { name: "Colours of a painting" });
    const file = { name: "art.png", type: "image/png", base64: await painting(page) };
    await drop(own, file);
    await own.getByRole("listitem").nth(2).waitFor();
    const brood = await app.generation(await app.becomes(() => app.cell(3).click()));
    assert.equal(brood.painting.regions.length, 3);
    await shot("44-painter-palette");
  });

  const glassBall = await step("a painter puts it on the ground beside a glass ball", async () => {
    await app.reshown(() => knobs.locator("label", { hasText: /^ground$/ }).click());
    await app.reshown(() => knobs.getByLabel("Other object").selectOption("sphere"));
    const material = knobs.getByLabel("Material", { exact: true });
    await material.focus();
    await material.locator("option", { hasText: "Painted glass" }).waitFor({ state: "attached" });
    const scene = await app.reshown(() => material.selectOption({ label: "Painted glass" }));
    assert.equal(scene.objects[0].material, "paint-glass");
    const brood = await app.generation(await app.becomes(() => app.cell(5).click()));
    assert.equal(brood.individuals.length, 20);
    await shot("45-painter-glass-ball");
    await app.accessible("a glass ball");
    return brood;
  });

  await step("a painter exports the centre", async () => {
    assert.ok(glassBall.centre.hash);
    await details.getByText("Export", { exact: true }).click();
    const link = page.getByRole("link", { name: /GLSL ES/ });
    await link.waitFor();
    const [download] = await Promise.all([page.waitForEvent("download"), link.click()]);
    assert.match(await readFile(await download.path(), "utf8"), /vec3 styled\(StyledPoint at/);
    await details.getByText("Export", { exact: true }).click();
  });
  app.quiet();
}
