// A and B: another individual beside the centre and in its place.

import { strict as assert } from "node:assert";

const B_SHOWN = /B is shown in its place/;

/** The pictures of both sides, once both are there. */
async function sides(hand) {
  const images = hand.id("compare-sides").locator("img");
  await hand.page.waitForFunction(() => {
    const found = [...document.querySelectorAll("[data-testid=compare-sides] img")];
    return found.length === 2 && found.every((image) => image.complete && image.naturalWidth === 256);
  });
  return Promise.all([0, 1].map(async (at) => new URL(await images.nth(at).getAttribute("src"), hand.page.url())));
}

/** Waits until A's and B's pictures in the centre are there and nothing fades any more. */
const bothThere = (page) =>
  page.waitForFunction(() => {
    const images = [...document.querySelectorAll("[data-cell=centre] img")];
    const there = images.every((image) => image.complete && image.naturalWidth > 0 && !image.classList.contains("waiting"));
    return there && images.length > 1 && document.querySelector("[data-testid=other]") && document.getAnimations().length === 0;
  });

/** What the centre shows. */
const inCentre = (hand) => hand.id("centre").locator(".pictures").screenshot();

/** The journey; `shot` takes a picture of the page. */
export async function compare(hand, step, shot) {
  const { page } = hand;
  const name = () => hand.id("centre").getAttribute("aria-label");

  const [generation, b] = await step("pins a frame as B by key", async () => {
    const before = await hand.generation(await hand.ready());
    await hand.cell(3).focus();
    await page.keyboard.press("b");
    const [left, right] = await sides(hand);
    assert.ok(left.pathname.includes(before.centre?.id ?? before.individuals[0].id), `${left}`);
    assert.ok(right.pathname.includes(before.individuals[3].id), `${right}`);
    assert.equal(left.search, right.search, "both in one scene and of one size");
    return [before, before.individuals[3]];
  });

  await step("flips the centre between A and B in its place", async () => {
    await bothThere(page);
    const a = await inCentre(hand);
    await page.keyboard.press("x");
    assert.match(await name(), B_SHOWN);
    const flipped = await inCentre(hand);
    assert.ok(!a.equals(flipped), "another picture");
    await shot("12-flipped");
    await page.keyboard.press("x");
    assert.doesNotMatch(await name(), B_SHOWN);
    assert.ok(a.equals(await inCentre(hand)), "the same picture again");
    await hand.id("flip-here").click();
    assert.match(await name(), B_SHOWN);
    await hand.id("flip-here").click();
    await page.getByRole("switch", { name: "flip" }).check();
    assert.match(await name(), B_SHOWN);
    await hand.accessible("A / B");
  });

  await step("breeds from what is seen, and keeps B through it", async () => {
    const { generations } = await hand.api(`/v1/lineages/${generation.lineage}`);
    // A click on B in the place of A only puts A back.
    await hand.id("centre").click();
    assert.doesNotMatch(await name(), B_SHOWN);
    assert.equal((await hand.api(`/v1/lineages/${generation.lineage}`)).generations, generations);
    const child = await hand.generation(await hand.becomes(() => hand.cell(9).click()));
    const [left, right] = await sides(hand);
    assert.ok(left.pathname.includes(child.centre.id));
    assert.ok(right.pathname.includes(b.id));
  });

  await step("keeps B in another lineage, in that one's scene", async () => {
    const other = (await hand.api("/v1/lineages")).items.find((it) => it.id !== generation.lineage && it.generations > 0);
    await hand.id("lineage-menu").click();
    await hand.becomes(() => hand.id(`lineage-open-${other.id}`).click());
    const [, right] = await sides(hand);
    assert.ok(right.pathname.includes(b.id));
    assert.equal(right.searchParams.get("scene"), other.scene);
    await shot("13-b-in-another-lineage");
  });

  await step("compares with what a link or an id names, and says what is wrong with one", async () => {
    const field = hand.id("compare-other");
    const told = page.locator("[data-testid=error][data-place=compare]");
    for (const [text, words] of [
      ["a nice green one", /neither an individual's id nor a link/],
      [`https://elsewhere.example/#/lineage/${generation.lineage}/generation/${generation.id}`, /elsewhere\.example/],
      ["00000000-0000-7000-8000-000000000000", /Nothing on this server has that id/],
    ]) {
      await field.fill(text);
      await hand.id("compare-pin").click();
      await told.filter({ hasText: words }).waitFor();
    }
    // The browser itself logs what was not found.
    hand.complaints = hand.complaints.filter((text) => !text.includes("404"));
    const url = new URL(page.url());
    await field.fill(`${url.origin}/#/lineage/${generation.lineage}/generation/${generation.id}`);
    await hand.id("compare-pin").click();
    await told.waitFor({ state: "hidden" });
    await page.waitForFunction((not) => !document.querySelectorAll("[data-testid=compare-sides] img")[1].src.includes(not), b.id);
    const [, linked] = await sides(hand);
    assert.ok(linked.pathname.includes(generation.centre?.id ?? generation.individuals[0].id));
    await field.fill(b.id);
    await page.keyboard.press("Enter");
    await page.waitForFunction((id) => document.querySelectorAll("[data-testid=compare-sides] img")[1].src.includes(id), b.id);
  });

  await step("pins from the history and from the favourites, and lets go on Escape", async () => {
    await hand.id("history-0").focus();
    await page.keyboard.press("Escape");
    await hand.id("compare-sides").waitFor({ state: "detached" });
    await page.keyboard.press("b");
    await sides(hand);
    await hand.id("unpin").click();
    await hand.id("history-0").hover();
    await page.getByRole("button", { name: "Compare with the centre: generation 0", exact: true }).click();
    await sides(hand);
    await page.keyboard.press("Escape");
    await hand.cell(6).hover();
    await page.getByRole("button", { name: "Favourite: Frame 7" }).click();
    await page.getByRole("button", { name: /^Favourite 7 of/ }).focus();
    await page.keyboard.press("b");
    await sides(hand);
    await page.keyboard.press("Escape");
    await hand.id("compare").waitFor();
  });
  hand.quiet();
}

/** The same by finger, where the details would lie over the frames. */
export async function compareByFinger(hand, step, shot) {
  await step("compares by finger on a screen of 360 pixels", async () => {
    await hand.id("centre").getByTestId("pin").tap();
    await hand.becomes(() => hand.cell(8).tap());
    await bothThere(hand.page);
    await hand.id("flip-here").tap();
    assert.match(await hand.id("centre").getAttribute("aria-label"), B_SHOWN);
    await shot("14-narrow-flipped");
    await hand.accessible("360 x 740, flipped");
  });
}
