// Looking into genomes, locking parts of them, limiting what children reflect; covers, and pictures that move.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";

import { allLit, asServerDraws, noneLit, slide } from "./live.mjs";

/** The inspector once it shows what the server found. */
async function openedInspector(hand) {
  await hand.id("listing").waitFor();
  await hand.page.waitForFunction(() => {
    const image = document.querySelector("[data-testid=slice] img");
    return image?.complete && image.naturalWidth > 0;
  });
  return hand.id("inspector");
}

/** The fact of that name in a part of the page. */
const fact = (within, name) => within.locator("dl > div").filter({ has: within.page().locator("dt", { hasText: new RegExp(`^${name}$`) }) }).locator("dd");

const inspection = (hand, individual) => hand.api(`/v1/individuals/${individual.id}/inspection`);

/** The lines of a genome's instructions. */
const instructionsOf = ({ source, counts }) => source.trimEnd().split("\n").slice(-counts.instructions);

/** Breeds from a frame, and gives what was sent and what came. */
async function bred(hand, act) {
  const sent = hand.page.waitForRequest((it) => it.method() === "POST" && it.url().endsWith("/generations"));
  const generation = await hand.generation(await hand.becomes(act));
  return { sent: (await sent).postDataJSON(), generation };
}

/** Turns the switch of the energy limit and waits until the lineage has it as its own. */
async function limit(hand) {
  const patched = hand.page.waitForResponse((it) => it.request().method() === "PATCH");
  await hand.page.getByRole("switch", { name: "energy limit" }).check();
  const answer = await patched;
  assert.equal(answer.status(), 200);
  assert.equal((await answer.json()).energy_limit, true);
}

