// Materials side by side: chosen, compared, shown with curves and numbers.

import { strict as assert } from "node:assert";

/** The comparison of so many materials, once all its pictures are there. */
async function compared(hand, count) {
  await hand.page.waitForFunction((columns) => {
    const table = document.querySelector("[data-testid=compared]");
    const images = [...(table?.querySelectorAll("img") ?? [])];
    const there = images.every((image) => image.complete && image.naturalWidth === 256);
    return table?.querySelectorAll("thead th").length === columns && images.length === 3 * columns - 1 && there;
  }, count);
  return hand.id("compared");
}

/** The cells of a row of numbers. */
const row = (table, name) => table.getByRole("row", { name: new RegExp(`^${name}`) }).getByRole("cell").allInnerTexts();

/** The journey; `shot` takes a picture of the page. */
export async function comparison(hand, step, shot) {
  const { page } = hand;
  const dialog = hand.id("comparison");

  await step("chooses materials by key and by click, and compares them", async () => {
    await hand.id("centre").focus();
    await page.keyboard.press("c");
    await dialog.waitFor();
    assert.ok(await hand.id("compare-now").isDisabled(), "one alone is not compared");
    await hand.id("compare-model-gold").focus();
    await page.keyboard.press("Enter");
    await hand.id("compare-red-plastic").click();
    await page.getByRole("list", { name: "This brood" }).getByRole("button").nth(4).click();
    await shot("42-comparison-chosen");
    await hand.accessible("the choice of a comparison");
    await dialog.getByRole("button", { name: "1st: Gold, by its constants" }).click();
    await hand.id("compare-now").click();
    const table = await compared(hand, 4);
    const [itself, , plastic] = await row(table, "RMSE");
    assert.equal(itself, "–", "the first is not held against itself");
    assert.ok(Number(plastic) > 0.001 && Number(plastic) < 1, `red plastic is off by ${plastic}`);
    const [gold] = await row(table, "energy kept");
    assert.ok(Number(gold) > 0.5 && Number(gold) <= 1, `gold keeps ${gold}`);
    for (const chart of ["chart-albedo", "chart-mirror"]) {
      assert.equal(await hand.id(chart).locator("svg[role=img] > path.curve").count(), 4);
      assert.match(await hand.id(chart).locator("svg[role=img]").getAttribute("aria-label"), /Gold, by its constants: [\d.]+ at 0°/);
    }
    await shot("43-comparison");
    await hand.accessible("a comparison");
    await hand.id("chart-mirror").scrollIntoViewIfNeeded();
    await shot("44-comparison-curves");
  });

  await step("leaves one out, compares the rest, and keeps the choice", async () => {
    await dialog.getByRole("button", { name: /^Leave out Red plastic/ }).click();
    await hand.id("compare-now").click();
    await compared(hand, 3);
    await page.keyboard.press("Escape");
    await dialog.waitFor({ state: "detached" });
    assert.equal(await page.evaluate(() => document.activeElement?.dataset.cell), "centre");
    await hand.id("compare-several").click();
    await compared(hand, 3);
    await hand.id("comparison-close").click();
    await dialog.waitFor({ state: "detached" });
  });
  hand.quiet();
}

/** The same by finger on a small screen. */
export async function comparisonByFinger(hand, step, shot) {
  await step("compares side by side by finger on a screen of 360 pixels", async () => {
    await hand.id("details-toggle").tap();
    await hand.id("compare-several").tap();
    const dialog = hand.id("comparison");
    // B is still pinned: it and the centre are compared at once.
    await compared(hand, 2);
    await hand.page.getByText("Choose from this brood").tap();
    await hand.id("compare-gold").tap();
    await hand.id("compare-model-clay").tap();
    await hand.id("compare-now").tap();
    await compared(hand, 4);
    const sideways = await dialog.evaluate((it) => it.scrollWidth - it.clientWidth);
    assert.ok(sideways <= 0, "nothing sticks out sideways");
    await shot("45-narrow-comparison");
    await hand.id("compared").scrollIntoViewIfNeeded();
    await shot("46-narrow-comparison-table");
    await hand.id("chart-albedo").scrollIntoViewIfNeeded();
    await shot("47-narrow-comparison-curves");
    await hand.accessible("360 x 740, comparison");
    await hand.id("comparison-close").tap();
    await hand.id("details-toggle").tap();
  });
}
