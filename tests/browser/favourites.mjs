// Favourites of all lineages: shown, crossed, started from, compared, saved as ZIP, removed; and
// the list of lineages: search, tags, hidden ones, covers. Ends with a first visit in a browser
// that has no lineage yet.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

import { poster } from "./server.mjs";

/** Marks individuals as favourites over the API. */
async function mark(base, individuals) {
  for (const { id } of individuals) {
    const path = `${base}/v1/individuals/${id}`;
    const etag = (await fetch(path)).headers.get("etag");
    const answer = await fetch(path, {
      method: "PATCH",
      headers: { "content-type": "application/json", "if-match": etag },
      body: JSON.stringify({ favourite: true }),
    });
    assert.equal(answer.status, 200);
  }
}

/** Makes a lineage with two favourites over the API; returns its first generation. */
async function lineageOf(base, name, seed) {
  const post = poster(base);
  const { id } = await post("/v1/lineages", { name, saturation: 0.65, tags: ["for the hall"] });
  const made = await post(`/v1/lineages/${id}/generations`, { parents: [], seed });
  await mark(base, made.individuals.slice(2, 4));
  return made;
}

/** Names of the entries of a ZIP file, from its local headers and directory. */
function namesIn(bytes) {
  const names = [];
  for (let at = bytes.indexOf("PK\x01\x02", 0, "latin1"); at >= 0;) {
    const length = bytes.readUInt16LE(at + 28);
    names.push(bytes.subarray(at + 46, at + 46 + length).toString("utf8"));
    at = bytes.indexOf("PK\x01\x02", at + 46, "latin1");
  }
  return names;
}

/** Runs the journey; `shot` saves a screenshot, `base` is the server's address. */
export async function favourites(app, step, shot, base) {
  const { page } = app;
  const dialog = app.id("favourites-dialog");
  const tile = ({ id }) => app.id(`favourite-${id}`);
  const ofTile = (of, name) => tile(of).getByTestId(name);
  // Both are wild: believable programs have another machine.
  const open = await poster(base)("/v1/lineages", { name: "Open" });
  await app.open(`#/lineage/${open.id}`);
  const other = await lineageOf(base, "Metals of others", 11);
  const [one, two] = other.individuals.slice(2, 4);

  await step("shows favourites of all lineages, large", async () => {
    await page.keyboard.press("v");
    await tile(one).waitFor();
    assert.match(page.url(), /\/favourites\/all$/);
    const loaded = (of) =>
      page.waitForFunction(
        (id) => {
          const large = document.querySelector(`[data-testid="favourite-${id}"] img.over`);
          return large?.complete && large.naturalWidth === 512;
        },
        of.id,
      );
    await Promise.all([loaded(one), loaded(two)]);
    await shot("favourites-1-all");
    await app.accessible("favourites");
    await app.fits(dialog);
  });

  await step("lists the favourites of one lineage, as the link says", async () => {
    await app.id("favourites-filter").selectOption(other.lineage);
    await page.waitForFunction(() => document.querySelectorAll(".tile").length === 2);
    const link = page.url();
    assert.ok(link.endsWith(`/favourites/${other.lineage}`), link);
    await page.reload();
    await page.waitForFunction(() => document.querySelectorAll(".tile").length === 2);
    await page.keyboard.press("Escape");
    await dialog.waitFor({ state: "hidden" });
    await page.waitForFunction(() => !location.hash.includes("favourites"));
    await page.goBack();
    await dialog.waitFor();
  });

  await step("saves chosen favourites as one ZIP file", async () => {
    await app.id("favourites-all").click();
    await app.id("archive").locator("summary").click();
    await app.id("archive-wgsl").check();
    await shot("favourites-2-archive");
    await app.accessible("favourites, download");
    await app.id("archive-side").fill("64");
    const [download] = await Promise.all([
      page.waitForEvent("download"),
      app.id("archive-save").click(),
    ]);
    assert.equal(download.suggestedFilename(), "metals-of-others-2.zip");
    const names = namesIn(await readFile(await download.path()));
    const expected = [two, one].flatMap(({ hash }) =>
      ["brood", "png", "wgsl"].map((ending) => `metals-of-others-${hash.slice(0, 4)}.${ending}`),
    );
    assert.deepEqual(names, [...expected, "manifest.json"]);
    await app.id("archive").locator("summary").click();
  });

  await step("compares chosen favourites side by side", async () => {
    await app.id("favourites-compare").click();
    await app.id("compared").locator("thead th").nth(1).waitFor();
    await app.id("comparison-close").click();
  });

  await step("crosses a favourite of another lineage with a frame", async () => {
    const here = await app.generation(await app.ready());
    assert.notEqual(here.lineage, other.lineage);
    await app.id("favourites").click();
    await ofTile(one, "favourite-mate").click();
    await app.id("mate-elsewhere").waitFor();
    await shot("favourites-3-mate");
    const child = await app.generation(await app.becomes(() => app.cell(4).click()));
    assert.equal(child.lineage, here.lineage);
    assert.equal(child.parents[0], here.individuals[4].id);
    const mate = await app.api(`/v1/individuals/${child.parents[1]}`);
    assert.deepEqual([mate.hash, mate.operator, mate.lineage], [one.hash, "adopt", here.lineage]);
  });

  await step("pins a favourite as B", async () => {
    await app.id("favourites").click();
    await ofTile(two, "favourite-pin").click();
    await app.id("compare-sides").waitFor();
    await page.keyboard.press("Escape");
    await app.id("compare-sides").waitFor({ state: "hidden" });
  });

  await step("shows a favourite in its lineage", async () => {
    await page.keyboard.press("v");
    await ofTile(one, "favourite-show").click();
    await app.shows(other.id);
    await page.waitForFunction(() => document.activeElement?.matches('[data-cell="2"]'));
    assert.ok(page.url().includes(other.lineage) && !page.url().includes("favourites"));
  });

  await step("makes a favourite the cover, removes one, and undoes it", async () => {
    await page.keyboard.press("v");
    await tile(one).getByText("More", { exact: true }).click();
    await ofTile(one, "favourite-cover").click();
    await page.locator('[data-testid="favourite-cover"][aria-pressed="true"]').waitFor();
    assert.equal((await app.api(`/v1/lineages/${other.lineage}`)).cover_individual, one.id);
    await shot("favourites-4-more");
    await ofTile(one, "favourite-remove").click();
    await tile(one).getByText("No longer a favourite.").waitFor();
    assert.equal((await app.api(`/v1/individuals/${one.id}`)).favourite, false);
    await tile(one).getByRole("button", { name: "Undo" }).click();
    await ofTile(one, "favourite-mate").waitFor();
    assert.equal((await app.api(`/v1/individuals/${one.id}`)).favourite, true);
  });

  await step("starts a new lineage from a favourite, in the same light", async () => {
    const scene = (await app.api(`/v1/lineages/${other.lineage}`)).scene;
    await app.becomes(() => ofTile(one, "favourite-start").click());
    await page.waitForFunction(() => document.title.startsWith("From Metals of others"));
    await dialog.waitFor({ state: "hidden" });
    const generation = await app.generation(await app.ready());
    const lineage = await app.api(`/v1/lineages/${generation.lineage}`);
    assert.deepEqual([lineage.name, lineage.scene], ["From Metals of others", scene]);
  });
  app.quiet();
}

