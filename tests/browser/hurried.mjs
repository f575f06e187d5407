// What people do while something is on its way, and what happens to a page around them: nothing typed, wished or bred is lost.

import { strict as assert } from "node:assert";

/** Long enough for hands to come in between. */
const HELD_MS = 1200;

const isBreeding = (request) => request.method() === "POST" && request.url().endsWith("/generations");

/** Holds back the answers of some requests while something is done. */
async function heldBack(page, path, method, act) {
  const slow = async (route) => {
    if (route.request().method() !== method) return route.continue();
    const answer = await route.fetch();
    await new Promise((done) => setTimeout(done, HELD_MS));
    return route.fulfill({ response: answer });
  };
  await page.route(path, slow);
  try {
    return await act();
  } finally {
    await page.unroute(path, slow);
  }
}

/** Counts the broods that are asked for while something is done, and until the page is ready again. */
async function broods(hand, act) {
  let count = 0;
  const see = (request) => void (count += isBreeding(request) ? 1 : 0);
  hand.page.on("request", see);
  await hand.becomes(act);
  hand.page.off("request", see);
  return count;
}

/** Has the page drawn anew, as whatever arrives does. */
const redrawn = (page) => page.evaluate(async () => {
  const { announcement } = await import("/web/state.js");
  announcement.value += ".";
});

