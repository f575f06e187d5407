// Painted materials: a lineage of them, bred, crossed and locked; what is only of BRDFs is off.

import { strict as assert } from "node:assert";

/** Effects of an individual, as the server writes them. */
const effects = async (app, { hash }) => (await app.api(`/v1/genomes/${hash}`)).effects;

/** Runs the part of the journey; `shot` saves a screenshot. */
export async function painted(app, step, shot) {
  const { page } = app;
  const details = page.getByRole("complementary", { name: "Details" });

  const first = await step("starts a lineage of painted materials", async () => {
    await app.id("lineage-menu").click();
    await app.id("lineage-name").fill("toons");
    await page.getByRole("radio", { name: "painted" }).check();
    const generation = await app.generation(await app.becomes(() => app.id("lineage-new").click()));
    for (const one of generation.individuals)
      assert.equal((await effects(app, one))[0].kind, "light");
    return generation;
  });

  await step("shows palettes, and why functions of BRDFs are off", async () => {
    const light = details.getByTestId("effects").locator("[data-effect=light]");
    const [{ parameters }] = await effects(app, first.individuals[0]);
    const swatches = light.locator("[data-parameter=palette] .swatch");
    await swatches.first().waitFor();
    assert.equal(await swatches.count(), parameters.palette.length);
    assert.equal(await swatches.first().getAttribute("title"), parameters.palette[0]);
    await details.getByTestId("painted-note").waitFor();
    for (const id of ["inspect", "search-from", "steer-warmer", "saturation", "energy-limit"])
      assert.ok(await app.id(id).isDisabled(), `${id} is off`);
    await app.id("exports").locator("summary").click();
    await app.id("export-vrm-mtoon").waitFor();
    const [code] = await Promise.all([
      page.waitForResponse((it) => it.url().includes("/exports/glsl-es-300?lights=")),
      page.waitForEvent("download"),
      app.id("export-glsl-es-300").click(),
    ]);
    assert.match(await code.text(), /vec3 styled\(StyledPoint at/);
    assert.equal(await app.id("export-limited").count(), 0);
    await app.id("exports").locator("summary").click();
    await shot("39-painted");
    await app.accessible("painted");
  });

  await step("breeds painted materials that keep a locked palette", async () => {
    await page.getByRole("button", { name: "Lock palette of light", exact: true }).click();
    await app.id("lock-sign").filter({ hasText: "1 parameter of an effect locked" }).waitFor();
    const bred = await app.generation(await app.becomes(() => app.id("centre").click()));
    const [{ parameters }] = await effects(app, bred.centre);
    for (const one of bred.individuals) {
      const [light] = await effects(app, one);
      assert.deepEqual(light.parameters.palette, parameters.palette);
    }
    await app.id("locks-unlock").click();
    await app.cell(2).click({ button: "right" });
    const mixed = await app.generation(await app.becomes(() => app.cell(7).click()));
    assert.equal(mixed.individuals[0].operator, "recombine");
    assert.ok((await effects(app, mixed.individuals[0])).length > 0);
  });

  await step("makes a toon shape of a BRDF", async () => {
    await app.id("lineage-menu").click();
    await app.id("lineage-name").fill("toon shapes");
    await page.getByRole("radio", { name: "models" }).check();
    const models = await app.generation(await app.becomes(() => app.id("lineage-new").click()));
    const made = await app.generation(await app.becomes(() => app.id("toon-shape").click()));
    const [one] = made.individuals;
    assert.deepEqual(made.parents, [models.centre.id]);
    const [light] = await effects(app, one);
    assert.equal(light.parameters.by, "brdf");
    await details.getByTestId("painted-note").filter({ hasText: "paints what its BRDF" }).waitFor();
    await app.id("exports").locator("summary").click();
    await app.id("export-by-brdf").waitFor();
    await app.id("exports").locator("summary").click();
    assert.ok(!(await app.id("energy-limit").isDisabled()), "the limit acts on the BRDF");
    const bred = await app.generation(await app.becomes(() => app.id("centre").click()));
    for (const child of bred.individuals)
      assert.equal((await effects(app, child))[0].parameters.by, "brdf");
    await shot("39-toon-shapes");
  });
}