/** The same on a narrow touch screen; a favourite was marked before. */
export async function favouritesByFinger(app, step, shot, base) {
  const { page } = app;
  const { individuals } = await app.generation(await app.ready());
  await mark(base, individuals.slice(5, 6));
  await step("shows favourites and marks a mate on a screen of 360 pixels", async () => {
    await app.id("favourites").tap();
    await page.locator(".tile").first().waitFor();
    await app.fits(app.id("favourites-dialog"));
    await app.id("archive").locator("summary").tap();
    await app.fits(app.id("favourites-dialog"));
    await app.accessible("favourites, 360 x 740");
    await shot("favourites-5-narrow");
    assert.ok(await page.locator("[data-testid=favourite-mate]:disabled").count(), "wild ones");
    await page.locator("[data-testid=favourite-mate]:enabled").first().tap();
    await app.id("favourites-dialog").waitFor({ state: "hidden" });
    await app.fits(page.locator("html"));
    await app.id("lineage-menu").tap();
    await app.fits(page.locator("dialog.of-lineages"));
    await shot("lineages-5-narrow");
    await page.keyboard.press("Escape");
  });
}

/** The list of lineages; after `favourites`. */
export async function lineages(app, step, shot) {
  const { page } = app;
  const list = page.locator("dialog.of-lineages");
  const rows = list.locator(".lineages li");
  const row = (name) => list.getByRole("listitem").filter({ hasText: name });

  await step("finds a lineage by its tag", async () => {
    await app.id("lineage-menu").click();
    await app.id("lineage-search").fill("HALL for");
    await page.waitForFunction(() => document.querySelectorAll(".lineages li").length === 1);
    assert.match(await rows.first().innerText(), /Metals of others/);
    await shot("lineages-1-search");
    await app.accessible("lineages");
    await app.id("lineage-search").fill("nothing has this");
    await list.getByText("No lineage has these words.").waitFor();
    await app.id("lineage-search").fill("");
    await row("From Metals").waitFor();
  });

  await step("changes name, tags and notes", async () => {
    await page.getByRole("button", { name: "Edit From Metals of others" }).click();
    await app.id("lineage-rename-name").fill("Brass");
    await app.id("lineage-tags").fill("metal, metal,  warm glow");
    await app.id("lineage-notes").fill("for the lamp");
    await shot("lineages-2-edit");
    await app.accessible("lineages, edit");
    await app.id("lineage-edit-save").click();
    await row("warm glow").waitFor();
    const { items } = await app.api("/v1/lineages?search=lamp%20brass");
    assert.deepEqual([items.length, items[0].tags], [1, ["metal", "warm glow"]]);
  });

  await step("hides a lineage and restores it", async () => {
    await page.getByRole("button", { name: "Hide Metals of others" }).click();
    await list.getByRole("button", { name: "Hide", exact: true }).click();
    await row("Metals of others").waitFor({ state: "hidden" });
    await app.id("lineage-hidden").check();
    await row("Metals of others").waitFor();
    await shot("lineages-3-hidden");
    await page.getByRole("button", { name: "Restore Metals of others" }).click();
    await row("Metals of others").waitFor({ state: "hidden" });
    await app.id("lineage-hidden").uncheck();
    await row("Metals of others").waitFor();
    await list.getByRole("button", { name: "Close" }).click();
  });

  await step("opens this browser's lineage again, and a new one in another browser", async () => {
    const before = (await app.generation(await app.ready())).lineage;
    await app.open();
    assert.equal((await app.generation(await app.ready())).lineage, before);
    await page.evaluate(() => localStorage.clear());
    await page.goto("about:blank");
    const generation = await app.generation(await app.open());
    const lineage = await app.api(`/v1/lineages/${generation.lineage}`);
    assert.notEqual(lineage.id, before);
    assert.match(lineage.name, /^Untitled \d+$/);
    await app.id("others").getByRole("button", { name: /^Show/ }).click();
    await row("Metals of others").waitFor();
    await shot("lineages-4-others");
    await page.keyboard.press("Escape");
    await app.id("others").waitFor({ state: "hidden" });
  });
  app.quiet();
}
