// Models of reflectance: bred, crossed and locked in a lineage; as presets and files; drawn live.

import { strict as assert } from "node:assert";
import { execFile } from "node:child_process";
import { promisify } from "node:util";

import { allLit, asServerDraws, hold, slide, underLamp } from "./live.mjs";
import { around } from "./materials.mjs";

const genome = (app, individual) => app.api(`/v1/genomes/${individual.hash}`);
const genomes = (app, generation) =>
  Promise.all(generation.individuals.map((one) => genome(app, one)));

/** Waits until the page describes the content of a frame. */
const told = (page, cell, words) =>
  page.waitForFunction(
    ([id, text]) =>
      document.querySelector(`[data-testid=${id}]`).getAttribute("aria-label").includes(text),
    [cell, words],
  );

/** Body of the next request for a brood. */
const asked = (page) =>
  page.waitForRequest((it) => it.method() === "POST" && it.url().endsWith("/generations"));

async function begin(app, name, kind) {
  await app.id("lineage-menu").click();
  await app.id("lineage-name").fill(name);
  await app.page.getByRole("radio", { name: kind }).check();
  if (kind === "models") await app.accessible("a new lineage");
  return app.generation(await app.becomes(() => app.id("lineage-new").click()));
}

/** Crosses the centre with a preset; returns the brood. */
async function crossed(app, preset) {
  await app.id("presets").click();
  await app.page.getByRole("radio", { name: "cross with the centre" }).check();
  const before = await app.ready();
  await app.id(`preset-${preset}`).click();
  await around(app.page, before);
  return app.generation(await app.ready());
}

/** Runs the journey; `shot` saves a screenshot. */
export async function models(app, step, shot, binary) {
  const { page } = app;
  const details = page.getByRole("complementary", { name: "Details" });

  const first = await step("starts a lineage of models", async () => {
    const generation = await begin(app, "only models", "models");
    const made = await genomes(app, generation);
    assert.ok(made.every((one) => one.instructions.length === 0 && one.layers.length > 0));
    assert.match(await app.id("lineage-menu").innerText(), /models/);
    await told(page, "cell-19", made[19].layers[0].model);
    return generation;
  });

  const child = await step("breeds models by click, and crosses two", async () => {
    const bred = await app.generation(await app.becomes(() => app.cell(3).click()));
    assert.deepEqual(bred.parents, [first.individuals[3].id]);
    await app.cell(2).click({ button: "right" });
    const mixed = await app.generation(await app.becomes(() => app.cell(7).click()));
    assert.deepEqual(mixed.parents, [bred.individuals[7].id, bred.individuals[2].id]);
    assert.equal(mixed.individuals[0].operator, "recombine");
    assert.ok((await genomes(app, mixed)).every((one) => one.layers.length > 0));
    return mixed;
  });

  await step("locks a parameter, and children keep it", async () => {
    const { layers } = await genome(app, child.centre);
    const table = details.getByTestId("layers");
    await table.waitFor();
    assert.equal(await table.locator("caption").first().innerText(), layers[0].model);
    assert.equal(
      await table.locator("table").first().locator("tr").count(),
      Object.keys(layers[0].parameters).length,
    );
    const name = await table.locator("tr").first().getAttribute("data-parameter");
    await page
      .getByRole("button", { name: `Lock ${name.replaceAll("_", " ")} of model 1`, exact: true })
      .click();
    await app.id("lock-sign").filter({ hasText: "1 parameter locked" }).waitFor();
    await shot("38-models");
    await app.accessible("models");
    const request = asked(page);
    const kept = await app.generation(await app.becomes(() => app.id("centre").click()));
    const parameters = [{ layer: 0, name }];
    assert.deepEqual((await request).postDataJSON().locks.parameters, parameters);
    assert.deepEqual(kept.locks.parameters, parameters);
    for (const one of await genomes(app, kept))
      assert.deepEqual(one.layers[0].parameters[name], layers[0].parameters[name]);
  });

  await step("removes locks that name parts a parent does not have", async () => {
    const { stdout } = await promisify(execFile)(binary, ["preset", "model-two-layers"]);
    const file = { name: "wood.brood", mimeType: "text/plain", buffer: Buffer.from(stdout) };
    const before = await app.ready();
    await app.id("lineage-menu").click();
    await app.id("lineage-file").setInputFiles(file);
    await around(page, before);
    const { centre } = await app.generation(await app.ready());
    assert.deepEqual(
      (await genome(app, centre)).layers.map((one) => one.model),
      ["lambert", "ward", "cook-torrance"],
    );
    assert.equal(await app.id("lock-sign").count(), 0);
    await details.getByRole("button", { name: "Lock roughness of model 3" }).click();
    await app.becomes(() => app.id("history-0").click());
    const request = asked(page);
    await app.becomes(() => app.cell(5).click());
    assert.equal((await request).postDataJSON().locks, undefined);
    await page
      .locator("[data-testid=error][data-place=locks]")
      .filter({ hasText: "roughness of model 3" })
      .waitFor();
    assert.equal(await app.id("lock-sign").count(), 0);
  });

  await step("inspects a model, and exports it as a shader function", async () => {
    await app.id("centre").focus();
    await page.keyboard.press("i");
    const inspector = app.id("inspector");
    await inspector.getByRole("region", { name: "Parameters" }).waitFor();
    assert.equal(await inspector.getByText(/instruction/i).count(), 0);
    await shot("39-model-inspected");
    await app.accessible("a model in the inspector");
    await page.keyboard.press("Escape");
    await inspector.waitFor({ state: "detached" });
    await page.getByText("Export", { exact: true }).click();
    const link = await app.id("export-glsl-es-300").getAttribute("href");
    const source = await (await page.request.get(new URL(link, page.url()).href)).text();
    assert.match(source, /vec3 evolved_models\(vec3 wi, vec3 wo\)/);
    await page.getByText("Export", { exact: true }).click();
  });

  await step("crosses a program with the preset of a model", async () => {
    const before = await begin(app, "mixed", "wild");
    const mixed = await crossed(app, "model-two-layers");
    assert.equal(mixed.parents[0], before.individuals[0].id);
    const made = await genomes(app, mixed);
    const both = made.findIndex((one) => one.instructions.length > 0 && one.layers?.length > 0);
    assert.ok(both >= 0, "some child is a program with models over it");
    await told(page, `cell-${both}`, made[both].layers[0].model);
    await app.cell(both).focus();
    await page.keyboard.press("b");
    await page
      .getByRole("row", { name: /^models none/ })
      .filter({ hasText: made[both].layers[0].model })
      .waitFor();
    await shot("40-program-and-models");
    await page.keyboard.press("Escape");
  });
  app.quiet();
}

