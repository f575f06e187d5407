// Parameters of models edited by hand: slider, colour, typed value, choice; stored as a child; bred
// on and undone. Without WebGL and with it, by mouse, by keyboard and on a narrow screen.

import { strict as assert } from "node:assert";

import { hold, underLamp } from "./live.mjs";
import { around } from "./materials.mjs";
import { onPixels } from "./pixels.mjs";
import { poster } from "./server.mjs";

const genome = (app, individual) => app.api(`/v1/genomes/${individual.hash}`);
/** The individual in the centre of a generation. */
const inCentre = (generation) => generation.centre ?? generation.individuals[0];

/** Starts a lineage from a preset of a model. */
async function begin(app, preset) {
  const before = await app.ready();
  await app.id("presets").click();
  await app.page.getByRole("radio", { name: "begin a lineage" }).check();
  await app.id(`preset-${preset}`).click();
  await around(app.page, before);
  return app.generation(await app.ready());
}

/** Opens the controls, unless they are open. */
async function edit(app) {
  if (!(await app.id("editor").isVisible())) await app.id("edit").click();
  await app.id("editor").waitFor();
}

/** Picture of the centre as it is seen. */
export const seen = (app) => app.id("centre").screenshot();

/** Share of the pixels of two pictures that differ. */
export const change = (page, before, after) =>
  onPixels(
    page,
    [before, after],
    ([a, b]) => {
      let off = 0;
      for (let at = 0; at < a.data.length; at += 4)
        if ([0, 1, 2].some((k) => Math.abs(a.data[at + k] - b.data[at + k]) > 6)) off += 1;
      return (4 * off) / a.data.length;
    },
    null,
  );

/** Waits until the server's picture of a draft other than `before` is shown. */
async function drawnDraft(app, before) {
  const not = before ? `:not([src="${before}"])` : "";
  const picture = app.page.locator(`[data-testid=draft-picture]${not}`);
  await picture.waitFor();
  await picture.evaluate((image) => image.decode());
  return picture.getAttribute("src");
}

const isAtRest = (page) =>
  page.waitForFunction(
    () => document.querySelector("[data-testid=edit-child]")?.getAttribute("aria-disabled") === "true",
  );