/** The journey; `shot` takes a picture of the page. */
export async function inspect(hand, step, shot, base) {
  const { page } = hand;
  const details = page.getByRole("complementary", { name: "Details" });

  await step("limits what children reflect, and says how much that is", async () => {
    await hand.open();
    await hand.id("lineage-menu").click();
    await hand.id("lineage-name").fill("looked into");
    await hand.becomes(() => hand.id("lineage-new").click());
    await limit(hand);
    const { sent, generation } = await bred(hand, () => hand.cell(4).click());
    assert.equal(sent.energy_limit, true);
    assert.equal(generation.energy_limit, true);
    await hand.becomes(() => hand.cell(3).click());
    await fact(details, "reflects at most").filter({ hasText: "(limited)" }).waitFor();
    const { energy } = await inspection(hand, generation.individuals[3]);
    assert.ok(energy.max_albedo <= 1 + energy.error_bound, `${energy.max_albedo}`);
    const shown = await fact(details, "reflects at most").innerText();
    assert.equal(Number.parseFloat(shown), Number(energy.max_albedo.toPrecision(2)));
    await page.reload();
    await hand.ready();
    assert.ok(await page.getByRole("switch", { name: "energy limit" }).isChecked());
    await shot("27-limited");
  });

  const looked = await step("looks into the genome of a frame by key", async () => {
    const generation = await hand.generation(await hand.ready());
    const individual = generation.individuals[5];
    await hand.cell(5).focus();
    await page.keyboard.press("i");
    const inspector = await openedInspector(hand);
    assert.ok((await inspector.getByRole("heading", { level: 2 }).innerText()).toLowerCase().includes(individual.hash.slice(0, 8)));
    const found = await inspection(hand, individual);
    assert.equal(await inspector.locator("[data-instruction]").count(), found.counts.instructions);
    assert.equal(await inspector.locator("[data-instruction].dead").count(), found.live.filter((live) => !live).length);
    assert.equal(await fact(inspector, "instructions").innerText(), `${found.counts.live_instructions} of ${found.counts.instructions} live`);
    assert.equal(await inspector.getByTestId("polar").locator("g > .curve").count(), 4);
    await shot("28-inspector");
    await hand.accessible("inspector");
    return { generation, individual, found };
  });

  await step("plots and lists it in other ways", async () => {
    const inspector = hand.id("inspector");
    // All of them: of one channel alone there may be nothing, and nothing looks alike however it is drawn.
    const drawn = () => inspector.getByTestId("polar").locator("g > .curve").evaluateAll(
      (curves) => curves.map((curve) => curve.getAttribute("d")).join());
    const seen = new Set([await drawn()]);
    const choices = ["log", "f cos θₒ", "red"];
    if (looked.found.planes.length > 1) choices.push("across u");
    for (const name of choices) {
      await inspector.getByRole("radio", { name, exact: true }).check();
      seen.add(await drawn());
    }
    assert.ok(seen.size > 2, "the curves change");
    await inspector.getByRole("switch", { name: "live code only" }).check();
    assert.equal(await inspector.locator("[data-instruction]").count(), looked.found.counts.live_instructions);
    assert.equal(await inspector.locator(".dead").count(), 0);
    await inspector.getByRole("button", { name: "Copy" }).click();
    await inspector.getByRole("button", { name: "Copied" }).waitFor();
    assert.equal(await page.evaluate(() => navigator.clipboard.readText()), looked.found.source);
    await inspector.getByRole("radio", { name: "scalar code" }).check();
    assert.equal((await hand.id("listing").locator("pre").innerText()).trim(), looked.found.code.trim());
    await shot("29-scalar-code");
    await inspector.getByRole("radio", { name: "assembly" }).check();
    await page.keyboard.press("Escape");
    await inspector.waitFor({ state: "detached" });
    assert.equal(await page.evaluate(() => document.activeElement.dataset.cell), "5", "the focus is where it was");
  });

  await step("locks instructions and constants, and children keep them", async () => {
    const parent = looked.individual;
    const live = looked.found.live.flatMap((is, at) => (is ? [at] : [])).slice(0, 12);
    await page.keyboard.press("i");
    const inspector = await openedInspector(hand);
    for (const at of live) await inspector.getByRole("button", { name: `Lock instruction ${at}`, exact: true }).click();
    const constants = await inspector.locator("[data-constant] .lock").count();
    if (constants > 0) await inspector.locator("[data-constant] .lock").first().click();
    await shot("30-locks");
    await hand.accessible("locks");
    await inspector.getByRole("button", { name: "Close" }).click();
    await hand.id("lock-sign").filter({ hasText: `${live.length} instructions` }).waitFor();
    const { sent, generation } = await bred(hand, () => hand.cell(5).click());
    assert.deepEqual(sent.parents, [parent.id]);
    assert.deepEqual(sent.locks.instructions, live);
    assert.equal(sent.locks.constants.length, Math.min(1, constants));
    assert.deepEqual(generation.locks.instructions, live);
    const kept = instructionsOf(looked.found);
    for (const slot of [0, 9, 19]) {
      const lines = instructionsOf(await inspection(hand, generation.individuals[slot]));
      assert.deepEqual(live.map((at) => lines[at]), live.map((at) => kept[at]), `child ${slot}`);
    }
    await shot("31-kept");
  });

  await step("sends no locks with a random brood, and remembers them", async () => {
    const { sent, generation } = await bred(hand, () => hand.id("afresh").click());
    assert.equal(sent.locks, undefined);
    assert.ok(!generation.locks);
    await page.reload();
    await hand.ready();
    await hand.id("lock-sign").waitFor();
  });

  await step("says so when too much is locked", async () => {
    for (const name of ["Lock red", "Lock green", "Lock blue"]) await hand.id("locks").getByRole("switch", { name }).check();
    const { generation } = await bred(hand, () => hand.cell(2).click());
    assert.deepEqual(generation.locks.channels, ["r", "g", "b"]);
    const twins = generation.individuals.filter((it) => it.twin).length;
    assert.ok(twins > 0);
    await hand.id("status").filter({ hasText: `${twins} twins: much is locked` }).waitFor();
    await shot("32-twins");
    await hand.accessible("locked");
    await hand.id("lock-sign").click();
    await page.getByRole("button", { name: "Unlock all" }).click();
    assert.equal(await hand.id("lock-sign").count(), 0);
    await hand.becomes(() => hand.cell(2).click());
    assert.doesNotMatch(await hand.id("status").innerText(), /twin/);
  });

  await step("shows what each lineage looks like", async () => {
    await hand.id("lineage-menu").click();
    const { items } = await hand.api("/v1/lineages");
    const covered = items.filter((it) => it.cover).length;
    assert.ok(covered > 0);
    await page.waitForFunction((count) => {
      const images = [...document.querySelectorAll(".lineages .cover img")];
      return images.length === count && images[0].naturalWidth > 0;
    }, covered);
    const dialog = page.getByRole("dialog", { name: "Lineages" });
    assert.ok((await dialog.evaluate((it) => it.scrollWidth - it.clientWidth)) <= 0, "nothing sticks out sideways");
    await shot("33-covers");
    await hand.accessible("covers");
    await page.keyboard.press("Escape");
  });

  await step("exports pictures that move, of one and of the whole brood", async () => {
    await page.getByText("Export", { exact: true }).click();
    for (const [name, animated] of [[/^APNG, the light/, true], [/^PNG strip/, false], [/^PNG of the brood/, false], [/^APNG of the brood/, true]]) {
      const link = page.getByRole("link", { name });
      const [download] = await Promise.all([page.waitForEvent("download"), link.click()]);
      const bytes = await readFile(await download.path());
      assert.equal(bytes.toString("latin1", 1, 4), "PNG", `${name}`);
      assert.equal(bytes.includes("acTL"), animated, `${name}`);
      assert.match(download.suggestedFilename(), animated ? /\.a?png$/ : /\.png$/);
    }
    await shot("34-exports");
  });

  await step("says in the inspector what went wrong", async () => {
    await page.route("**/inspection", (route) => route.fulfill({ status: 404, contentType: "application/problem+json", body: JSON.stringify({ title: "Not here", status: 404, detail: "it is gone" }) }));
    await hand.cell(11).focus();
    await page.keyboard.press("i");
    await page.locator("[data-testid=error][data-place=inspector]").filter({ hasText: "it is gone" }).waitFor();
    await page.unroute("**/inspection");
    await page.keyboard.press("Escape");
    hand.complaints = hand.complaints.filter((text) => !text.includes("404"));
  });
  hand.quiet();
}