export async function hurried(hand, step, base) {
  const { page } = hand;
  // The browser logs pictures that were kept from it, and changes that came second and were asked for again.
  hand.ignores = (text) => ["ERR_FAILED", "412", "404"].some((known) => text.includes(known));
  const bred = "**/v1/lineages/*/generations";

  const post = (path, json) => fetch(`${base}${path}`, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(json) });
  // Nothing of what others left on this server.
  const own = await (await post("/v1/lineages", { name: "in a hurry" })).json();

  await step("keeps a note that is being typed when a brood arrives, and where it belongs", async () => {
    const before = await hand.generation(await hand.open(`#/lineage/${own.id}`));
    const [{ id }] = before.individuals;
    await heldBack(page, bred, "POST", async () => {
      await hand.becomes(async () => {
        await hand.cell(4).click();
        await hand.id("note").pressSequentially("half a ");
        await redrawn(page);
        await hand.id("note").pressSequentially("thou");
      });
    });
    // The note goes on its way as the brood is shown.
    const note = async () => (await hand.api(`/v1/individuals/${id}`)).note;
    for (let tried = 0; tried < 100 && (await note()) === ""; tried += 1) await new Promise((done) => setTimeout(done, 50));
    assert.equal(await note(), "half a thou");
    assert.equal(await hand.id("note").inputValue(), "", "the new centre has no note");
  });

  await step("shows the scene that was chosen while a brood was made", async () => {
    await heldBack(page, bred, "POST", async () => {
      await hand.becomes(async () => {
        await hand.cell(6).click();
        await hand.id("object").selectOption("torus");
      });
    });
    const id = await hand.ready();
    const { lineage, individuals } = await hand.generation(id);
    const { scene } = await hand.api(`/v1/lineages/${lineage}`);
    assert.equal((await hand.api(`/v1/scenes/${scene}`)).mesh, "torus");
    await page.waitForFunction((wanted) => document.querySelector("[data-cell='5'] img").getAttribute("src") === wanted, individuals[5].thumbnail);
  });

  await step("breeds once where somebody clicks twice or keeps Enter down", async () => {
    assert.equal(await broods(hand, () => hand.cell(8).dblclick()), 1);
    await hand.cell(0).focus();
    const held = () => hand.cell(0).evaluate(async (cell) => {
      for (let k = 0; k < 12; k += 1) {
        cell.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", repeat: k > 0, bubbles: true, cancelable: true }));
        await new Promise((done) => setTimeout(done, 60));
      }
    });
    assert.equal(await broods(hand, held), 1);
  });

  await step("lets go of what was dragged out of the frames", async () => {
    const box = await hand.cell(0).boundingBox();
    await page.mouse.move(box.x + 20, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + 60, box.y + 60, { steps: 3 });
    await page.mouse.move(5, 5, { steps: 3 });
    await page.mouse.up();
    const before = await hand.api(`/v1/scenes/${(await hand.api(`/v1/lineages/${(await hand.generation(await hand.ready())).lineage}`)).scene}`);
    await page.mouse.move(box.x + 20, box.y + 20);
    const scaled = await hand.reshown(() => page.mouse.wheel(0, 240));
    assert.notEqual(scaled.scale, before.scale);
  });

  await step("keeps the mate through a look into a genome", async () => {
    await hand.cell(9).focus();
    await page.keyboard.press("m");
    await hand.id("mate-badge").waitFor();
    await page.keyboard.press("i");
    await page.locator("dialog[open]").waitFor();
    await page.keyboard.press("Escape");
    await page.locator("dialog[open]").waitFor({ state: "hidden" });
    assert.ok(await hand.id("mate-badge").isVisible());
    await page.keyboard.press("Escape");
    await hand.id("mate-badge").waitFor({ state: "hidden" });
  });

  await step("renames by keyboard alone, and gives the focus back", async () => {
    await hand.id("lineage-menu").focus();
    await page.keyboard.press("Enter");
    await page.getByRole("button", { name: /^Rename/ }).first().focus();
    await page.keyboard.press("Enter");
    // The name is chosen, so letters take its place; none of them is a key of the page.
    await page.keyboard.type("scs Ω 🧪");
    await page.keyboard.press("Enter");
    await page.locator("dialog[open] .cut", { hasText: "scs Ω 🧪" }).waitFor();
    assert.equal(await page.locator("dialog[open]").count(), 1);
    await page.locator("dialog[open]").getByRole("button", { name: "Close" }).click();
    await page.waitForFunction(() => document.activeElement?.getAttribute("data-testid") === "lineage-menu");
  });

  await step("fills a new lineage although a brood of another is being made", async () => {
    const before = await hand.ready();
    await heldBack(page, bred, "POST", async () => {
      await hand.cell(2).click();
      await hand.id("lineage-menu").click();
      await hand.id("lineage-name").fill("in between");
      await hand.id("lineage-new").click();
      await page.waitForFunction((old) => document.body.dataset.ready && document.body.dataset.ready !== old && document.title.startsWith("in between"), before);
    });
    const { lineage, individuals } = await hand.generation(await hand.ready());
    assert.equal((await hand.api(`/v1/lineages/${lineage}`)).name, "in between");
    assert.equal(individuals.length, 20);
  });

  await step("hears what was done elsewhere although it was opened in the background", async () => {
    const { lineage, index } = await hand.generation(await hand.ready());
    const other = await page.context().newPage();
    await other.addInitScript(() => {
      globalThis.inBackground = true;
      Object.defineProperty(document, "hidden", { get: () => globalThis.inBackground });
    });
    await other.goto(`${base}/#/lineage/${lineage}`);
    await other.locator('body[data-ready]:not([data-ready=""])').waitFor({ state: "attached" });
    assert.equal((await post(`/v1/lineages/${lineage}/generations`, { parents: [], seed: 5 })).status, 201);
    const made = other.getByRole("button", { name: new RegExp(`^Generation ${index + 1}$`) });
    await page.getByRole("button", { name: new RegExp(`^Generation ${index + 1}$`) }).waitFor();
    assert.equal(await made.count(), 0, "nobody looks, so nobody listens");
    await other.evaluate(() => {
      globalThis.inBackground = false;
      document.dispatchEvent(new Event("visibilitychange"));
    });
    await made.waitFor();
    await other.close();
  });

  await step("hears what is changed in another window, and changes that and not the rest", async () => {
    const { lineage, individuals } = await hand.generation(await hand.ready());
    const other = await page.context().newPage();
    await other.goto(page.url());
    await other.locator('body[data-ready]:not([data-ready=""])').waitFor({ state: "attached" });
    await hand.reshown(() => hand.id("object").selectOption("cube"));
    await other.waitForFunction(() => document.querySelector("[data-testid=object]").value === "cube");
    await hand.cell(3).focus();
    await page.keyboard.press("f");
    await other.locator("[data-testid=cell-3] .star.on").waitFor();
    // Without having heard of it: what was changed there stays.
    await other.evaluate(async () => {
      const { lineage: of } = await import("/web/state.js");
      of.value = { ...of.value, version: of.value.version - 1 };
    });
    await other.getByTestId("shadows").check();
    const settled = async () => hand.api(`/v1/scenes/${(await hand.api(`/v1/lineages/${lineage}`)).scene}`);
    await page.locator("[data-testid=shadows]:checked").waitFor();
    const { mesh, shadows } = await settled();
    assert.deepEqual([mesh, shadows], ["cube", true]);
    assert.equal((await hand.api(`/v1/individuals/${individuals[3].id}`)).favourite, true);
    await other.close();
    await hand.ready();
  });

  await step("begins once with a preset that is clicked twice", async () => {
    const before = (await hand.api("/v1/lineages")).items.length;
    await hand.id("presets").click();
    await hand.id("preset-velvet").waitFor();
    await hand.becomes(() => hand.id("preset-velvet").dblclick());
    await page.waitForFunction(() => document.querySelectorAll("[data-frame]").length === 21);
    assert.equal((await hand.api("/v1/lineages")).items.length, before + 1);
  });

  await step("keeps what is shown where a link leads nowhere, in the address too", async () => {
    const here = page.url();
    await page.evaluate(() => (location.hash = "#/lineage/00000000-0000-7000-8000-000000000000"));
    await hand.id("error").waitFor();
    assert.equal(page.url(), here);
    assert.ok(await hand.ready());
    await page.getByRole("button", { name: "Dismiss" }).click();
  });

  await step("keeps a note through a reload, and the strip on what is shown", async () => {
    for (let k = 0; k < 20; k += 1) await hand.becomes(() => hand.id("reroll").click());
    const { centre } = await hand.generation(await hand.ready());
    await hand.id("note").pressSequentially("in haste");
    await page.reload();
    await hand.ready();
    assert.equal(await hand.id("note").inputValue(), "in haste");
    assert.equal((await hand.api(`/v1/individuals/${centre.id}`)).note, "in haste");
    await page.waitForFunction(() => {
      const [now, strip] = [".stop[aria-current]", ".strip"].map((name) => document.querySelector(name).getBoundingClientRect());
      return now.left >= strip.left && now.right <= strip.right;
    });
  });

  await step("asks again for pictures that failed once the server is back", async () => {
    await page.route("**/*.png*", (route) => route.abort());
    await hand.id("reroll").click();
    await page.waitForFunction(() => document.querySelectorAll(".again").length >= 20, null, { timeout: 90_000 });
    await page.unroute("**/*.png*");
    await page.evaluate(() => document.dispatchEvent(new Event("visibilitychange")));
    await page.waitForFunction(() => document.body.dataset.ready && document.querySelectorAll(".again").length === 0);
  });

  await step("works where the browser refuses to remember anything", async () => {
    const other = await page.context().newPage();
    await other.addInitScript(() => {
      for (const name of ["localStorage", "sessionStorage"]) {
        Object.defineProperty(globalThis, name, { get: () => { throw new DOMException("denied", "SecurityError"); } });
      }
    });
    await other.goto(`${base}/#/lineage/%E0%A4%A`);
    await other.goto(base);
    await other.locator('body[data-ready]:not([data-ready=""])').waitFor({ state: "attached" });
    assert.equal(await other.locator("[data-frame]").count(), 21);
    await other.close();
  });
  hand.quiet();
}
