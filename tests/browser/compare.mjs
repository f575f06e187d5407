// A/B comparison: another individual beside the centre and in its place.

import { strict as assert } from "node:assert";

const B_SHOWN = /B is shown in its place/;

/** Pictures of both sides, once both are loaded. */
async function sides(app) {
  const images = app.id("compare-sides").locator("img");
  await app.page.waitForFunction(() => {
    const found = [...document.querySelectorAll("[data-testid=compare-sides] img")];
    return (
      found.length === 2 && found.every((image) => image.complete && image.naturalWidth === 256)
    );
  });
  return Promise.all(
    [0, 1].map(async (at) => new URL(await images.nth(at).getAttribute("src"), app.page.url())),
  );
}

/** Waits until A's and B's pictures in the centre are loaded and no transition runs. */
const bothThere = (page) =>
  page.waitForFunction(() => {
    const images = [...document.querySelectorAll("[data-cell=centre] img")];
    const there = images.every(
      (image) => image.complete && image.naturalWidth > 0 && !image.classList.contains("waiting"),
    );
    return (
      there &&
      images.length > 1 &&
      document.querySelector("[data-testid=other]") &&
      document.getAnimations().length === 0
    );
  });

/** The picture that the centre shows. */
const inCentre = (app) => app.id("centre").locator(".pictures").screenshot();

/** Runs the journey; `shot` saves a screenshot. */
export async function compare(app, step, shot) {
  const { page } = app;
  const name = () => app.id("centre").getAttribute("aria-label");

  const [generation, b] = await step("pins a frame as B by key", async () => {
    const before = await app.generation(await app.ready());
    await app.cell(3).focus();
    await page.keyboard.press("b");
    const [left, right] = await sides(app);
    assert.ok(left.pathname.includes(before.centre?.id ?? before.individuals[0].id), `${left}`);
    assert.ok(right.pathname.includes(before.individuals[3].id), `${right}`);
    assert.equal(left.search, right.search, "both in one scene and of one size");
    return [before, before.individuals[3]];
  });

  await step("flips the centre between A and B in its place", async () => {
    await bothThere(page);
    const a = await inCentre(app);
    await page.keyboard.press("x");
    assert.match(await name(), B_SHOWN);
    const flipped = await inCentre(app);
    assert.ok(!a.equals(flipped), "another picture");
    await shot("12-flipped");
    await page.keyboard.press("x");
    assert.doesNotMatch(await name(), B_SHOWN);
    assert.ok(a.equals(await inCentre(app)), "the same picture again");
    await app.id("flip-here").click();
    assert.match(await name(), B_SHOWN);
    await app.id("flip-here").click();
    await page.getByRole("switch", { name: "flip" }).check();
    assert.match(await name(), B_SHOWN);
    await app.accessible("A / B");
  });

  await step("breeds from the visible picture, and keeps B", async () => {
    const { generations } = await app.api(`/v1/lineages/${generation.lineage}`);
    // A click on B in the centre only shows A again.
    await app.id("centre").click();
    assert.doesNotMatch(await name(), B_SHOWN);
    assert.equal((await app.api(`/v1/lineages/${generation.lineage}`)).generations, generations);
    const child = await app.generation(await app.becomes(() => app.cell(9).click()));
    const [left, right] = await sides(app);
    assert.ok(left.pathname.includes(child.centre.id));
    assert.ok(right.pathname.includes(b.id));
  });

  await step("keeps B in another lineage, rendered in its scene", async () => {
    const other = (await app.api("/v1/lineages")).items.find(
      (it) => it.id !== generation.lineage && it.generations > 0,
    );
    await app.id("lineage-menu").click();
    await app.becomes(() => app.id(`lineage-open-${other.id}`).click());
    const [, right] = await sides(app);
    assert.ok(right.pathname.includes(b.id));
    assert.equal(right.searchParams.get("scene"), other.scene);
    await shot("13-b-in-another-lineage");
  });

  await step("compares with a link or an id, and explains an invalid one", async () => {
    const field = app.id("compare-other");
    const told = page.locator("[data-testid=error][data-place=compare]");
    for (const [text, words] of [
      ["a nice green one", /neither an individual's id nor a share link/],
      [
        `https://elsewhere.example/#/lineage/${generation.lineage}/generation/${generation.id}`,
        /elsewhere\.example/,
      ],
      ["00000000-0000-7000-8000-000000000000", /nothing with that id/],
    ]) {
      await field.fill(text);
      await app.id("compare-pin").click();
      await told.filter({ hasText: words }).waitFor();
    }
    // The browser logs the 404 itself.
    app.complaints = app.complaints.filter((text) => !text.includes("404"));
    const url = new URL(page.url());
    await field.fill(`${url.origin}/#/lineage/${generation.lineage}/generation/${generation.id}`);
    await app.id("compare-pin").click();
    await told.waitFor({ state: "hidden" });
    await page.waitForFunction(
      (not) => !document.querySelectorAll("[data-testid=compare-sides] img")[1].src.includes(not),
      b.id,
    );
    const [, linked] = await sides(app);
    assert.ok(linked.pathname.includes(generation.centre?.id ?? generation.individuals[0].id));
    await field.fill(b.id);
    await page.keyboard.press("Enter");
    await page.waitForFunction(
      (id) => document.querySelectorAll("[data-testid=compare-sides] img")[1].src.includes(id),
      b.id,
    );
  });

  await step("pins from the history and the favourites, and unpins on Escape", async () => {
    await app.id("history-0").focus();
    await page.keyboard.press("Escape");
    await app.id("compare-sides").waitFor({ state: "detached" });
    await page.keyboard.press("b");
    await sides(app);
    await app.id("unpin").click();
    await app.id("history-0").hover();
    await page
      .getByRole("button", { name: "Compare with the centre: generation 0", exact: true })
      .click();
    await sides(app);
    await page.keyboard.press("Escape");
    await app.cell(6).hover();
    await page.getByRole("button", { name: "Favourite: Frame 7" }).click();
    await page.getByRole("button", { name: /^Favourite 7 of/ }).focus();
    await page.keyboard.press("b");
    await sides(app);
    await page.keyboard.press("Escape");
    await app.id("compare").waitFor();
  });
  app.quiet();
}

/** The same on a touch screen, where the details would cover the frames. */
export async function compareByFinger(app, step, shot) {
  await step("compares by finger on a screen of 360 pixels", async () => {
    await app.id("centre").getByTestId("pin").tap();
    await app.becomes(() => app.cell(8).tap());
    await bothThere(app.page);
    await app.id("flip-here").tap();
    assert.match(await app.id("centre").getAttribute("aria-label"), B_SHOWN);
    await shot("14-narrow-flipped");
    await app.accessible("360 x 740, flipped");
  });
}