/** The same by finger, on a screen where everything is stacked. */
export async function inspectByFinger(hand, step, shot) {
  const { page } = hand;
  await step("looks into the centre and locks by finger on a screen of 360 pixels", async () => {
    await hand.id("details-toggle").tap();
    await page.getByRole("button", { name: "Inspect the genome" }).tap();
    const inspector = await openedInspector(hand);
    const sideways = await inspector.evaluate((it) => it.scrollWidth - it.clientWidth);
    assert.ok(sideways <= 0, "nothing sticks out sideways");
    await shot("35-narrow-inspector");
    await inspector.getByRole("button", { name: "Lock instruction 1", exact: true }).tap();
    await shot("36-narrow-locks");
    await hand.accessible("360 x 740, inspector");
    await inspector.getByRole("button", { name: "Unlock all" }).tap();
    await inspector.getByRole("button", { name: "Close" }).tap();
    await hand.id("details-toggle").tap();
  });
}

/** Under the limit, what is drawn live is what the server draws. */
export async function limitedLive(hand, step, shot, base) {
  await step("draws children under the energy limit as the server does", async () => {
    await limit(hand);
    const generation = await hand.generation(await hand.becomes(() => hand.cell(4).click()));
    assert.equal(generation.energy_limit, true);
    await slide(hand, "light", 75);
    await allLit(hand.page);
    await asServerDraws(hand, generation, 75, base);
    await shot("37-limited-live");
    await slide(hand, "light", 0);
    await noneLit(hand.page);
  });
}
