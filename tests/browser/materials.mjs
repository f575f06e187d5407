// Materials that come and go: presets, exports, genome files, whole lineages.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

/** The text of the file that the browser saves when this is done. */
async function saved(page, act) {
  const [download] = await Promise.all([page.waitForEvent("download"), act()]);
  return readFile(await download.path(), "utf8");
}

/** The hash of the individual in the centre. */
async function centre(hand, generation) {
  const { centre: of } = await hand.generation(generation);
  return of.hash;
}

/** Waits for a whole brood, another than the one named. */
export const around = (page, before) =>
  page.waitForFunction((not) => {
    const { ready } = document.body.dataset;
    return ready && ready !== not && document.querySelectorAll("[data-frame]").length === 21;
  }, before);

export async function materials(hand, step, shot) {
  const { page } = hand;

  await step("starts from a preset", async () => {
    await hand.open();
    await page.getByRole("button", { name: "Presets" }).click();
    const gold = page.getByRole("button", { name: /^Gold Polished/ });
    await gold.locator("img").waitFor();
    await shot("10-presets");
    await hand.accessible("presets");
    const before = await hand.ready();
    await gold.click();
    // The preset alone, and the brood around it, come one after the other.
    await around(page, before);
    const generation = await hand.generation(await hand.ready());
    assert.equal(generation.centre.operator, "adopt");
    assert.equal(generation.individuals.length, 20);
    await shot("11-gold");
  });

  let text;
  await step("exports what is in the centre", async () => {
    await page.getByText("Export", { exact: true }).click();
    text = await saved(page, () => page.getByRole("button", { name: /\.brood/ }).click());
    assert.match(text, /^brood 1\n/);
    const glsl = await saved(page, () => page.getByRole("link", { name: /^GLSL ES 3.00/ }).click());
    assert.match(glsl, /vec3 evolved\(vec3 wi, vec3 wo/);
    const wgsl = await saved(page, () => page.getByRole("link", { name: /^WGSL/ }).click());
    assert.match(wgsl, /fn evolved\(wi: vec3f/);
  });

  await step("breeds from a genome file", async () => {
    const before = await hand.ready();
    const wanted = await centre(hand, before);
    await hand.becomes(() => hand.cell(2).click());
    const file = { name: "kept.brood", mimeType: "text/plain", buffer: Buffer.from(text) };
    await hand.id("lineage-menu").click();
    const last = await hand.ready();
    await hand.id("lineage-file").setInputFiles(file);
    await around(page, last);
    assert.equal(await centre(hand, await hand.ready()), wanted);
    const broken = { ...file, buffer: Buffer.from("brood 1\nFLY R0\n") };
    await hand.id("lineage-menu").click();
    await hand.id("lineage-file").setInputFiles(broken);
    const error = hand.id("error");
    await error.waitFor({ state: "visible" });
    assert.match(await error.innerText(), /Line 2/);
    hand.complaints = hand.complaints.filter((words) => !words.includes("422"));
  });

  await step("opens a saved lineage again", async () => {
    const before = await hand.generation(await hand.ready());
    const response = await fetch(`${new URL(page.url()).origin}/v1/lineages/${before.lineage}/file`);
    const file = { name: "history.json", mimeType: "application/json", buffer: Buffer.from(await response.arrayBuffer()) };
    await hand.id("lineage-menu").click();
    const after = await hand.generation(await hand.becomes(() => hand.id("lineage-file").setInputFiles(file)));
    assert.notEqual(after.lineage, before.lineage);
    assert.deepEqual(after.individuals.map((it) => it.hash), before.individuals.map((it) => it.hash));
  });
  hand.quiet();
}
