// Models of reflectance: a lineage of them, bred, crossed and locked; presets and files of them; live frames of them.

import { strict as assert } from "node:assert";
import { execFile } from "node:child_process";
import { promisify } from "node:util";

import { allLit, asServerDraws, slide } from "./live.mjs";
import { around } from "./materials.mjs";

const genome = (hand, individual) => hand.api(`/v1/genomes/${individual.hash}`);
const genomes = (hand, generation) => Promise.all(generation.individuals.map((one) => genome(hand, one)));

/** Waits until the page says what is in a frame. */
const told = (page, cell, words) =>
  page.waitForFunction(([id, text]) => document.querySelector(`[data-testid=${id}]`).getAttribute("aria-label").includes(text), [cell, words]);

/** The body of the next request for a brood. */
const asked = (page) => page.waitForRequest((it) => it.method() === "POST" && it.url().endsWith("/generations"));

async function begin(hand, name, kind) {
  await hand.id("lineage-menu").click();
  await hand.id("lineage-name").fill(name);
  await hand.page.getByRole("radio", { name: kind }).check();
  if (kind === "models") await hand.accessible("a new lineage");
  return hand.generation(await hand.becomes(() => hand.id("lineage-new").click()));
}

/** Crosses the centre with a preset, and gives the brood. */
async function crossed(hand, preset) {
  await hand.id("presets").click();
  await hand.page.getByRole("radio", { name: "cross with the centre" }).check();
  const before = await hand.ready();
  await hand.id(`preset-${preset}`).click();
  await around(hand.page, before);
  return hand.generation(await hand.ready());
}

