// Materials side by side: choice, comparison, charts and figures.

import { strict as assert } from "node:assert";

/** Waits for a comparison of a number of materials with all its pictures. */
async function compared(app, count) {
  await app.page.waitForFunction((columns) => {
    const table = document.querySelector("[data-testid=compared]");
    const images = [...(table?.querySelectorAll("img") ?? [])];
    const there = images.every((image) => image.complete && image.naturalWidth === 256);
    return (
      table?.querySelectorAll("thead th").length === columns &&
      images.length === 3 * columns - 1 &&
      there
    );
  }, count);
  return app.id("compared");
}

/** Cells of a row of figures. */
const row = (table, name) =>
  table
    .getByRole("row", { name: new RegExp(`^${name}`) })
    .getByRole("cell")
    .allInnerTexts();

/** Runs the journey; `shot` saves a screenshot. */
export async function comparison(app, step, shot) {
  const { page } = app;
  const dialog = app.id("comparison");

  await step("chooses materials by key and by click, and compares them", async () => {
    await app.id("centre").focus();
    await page.keyboard.press("c");
    await dialog.waitFor();
    assert.ok(await app.id("compare-now").isDisabled(), "one alone is not compared");
    await app.id("compare-model-gold").focus();
    await page.keyboard.press("Enter");
    await app.id("compare-red-plastic").click();
    await page.getByRole("list", { name: "This brood" }).getByRole("button").nth(4).click();
    await shot("42-comparison-chosen");
    await app.accessible("the choice of a comparison");
    await dialog.getByRole("button", { name: "Use as reference: Gold, by its constants" }).click();
    await app.id("compare-now").click();
    const table = await compared(app, 4);
    const [itself, , plastic] = await row(table, "RMSE");
    assert.equal(itself, "–", "the reference is not compared with itself");
    assert.ok(Number(plastic) > 0.001 && Number(plastic) < 1, `red plastic is off by ${plastic}`);
    const [gold] = await row(table, "energy kept");
    assert.ok(Number(gold) > 0.5 && Number(gold) <= 1, `gold keeps ${gold}`);
    for (const chart of ["chart-albedo", "chart-mirror"]) {
      assert.equal(await app.id(chart).locator("svg[role=img] > path.curve").count(), 4);
      assert.match(
        await app.id(chart).locator("svg[role=img]").getAttribute("aria-label"),
        /Gold, by its constants: [\d.]+ at 0°/,
      );
    }
    await shot("43-comparison");
    await app.accessible("a comparison");
    await app.id("chart-mirror").scrollIntoViewIfNeeded();
    await shot("44-comparison-curves");
  });

  await step("removes one, compares the rest, and keeps the choice", async () => {
    await dialog.getByRole("button", { name: /^Leave out Red plastic/ }).click();
    await app.id("compare-now").click();
    await compared(app, 3);
    await page.keyboard.press("Escape");
    await dialog.waitFor({ state: "detached" });
    assert.equal(await page.evaluate(() => document.activeElement?.dataset.cell), "centre");
    await app.id("compare-several").click();
    await compared(app, 3);
    await app.id("comparison-close").click();
    await dialog.waitFor({ state: "detached" });
  });
  app.quiet();
}

/** The same on a small touch screen. */
export async function comparisonByFinger(app, step, shot) {
  await step("compares side by side by finger on a screen of 360 pixels", async () => {
    await app.id("details-toggle").tap();
    await app.id("compare-several").tap();
    const dialog = app.id("comparison");
    // B is still pinned, so it is compared with the centre at once.
    await compared(app, 2);
    await app.page.getByText("Choose from this brood").tap();
    await app.id("compare-gold").tap();
    await app.id("compare-model-clay").tap();
    await app.id("compare-now").tap();
    await compared(app, 4);
    await app.fits(dialog);
    await shot("45-narrow-comparison");
    await app.id("compared").scrollIntoViewIfNeeded();
    await shot("46-narrow-comparison-table");
    await app.id("chart-albedo").scrollIntoViewIfNeeded();
    await shot("47-narrow-comparison-curves");
    await app.accessible("360 x 740, comparison");
    await app.id("comparison-close").tap();
    await app.id("details-toggle").tap();
  });
}