/** Runs the journey; `shot` saves a screenshot. */
export async function edited(app, step, shot) {
  const { page } = app;
  const details = page.getByRole("complementary", { name: "Details" });

  const start = await step("shows controls for the parameters of a model", async () => {
    const generation = await begin(app, "model-two-layers");
    await edit(app);
    const { layers } = await genome(app, generation.centre);
    const names = layers.flatMap((one) => Object.keys(one.parameters));
    assert.equal(await app.id("editor").locator(".parameter").count(), names.length);
    assert.equal(await app.id("draft-picture").count(), 0);
    await isAtRest(page);
    await shot("42-edit");
    await app.accessible("parameters");
    return generation;
  });

  await step("changes the centre's picture by slider, and stores nothing", async () => {
    const field = app.id("field-2-roughness-0");
    const before = await field.inputValue();
    const requests = page.waitForRequest((it) => it.url().includes("/v1/render.png"));
    await app.id("slide-2-roughness-0").focus();
    await page.keyboard.press("PageUp");
    assert.notEqual(await field.inputValue(), before);
    await requests;
    await drawnDraft(app, "");
    await app.id("edit-badge").waitFor();
    assert.match(await app.id("centre").getAttribute("aria-label"), /edited, not stored/);
    const { generations } = await app.api(`/v1/lineages/${start.lineage}`);
    assert.equal(generations, 2, "the preset and its brood");
  });

  await step("brings the stored parameters back", async () => {
    await app.id("edit-reset").click();
    await isAtRest(page);
    await app.id("edit-badge").waitFor({ state: "detached" });
    await app.id("draft-picture").waitFor({ state: "detached" });
  });

  await step("explains a wrong value beside its field, and keeps the text", async () => {
    const field = app.id("field-2-roughness-0");
    const before = await field.inputValue();
    for (const [text, words] of [
      ["2", "roughness must be between 0.0001 and 1, got 2"],
      ["shiny", "roughness must be a number between 0.0001 and 1, got “shiny”"],
    ]) {
      await field.fill(text);
      await field.press("Enter");
      assert.equal(await app.id("wrong-2-roughness-0").innerText(), words);
      assert.equal(await field.inputValue(), text);
      assert.equal(await field.getAttribute("aria-invalid"), "true");
    }
    await app.accessible("a wrong value");
    assert.equal(await app.id("draft-picture").count(), 0, "the value before is kept");
    await shot("43-edit-wrong");
    await app.id("edit-child").click();
    const refusal = page.locator("[data-testid=error][data-place=edit]");
    await refusal.filter({ hasText: "roughness must be a number" }).waitFor();
    await app.id("edit-reset").click();
    await refusal.waitFor({ state: "detached" });
    assert.equal(await field.inputValue(), before);
  });

  const child = await step("stores slider, colour, typed value and choice as a child", async () => {
    await hold(app, "slide-2-roughness-0", 0.9);
    await app.id("color-0-albedo-0").fill("#3366cc");
    await app.id("field-2-f0-1").fill("0,25");
    await app.id("choice-2-distribution-0").selectOption("beckmann");
    await app.id("field-2-f0-1").blur();
    assert.equal(await app.id("field-2-f0-1").inputValue(), "0.25");
    const made = await app.generation(await app.becomes(() => app.id("edit-child").click()));
    assert.deepEqual(made.parents, [start.centre.id]);
    assert.equal(made.individuals.length, 1);
    const [one] = made.individuals;
    const [before, after] = [await genome(app, start.centre), await genome(app, one)];
    const [albedo, { roughness, f0, distribution }] = [0, 2].map((at) => after.layers[at].parameters);
    assert.equal(roughness, 0.398);
    assert.equal(distribution, "beckmann");
    assert.equal(f0[1], 0.25);
    assert.equal(f0[0], before.layers[2].parameters.f0[0]);
    assert.deepEqual(albedo.albedo, [0.0331, 0.1329, 0.6038]);
    assert.deepEqual(after.layers[1], before.layers[1]);
    // The child is in the centre, and its values are those to edit next.
    await details.getByText("editing its parent").waitFor();
    await isAtRest(page);
    assert.equal(await app.id("field-2-roughness-0").inputValue(), "0.398");
    assert.equal(await app.id("edit-badge").count(), 0);
    await shot("44-edited-child");
    return one;
  });

  await step("breeds on from the edited child, whose ancestors are known", async () => {
    const bred = await app.generation(await app.becomes(() => app.id("centre").click()));
    assert.deepEqual(bred.parents, [child.id]);
    assert.equal(bred.individuals.length, 20);
    const found = await app.api(`/v1/individuals/${bred.individuals[0].id}/ancestry`);
    const ancestors = (found.items ?? found).map((one) => one.id);
    assert.deepEqual(ancestors.slice(0, 2), [child.id, start.centre.id]);
  });

  await step("undoes and redoes the edit", async () => {
    await app.id("undo").click();
    await details.getByText("editing its parent").waitFor();
    await app.id("undo").click();
    await app.shows(start.id);
    await isAtRest(page);
    const { layers } = await genome(app, start.centre);
    assert.equal(Number(await app.id("field-2-roughness-0").inputValue()), layers[2].parameters.roughness);
    await app.id("redo").click();
    await details.getByText("editing its parent").waitFor();
    await app.id("undo").click();
    await app.shows(start.id);
  });

  await step("keeps an edit that was not stored while other frames are bred", async () => {
    await isAtRest(page);
    await hold(app, "slide-2-roughness-0", 0.2);
    const value = await app.id("field-2-roughness-0").inputValue();
    await app.becomes(() => app.cell(4).click());
    await isAtRest(page);
    await app.id("undo").click();
    await app.shows(start.id);
    await app.id("edit-badge").waitFor();
    assert.equal(await app.id("field-2-roughness-0").inputValue(), value);
  });

  await step("breeds from the edited centre, which becomes a child first", async () => {
    const value = Number(await app.id("field-2-roughness-0").inputValue());
    const before = await app.ready();
    await app.id("centre").focus();
    await page.keyboard.press("Enter");
    await around(page, before);
    const bred = await app.generation(await app.ready());
    const { layers } = await genome(app, inCentre(bred));
    assert.equal(layers[2].parameters.roughness, value);
    assert.deepEqual(bred.centre.parents, [start.centre.id]);
    await app.id("edit").click();
    await app.id("editor").waitFor({ state: "detached" });
    assert.equal(await details.getByTestId("layers").count(), 1);
  });
  app.quiet();
}

