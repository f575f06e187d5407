// A lineage of more generations than the page holds whole: early ones are read again when visited.

import { strict as assert } from "node:assert";

import { poster } from "./server.mjs";

const COUNT = 80;

/** Makes a lineage in which each brood of three is bred from the one before; returns the broods. */
async function chain(base) {
  const post = poster(base);
  const { id } = await post("/v1/lineages", { name: "long", start: "models" });
  const broods = [];
  for (let seed = 0; seed < COUNT; seed += 1) {
    const parents = broods.slice(-1).map(({ individuals }) => individuals[1].id);
    broods.push(await post(`/v1/lineages/${id}/generations`, { parents, seed, count: 3 }));
  }
  return broods;
}

/** Runs the part of the journey; `base` is the server's address. */
export async function long(app, step, shot, base) {
  const { page } = app;
  const details = page.getByRole("complementary", { name: "Details" });
  const favourite = (name) => details.getByRole("button", { name, exact: true });
  const read = ({ id }) =>
    page.waitForResponse((it) => new URL(it.url()).pathname === `/v1/generations/${id}`);
  const broods = await chain(base);
  const early = broods[3];

  await step("shows the pictures of an early generation of a long lineage", async () => {
    await app.open(`#/lineage/${early.lineage}`);
    await app.shows(broods.at(-1).id);
    await app.id("history").evaluate((strip) => strip.scrollTo({ left: 0 }));
    await Promise.all([read(early), app.id("history-3").click()]);
    await app.shows(early.id);
    for (const { slot, thumbnail } of early.individuals)
      await app.cell(slot).locator(`img[src="${thumbnail}"]`).first().waitFor();
    await app.id("centre").locator(`img[src="${early.centre.thumbnail}"]`).first().waitFor();
    await shot("long-1-early");
  });

  await step("lists favourites of generations that are not held", async () => {
    // The centre was born in the generation before, which the event of the mark reads.
    await app.id("centre").focus();
    await Promise.all([read(broods[2]), page.keyboard.press("f")]);
    await favourite("Favourite 2 of generation 2").waitFor();
  });

  const child = await step("breeds from an early generation", async () => {
    const bred = await app.generation(await app.becomes(() => app.cell(2).click()));
    assert.deepEqual(bred.parents, [early.individuals[2].id]);
    return bred;
  });

  await step("undoes and redoes over generations that are not held, after a reload too", async () => {
    await page.reload();
    await app.shows(child.id);
    await favourite("Favourite 2 of generation 2").waitFor();
    await Promise.all([read(early), app.id("undo").click()]);
    await app.shows(early.id);
    await app.id("undo").click();
    await app.shows(broods.at(-1).id);
    await app.id("redo").click();
    await app.shows(early.id);
    await app.id("redo").click();
    await app.shows(child.id);
  });
  app.quiet();
}
