// A first visit on an empty server. Uses only visible words, no test ids and no keys, to show that
// the page explains itself.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

/** Name and text of the file that the browser saves during an action. */
async function saved(page, act) {
  const [download] = await Promise.all([page.waitForEvent("download"), act()]);
  return {
    name: download.suggestedFilename(),
    text: await readFile(await download.path(), "utf8"),
  };
}

/** Runs the journey; `shot` saves a screenshot. */
export async function visitor(app, step, shot, base) {
  const { page } = app;
  const frame = (number) => page.getByRole("gridcell", { name: new RegExp(`^Frame ${number},`) });
  /** Waits for the status line of a complete brood. */
  const arrived = (generation) =>
    page.getByText(new RegExp(`^generation ${generation} · 20 of 20 · \\d+ ms`)).waitFor();

  await step("a visitor arrives, and sees pictures and what to do", async () => {
    await page.goto(base);
    await arrived(0);
    assert.ok(await page.getByRole("heading", { name: "brood" }).isVisible());
    assert.ok(await frame(1).getByRole("img").or(frame(1).locator("img")).first().isVisible());
    assert.ok(await page.getByText("Click a picture to breed from it").isVisible());
    await shot("20-visitor-arrives");
  });

  await step("a visitor breeds from one picture, and then another", async () => {
    await frame(8).click();
    await arrived(1);
    await shot("21-visitor-picks");
    await frame(13).click();
    await arrived(2);
    await shot("22-visitor-breeds-again");
  });

  await step("a visitor marks a favourite with the star", async () => {
    await frame(5).hover();
    await shot("23-visitor-sees-the-star");
    await page.getByRole("button", { name: "Favourite: Frame 5" }).click();
    await page.getByRole("button", { name: "Favourite: Frame 5", pressed: true }).waitFor();
  });

  await step("a visitor opens the details, and finds the favourite there", async () => {
    await page.getByRole("button", { name: "Details", exact: true }).click();
    const details = page.getByRole("complementary", { name: "Details" });
    await details.getByRole("heading", { name: "Favourites" }).waitFor();
    await details
      .getByRole("button", { name: "Favourite 5 of generation 2", exact: true })
      .waitFor();
    await shot("24-visitor-details");
  });

  await step("a visitor exports the centre as GLSL and as .brood", async () => {
    await page.getByText("Export", { exact: true }).click();
    await page.getByRole("link", { name: /GLSL ES/ }).waitFor();
    await shot("25-visitor-exports");
    const glsl = await saved(page, () => page.getByRole("link", { name: /GLSL ES/ }).click());
    assert.match(glsl.name, /^untitled-1-[0-9a-f]{4}\.es300\.glsl$/);
    assert.match(glsl.text, /vec3 evolved\(vec3 wi, vec3 wo/);
    assert.equal(glsl.text.split("{").length, glsl.text.split("}").length, "the braces close");
    const brood = await saved(page, () => page.getByRole("link", { name: /^\.brood/ }).click());
    assert.match(brood.name, /^untitled-1-[0-9a-f]{4}\.brood$/);
    assert.match(brood.text, /^brood 1\n/);
    assert.ok(brood.text.split("\n").length > 20, "the whole genome is there");
  });

  await step("a visitor closes the details and hides the hint, which stays hidden", async () => {
    await page.getByRole("button", { name: "Details", exact: true }).click();
    await page.getByRole("button", { name: "Hide this hint" }).click();
    await page.getByText("Click a picture to breed from it").waitFor({ state: "hidden" });
    await page.reload();
    await page.getByText(/^generation 2 · 20 of 20/).waitFor();
    assert.equal(await page.getByText("Click a picture to breed from it").count(), 0);
    await shot("26-visitor-without-help");
  });
  app.quiet();
}