/** Compares live frames of models and programs with the server's pictures. */
export async function modelsLive(app, step, shot, base) {
  const { page } = app;
  await step("draws models live like the server", async () => {
    // Stripes of random programs may be finer than a pixel.
    await begin(app, "mixed and live", "presets");
    const mixed = await crossed(app, "model-plastic");
    assert.ok((await genomes(app, mixed)).some((one) => one.layers?.length > 0));
    // With automatic exposure, the light of each picture would matter (docs/maths/film.md).
    // The ball has more borders that only the server antialiases.
    await app.reshown(() => app.id("object").selectOption("sphere"));
    await underLamp(app);
    await app.reshown(() => slide(app, "exposure", -1));
    await hold(app, "light", 75);
    await allLit(page);
    const text = await asServerDraws(app, mixed, 75, base);
    assert.equal(await app.id("stills").count(), 0);
    await shot("41-models-live");
    await app.reshown(() => slide(app, "light", 10));
    await page.waitForFunction(
      () => document.querySelectorAll("img.still, .pictures.lit").length === 0,
    );
    return text;
  });
  await step("draws every kind of model live", async () => {
    const kindsOf = async (generation) =>
      new Set(
        (await genomes(app, generation)).flatMap((one) => one.layers.map((layer) => layer.model)),
      );
    let generation = await begin(app, "models and live", "models");
    let kinds = await kindsOf(generation);
    // 21 random models of 15 kinds are sometimes of eight.
    for (let again = 0; kinds.size <= 8 && again < 3; again += 1) {
      generation = await begin(app, `models and live ${again}`, "models");
      kinds = await kindsOf(generation);
    }
    assert.ok(kinds.size > 8, `${[...kinds]}`);
    await app.reshown(() => app.id("object").selectOption("sphere"));
    await underLamp(app);
    await app.reshown(() => slide(app, "exposure", -1));
    await hold(app, "light", 40);
    await allLit(page);
    const text = await asServerDraws(app, generation, 40, base);
    await shot("41-only-models-live");
    await app.reshown(() => slide(app, "light", 10));
    return text;
  });
}