/** Draws the edit live. */
export async function editedLive(app, step, shot, base) {
  const { page } = app;

  /** Drags the roughness, and waits for the centre to follow; returns the median time in ms. */
  async function followed() {
    const centreLit = () =>
      page.waitForFunction(() => document.querySelector("[data-cell=centre] .pictures.lit"));
    const before = await seen(app);
    await hold(app, "slide-0-roughness-0", 0.5);
    await centreLit();
    assert.equal(await page.evaluate(() => document.querySelectorAll(".pictures.lit").length), 1);
    const narrow = await seen(app);
    assert.ok((await change(page, before, narrow)) > 0.02, "the picture follows the slider");
    const times = [];
    for (const at of [0.95, 0.6, 0.9, 0.65, 0.85]) {
      const last = await seen(app);
      const start = performance.now();
      await hold(app, "slide-0-roughness-0", at);
      while ((await change(page, last, await seen(app))) < 0.005)
        assert.ok(performance.now() - start < 30_000, `the picture follows the slider to ${at}`);
      times.push(performance.now() - start);
    }
    return Math.round(times.sort((a, b) => a - b)[2]);
  }

  await step("draws an edited parameter live in the studio", async () => {
    await begin(app, "model-gold");
    if (!(await app.id("edit").isVisible())) await app.id("details-toggle").click();
    await edit(app);
    const ms = await followed();
    assert.equal(await app.id("draft-picture").count(), 0);
    await shot("45-edit-live-studio");
    await app.id("edit-reset").click();
    console.log(`${ms} ms from drag to picture in the studio`);
  });

  await step("shows the server's picture of an anisotropic edit in the studio", async () => {
    const send = poster(base);
    const answer = await fetch(`${base}/v1/genomes`, {
      method: "POST",
      headers: { "content-type": "text/x-brood" },
      body: "brood 1\n.model ward\nalpha_x 0.1\nalpha_y 0.4\n",
    });
    const genomes = [(await answer.json()).hash];
    const lights = [{}, { kind: "environment", image: "studio", fixed: true }];
    const { id: scene } = await send("/v1/scenes", { lights });
    const { id } = await send("/v1/lineages", { name: "Brushed", scene });
    await send(`/v1/lineages/${id}/adoptions`, { genomes });
    await app.becomes(() => app.open(`#/lineage/${id}`));
    await page.getByText("alpha x").waitFor();
    await edit(app);
    const [slider] = await app.id("editor").locator("input[type=range]").all();
    await slider.focus();
    await page.keyboard.press("ArrowRight");
    await drawnDraft(app, "");
    assert.equal(await page.evaluate(() => document.querySelectorAll(".pictures.lit").length), 0);
    await app.id("edit-reset").click();
    await app.id("draft-picture").waitFor({ state: "detached" });
  });

  await step("draws an edited parameter live while it is dragged", async () => {
    await begin(app, "model-gold");
    await underLamp(app);
    await edit(app);
    const ms = await followed();
    await shot("45-edit-live");
    const stored = await app.becomes(() => app.id("edit-child").click());
    const made = await app.generation(stored);
    assert.equal(made.individuals.length, 1);
    await page.waitForFunction(() => document.querySelectorAll(".pictures.lit").length === 0);
    console.log(`${ms} ms from drag to picture`);
  });

  await step("shows the server's picture of an edit where the scene cannot be drawn live", async () => {
    await app.reshown(() => app.id("light-kind").selectOption("sphere"));
    await hold(app, "slide-0-roughness-0", 0.4);
    const first = await drawnDraft(app, "");
    await hold(app, "slide-0-roughness-0", 0.7);
    await drawnDraft(app, first);
    await app.id("edit-reset").click();
    await app.id("draft-picture").waitFor({ state: "detached" });
    await app.reshown(() => app.id("light-kind").selectOption("point"));
  });
}

/** Edits on a screen of 360 pixels. */
export async function editedByFinger(app, step, shot) {
  const { page } = app;
  await step("edits parameters on a screen of 360 pixels", async () => {
    await begin(app, "model-plastic");
    await app.id("details-toggle").tap();
    await app.id("edit").tap();
    const editor = app.id("editor");
    await editor.waitFor();
    await app.fits(page.getByRole("complementary", { name: "Details" }));
    await app.id("editor").scrollIntoViewIfNeeded();
    await app.accessible("parameters, 360 x 740");
    const [slider] = await editor.locator("input[type=range]").all();
    await slider.focus();
    await page.keyboard.press("PageDown");
    await app.id("edit-badge").waitFor();
    await shot("46-edit-narrow");
    const made = await app.generation(await app.becomes(() => app.id("edit-child").tap()));
    assert.equal(made.individuals[0].operator, "adopt");
    await page.getByRole("button", { name: "Close the details" }).tap();
    await shot("47-edited-narrow");
  });
}
