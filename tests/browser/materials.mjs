// Import and export of materials: presets, exports, genome files, whole lineages.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

/** Text of the file that the browser saves during an action. */
async function saved(page, act) {
  const [download] = await Promise.all([page.waitForEvent("download"), act()]);
  return readFile(await download.path(), "utf8");
}

/** Hash of the individual in the centre. */
async function centre(app, generation) {
  const { centre: of } = await app.generation(generation);
  return of.hash;
}

/** Waits for a complete brood other than the given one. */
export const around = (page, before) =>
  page.waitForFunction((not) => {
    const { ready } = document.body.dataset;
    return ready && ready !== not && document.querySelectorAll("[data-frame]").length === 21;
  }, before);

/** Opens a lineage whose shown generation is a complete brood. */
export async function goTo(app, lineage) {
  const last = await app.ready();
  await app.open(`#/lineage/${lineage}`);
  await around(app.page, last);
}

export async function materials(app, step, shot) {
  const { page } = app;

  await step("starts from a preset", async () => {
    await app.open();
    await page.getByRole("button", { name: "Presets" }).click();
    const gold = page.getByRole("button", { name: /^Gold Polished/ });
    await gold.locator("img").waitFor();
    await shot("10-presets");
    await app.accessible("presets");
    const before = await app.ready();
    await gold.click();
    // The preset alone, and then the brood around it.
    await around(page, before);
    const generation = await app.generation(await app.ready());
    assert.equal(generation.centre.operator, "adopt");
    assert.equal(generation.individuals.length, 20);
    await shot("11-gold");
  });

  let text;
  await step("exports what is in the centre", async () => {
    await page.getByText("Export", { exact: true }).click();
    text = await saved(page, () => page.getByRole("link", { name: /^\.brood/ }).click());
    assert.match(text, /^brood 1\n/);
    const glsl = await saved(page, () => page.getByRole("link", { name: /^GLSL ES 3.00/ }).click());
    assert.match(glsl, /vec3 evolved\(vec3 wi, vec3 wo/);
    const wgsl = await saved(page, () => page.getByRole("link", { name: /^WGSL/ }).click());
    assert.match(wgsl, /fn evolved\(wi: vec3f/);
    const commands = await app.id("commands-mitsuba").innerText();
    const [, file, url] = commands.match(/^pip install mitsuba\ncurl -f -o (brood_[0-9a-f]{8}\.py) '(http[^']+)'\npython \1 picture\.png$/) ?? [];
    assert.ok(file, commands);
    const plugin = await saved(page, () => page.getByRole("link", { name: /^Mitsuba 3 plugin/ }).click());
    assert.match(plugin, /^NAME = "brood_[0-9a-f]{8}"$/m);
    assert.equal(await (await fetch(url)).text(), plugin, "the command gets the same file");
    await shot("12-formats");
  });

  await step("breeds from a genome file", async () => {
    const before = await app.ready();
    const wanted = await centre(app, before);
    await app.becomes(() => app.cell(2).click());
    const file = { name: "kept.brood", mimeType: "text/plain", buffer: Buffer.from(text) };
    await app.id("lineage-menu").click();
    const last = await app.ready();
    await app.id("lineage-file").setInputFiles(file);
    await around(page, last);
    assert.equal(await centre(app, await app.ready()), wanted);
    const broken = { ...file, buffer: Buffer.from("brood 1\nFLY R0\n") };
    await app.id("lineage-menu").click();
    await app.id("lineage-file").setInputFiles(broken);
    const error = app.id("error");
    await error.waitFor({ state: "visible" });
    assert.match(await error.innerText(), /Line 2/);
    app.complaints = app.complaints.filter((words) => !words.includes("422"));
  });

  await step("opens a saved lineage again", async () => {
    const before = await app.generation(await app.ready());
    const response = await fetch(
      `${new URL(page.url()).origin}/v1/lineages/${before.lineage}/file`,
    );
    const file = {
      name: "history.json",
      mimeType: "application/json",
      buffer: Buffer.from(await response.arrayBuffer()),
    };
    await app.id("lineage-menu").click();
    const after = await app.generation(
      await app.becomes(() => app.id("lineage-file").setInputFiles(file)),
    );
    assert.notEqual(after.lineage, before.lineage);
    assert.deepEqual(
      after.individuals.map((it) => it.hash),
      before.individuals.map((it) => it.hash),
    );
  });
  app.quiet();
}

/** Turns the object in the centre with the mouse; `during` runs before the button is released. */
export async function turnByHand(app, during) {
  const { mouse } = app.page;
  const box = await app.id("centre").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await app.reshown(async () => {
    await mouse.move(x, y);
    await mouse.down();
    await mouse.move(x - 50, y + 10, { steps: 4 });
    await during();
    await mouse.up();
  });
}