/** The journey; `shot` takes a picture of the page. */
export async function models(hand, step, shot, binary) {
  const { page } = hand;
  const details = page.getByRole("complementary", { name: "Details" });

  const first = await step("starts a lineage of models", async () => {
    const generation = await begin(hand, "only models", "models");
    const made = await genomes(hand, generation);
    assert.ok(made.every((one) => one.instructions.length === 0 && one.layers.length > 0));
    assert.match(await hand.id("lineage-menu").innerText(), /models/);
    await told(page, "cell-19", made[19].layers[0].model);
    return generation;
  });

  const child = await step("breeds models by click, and crosses two", async () => {
    const bred = await hand.generation(await hand.becomes(() => hand.cell(3).click()));
    assert.deepEqual(bred.parents, [first.individuals[3].id]);
    await hand.cell(2).click({ button: "right" });
    const mixed = await hand.generation(await hand.becomes(() => hand.cell(7).click()));
    assert.deepEqual(mixed.parents, [bred.individuals[7].id, bred.individuals[2].id]);
    assert.equal(mixed.individuals[0].operator, "recombine");
    assert.ok((await genomes(hand, mixed)).every((one) => one.layers.length > 0));
    return mixed;
  });

  await step("locks a parameter, and children keep it", async () => {
    const { layers } = await genome(hand, child.centre);
    const table = details.getByTestId("layers");
    await table.waitFor();
    assert.equal(await table.locator("caption").first().innerText(), layers[0].model);
    assert.equal(await table.locator("table").first().locator("tr").count(), Object.keys(layers[0].parameters).length);
    const name = await table.locator("tr").first().getAttribute("data-parameter");
    await page.getByRole("button", { name: `Lock ${name.replaceAll("_", " ")} of model 1`, exact: true }).click();
    await hand.id("lock-sign").filter({ hasText: "1 parameter locked" }).waitFor();
    await shot("38-models");
    await hand.accessible("models");
    const request = asked(page);
    const kept = await hand.generation(await hand.becomes(() => hand.id("centre").click()));
    const parameters = [{ layer: 0, name }];
    assert.deepEqual((await request).postDataJSON().locks.parameters, parameters);
    assert.deepEqual(kept.locks.parameters, parameters);
    for (const one of await genomes(hand, kept)) assert.deepEqual(one.layers[0].parameters[name], layers[0].parameters[name]);
  });

  await step("lets go of locks that name what a parent does not have", async () => {
    const { stdout } = await promisify(execFile)(binary, ["preset", "model-two-layers"]);
    const file = { name: "wood.brood", mimeType: "text/plain", buffer: Buffer.from(stdout) };
    const before = await hand.ready();
    await hand.id("lineage-menu").click();
    await hand.id("lineage-file").setInputFiles(file);
    await around(page, before);
    const { centre } = await hand.generation(await hand.ready());
    assert.deepEqual((await genome(hand, centre)).layers.map((one) => one.model), ["lambert", "ward", "cook-torrance"]);
    assert.equal(await hand.id("lock-sign").count(), 0);
    await details.getByRole("button", { name: "Lock roughness of model 3" }).click();
    await hand.becomes(() => hand.id("history-0").click());
    const request = asked(page);
    await hand.becomes(() => hand.cell(5).click());
    assert.equal((await request).postDataJSON().locks, undefined);
    await page.locator("[data-testid=error][data-place=locks]").filter({ hasText: "roughness of model 3" }).waitFor();
    assert.equal(await hand.id("lock-sign").count(), 0);
  });

  await step("looks into a model, and exports it as a shader function", async () => {
    await hand.id("centre").focus();
    await page.keyboard.press("i");
    const inspector = hand.id("inspector");
    await inspector.getByRole("region", { name: "Parameters" }).waitFor();
    assert.equal(await inspector.getByText(/instruction/i).count(), 0);
    await shot("39-model-inspected");
    await hand.accessible("a model in the inspector");
    await page.keyboard.press("Escape");
    await page.getByText("Export", { exact: true }).click();
    const link = await hand.id("export-glsl-es-300").getAttribute("href");
    const source = await (await page.request.get(new URL(link, page.url()).href)).text();
    assert.match(source, /vec3 evolved_models\(vec3 wi, vec3 wo\)/);
    await page.getByText("Export", { exact: true }).click();
  });

  await step("crosses a program with the preset of a model", async () => {
    const before = await begin(hand, "mixed", "programs");
    const mixed = await crossed(hand, "model-two-layers");
    assert.equal(mixed.parents[0], before.individuals[0].id);
    const made = await genomes(hand, mixed);
    const both = made.findIndex((one) => one.instructions.length > 0 && one.layers?.length > 0);
    assert.ok(both >= 0, "some child is a program with models over it");
    await told(page, `cell-${both}`, made[both].layers[0].model);
    await hand.cell(both).focus();
    await page.keyboard.press("b");
    await page.getByRole("row", { name: /^models none/ }).filter({ hasText: made[both].layers[0].model }).waitFor();
    await shot("40-program-and-models");
    await page.keyboard.press("Escape");
  });
  hand.quiet();
}

/** Models are drawn live beside programs, as the server draws them. */
export async function modelsLive(hand, step, shot, base) {
  const { page } = hand;
  await step("draws models live, as the server does", async () => {
    await begin(hand, "mixed and live", "programs");
    const mixed = await crossed(hand, "model-plastic");
    assert.ok((await genomes(hand, mixed)).some((one) => one.layers?.length > 0));
    // At an exposure of its own each picture's light would count, as docs/maths/film.md has it.
    await hand.reshown(() => slide(hand, "exposure", -1));
    await slide(hand, "light", 75);
    await allLit(page);
    const text = await asServerDraws(hand, mixed, 75, base);
    assert.equal(await hand.id("stills").count(), 0);
    await shot("41-models-live");
    await slide(hand, "light", 0);
    await page.waitForFunction(() => document.querySelectorAll("img.still, .pictures.lit").length === 0);
    return text;
  });
  await step("draws every kind of model live", async () => {
    const generation = await begin(hand, "models and live", "models");
    const kinds = new Set((await genomes(hand, generation)).flatMap((one) => one.layers.map((layer) => layer.model)));
    assert.ok(kinds.size > 8, `${[...kinds]}`);
    await hand.reshown(() => slide(hand, "exposure", -1));
    await slide(hand, "light", 40);
    await allLit(page);
    const text = await asServerDraws(hand, generation, 40, base);
    await shot("41-only-models-live");
    await slide(hand, "light", 0);
    return text;
  });
}
