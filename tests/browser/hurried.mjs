// Actions while requests are on their way, and changes by other windows: nothing typed, changed or
// bred is lost.

import { strict as assert } from "node:assert";

import { MODULES } from "./page.mjs";

/** Delay of requests that is long enough for other actions. */
const HELD_MS = 1200;

const isBreeding = (request) =>
  request.method() === "POST" && request.url().endsWith("/generations");

/** Delays the answers of some requests during an action. */
async function heldBack(page, path, method, act) {
  const slow = async (route) => {
    if (route.request().method() !== method) return route.fallback();
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

/** Counts requests for broods during an action, and until the page is ready again. */
async function broods(app, act) {
  let count = 0;
  const see = (request) => void (count += isBreeding(request) ? 1 : 0);
  app.page.on("request", see);
  await app.becomes(act);
  app.page.off("request", see);
  return count;
}

/** Redraws all components that show the present generation, as news from the server do. */
const redrawn = (page) =>
  page.evaluate(async () => {
    const {
      lineageStore: { generation, generations },
    } = await import("/web/lineage/store.js");
    const { id } = generation.value;
    generations.value = new Map(generations.value).set(id, { ...generation.value });
  });

export async function hurried(app, step, base) {
  const { page } = app;
  app.path = MODULES;
  // The browser logs blocked pictures, and conflicts that were retried.
  app.ignores = (text) => ["ERR_FAILED", "412", "404", "422"].some((known) => text.includes(known));
  const bred = "**/v1/lineages/*/generations";

  const post = (path, json) =>
    fetch(`${base}${path}`, {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify(json),
    });
  // Independent of what other journeys left on this server.
  const own = await (await post("/v1/lineages", { name: "in a hurry" })).json();

  await step(
    "keeps a note of the old centre that is being typed when a brood arrives",
    async () => {
      const before = await app.generation(await app.open(`#/lineage/${own.id}`));
      const [{ id }] = before.individuals;
      await heldBack(page, bred, "POST", async () => {
        await app.becomes(async () => {
          await app.cell(4).click();
          await app.id("note").pressSequentially("half a ");
          await redrawn(page);
          await app.id("note").pressSequentially("thou");
        });
      });
      // The note is saved as the new brood is shown.
      const note = async () => (await app.api(`/v1/individuals/${id}`)).note;
      for (let tried = 0; tried < 100 && (await note()) === ""; tried += 1)
        await new Promise((done) => setTimeout(done, 50));
      assert.equal(await note(), "half a thou");
      assert.equal(await app.id("note").inputValue(), "", "the new centre has no note");
    },
  );

  await step("redraws only the components that have read a changed signal", async () => {
    const drawn = await page.evaluate(async () => {
      const { options } = await import("/web/vendor/preact.js");
      const { pageStore } = await import("/web/page/store.js");
      const names = [];
      // Called before a component is drawn; `__r` is its name in the vendored build of preact.
      const before = options.__r;
      options.__r = (node) => {
        names.push(node.type.name);
        before?.(node);
      };
      // The answer to the saved note and its event draw components of their own.
      const pause = () => new Promise((done) => setTimeout(done, 500));
      do {
        names.length = 0;
        await pause();
      } while (names.length > 0);
      pageStore.announcement.value += ".";
      await new Promise(requestAnimationFrame);
      options.__r = before;
      return names;
    });
    assert.deepEqual(drawn, ["LiveRegion"]);
  });

  await step("shows the scene that was chosen during breeding", async () => {
    await heldBack(page, bred, "POST", async () => {
      await app.becomes(async () => {
        await app.cell(6).click();
        await app.id("object").selectOption("torus");
      });
    });
    const id = await app.ready();
    const { lineage, individuals } = await app.generation(id);
    const { scene } = await app.api(`/v1/lineages/${lineage}`);
    assert.equal((await app.api(`/v1/scenes/${scene}`)).mesh, "torus");
    await page.waitForFunction(
      (wanted) => document.querySelector("[data-cell='5'] img").getAttribute("src") === wanted,
      individuals[5].thumbnail,
    );
  });

  await step("breeds once on a double click or a held Enter", async () => {
    assert.equal(await broods(app, () => app.cell(8).dblclick()), 1);
    await app.cell(0).focus();
    const held = () =>
      app.cell(0).evaluate(async (cell) => {
        for (let k = 0; k < 12; k += 1) {
          cell.dispatchEvent(
            new KeyboardEvent("keydown", {
              key: "Enter",
              repeat: k > 0,
              bubbles: true,
              cancelable: true,
            }),
          );
          await new Promise((done) => setTimeout(done, 60));
        }
      });
    assert.equal(await broods(app, held), 1);
  });

  await step("ends a drag that leaves the frames", async () => {
    const box = await app.cell(0).boundingBox();
    await page.mouse.move(box.x + 20, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + 60, box.y + 60, { steps: 3 });
    await page.mouse.move(5, 5, { steps: 3 });
    await page.mouse.up();
    const before = await app.api(
      `/v1/scenes/${(await app.api(`/v1/lineages/${(await app.generation(await app.ready())).lineage}`)).scene}`,
    );
    await page.mouse.move(box.x + 20, box.y + 20);
    const scaled = await app.reshown(() => page.mouse.wheel(0, 240));
    assert.notEqual(scaled.scale, before.scale);
  });

  await step("keeps the mate while the inspector is open", async () => {
    await app.cell(9).focus();
    await page.keyboard.press("m");
    await app.id("mate-badge").waitFor();
    await page.keyboard.press("i");
    await page.locator("dialog[open]").waitFor();
    await page.keyboard.press("Escape");
    await page.locator("dialog[open]").waitFor({ state: "hidden" });
    assert.ok(await app.id("mate-badge").isVisible());
    await page.keyboard.press("Escape");
    await app.id("mate-badge").waitFor({ state: "hidden" });
  });

  await step("renames by keyboard alone, and returns the focus", async () => {
    await app.id("lineage-menu").focus();
    await page.keyboard.press("Enter");
    await page
      .getByRole("button", { name: /^Edit/ })
      .first()
      .focus();
    await page.keyboard.press("Enter");
    // The name is selected, so letters replace it; none of them is a shortcut.
    await page.keyboard.type("scs Ω 🧪");
    await page.keyboard.press("Enter");
    await page.locator("dialog[open] .cut", { hasText: "scs Ω 🧪" }).waitFor();
    assert.equal(await page.locator("dialog[open]").count(), 1);
    await page.locator("dialog[open]").getByRole("button", { name: "Close" }).click();
    await page.waitForFunction(
      () => document.activeElement?.getAttribute("data-testid") === "lineage-menu",
    );
  });

  await step("fills a new lineage while a brood of another is being bred", async () => {
    const before = await app.ready();
    await heldBack(page, bred, "POST", async () => {
      await app.cell(2).click();
      await app.id("lineage-menu").click();
      await app.id("lineage-name").fill("in between");
      await app.id("lineage-new").click();
      await page.waitForFunction(
        (old) =>
          document.body.dataset.ready &&
          document.body.dataset.ready !== old &&
          document.title.startsWith("in between"),
        before,
      );
    });
    const { lineage, individuals } = await app.generation(await app.ready());
    assert.equal((await app.api(`/v1/lineages/${lineage}`)).name, "in between");
    assert.equal(individuals.length, 20);
  });

  await step("shows changes by other clients after it was opened in the background", async () => {
    const { lineage, index } = await app.generation(await app.ready());
    const other = await page.context().newPage();
    await other.addInitScript(() => {
      globalThis.inBackground = true;
      Object.defineProperty(document, "hidden", { get: () => globalThis.inBackground });
    });
    await other.goto(`${base}/#/lineage/${lineage}`);
    await other.locator('body[data-ready]:not([data-ready=""])').waitFor({ state: "attached" });
    assert.equal(
      (await post(`/v1/lineages/${lineage}/generations`, { parents: [], seed: 5 })).status,
      201,
    );
    const made = other.getByRole("button", { name: new RegExp(`^Generation ${index + 1}$`) });
    await page.getByRole("button", { name: new RegExp(`^Generation ${index + 1}$`) }).waitFor();
    assert.equal(await made.count(), 0, "a hidden page has no event stream");
    await other.evaluate(() => {
      globalThis.inBackground = false;
      document.dispatchEvent(new Event("visibilitychange"));
    });
    await made.waitFor();
    await other.close();
  });

  await step("shows changes of another window, and changes only its own fields", async () => {
    const { lineage, individuals } = await app.generation(await app.ready());
    const other = await page.context().newPage();
    await other.goto(page.url());
    await other.locator('body[data-ready]:not([data-ready=""])').waitFor({ state: "attached" });
    await app.reshown(() => app.id("object").selectOption("cube"));
    await other.waitForFunction(
      () => document.querySelector("[data-testid=object]").value === "cube",
    );
    await app.cell(3).focus();
    await page.keyboard.press("f");
    await other.locator("[data-testid=cell-3] .star.on").waitFor();
    // The page has not heard of the other change, which must stay.
    await other.evaluate(async () => {
      const {
        lineageStore: { lineage: of },
      } = await import("/web/lineage/store.js");
      of.value = { ...of.value, version: of.value.version - 1 };
    });
    await other.getByTestId("shadows").check();
    const settled = async () =>
      app.api(`/v1/scenes/${(await app.api(`/v1/lineages/${lineage}`)).scene}`);
    await page.locator("[data-testid=shadows]:checked").waitFor();
    const { mesh, shadows } = await settled();
    assert.deepEqual([mesh, shadows], ["cube", true]);
    assert.equal((await app.api(`/v1/individuals/${individuals[3].id}`)).favourite, true);
    await other.close();
    await app.ready();
    // Pictures with shadows take seconds, which no later step needs.
    await app.reshown(() => app.id("shadows").uncheck({ force: true }));
  });

  await step("starts one lineage on a double click on a preset", async () => {
    const before = (await app.api("/v1/lineages")).items.length;
    await app.id("presets").click();
    await app.id("preset-velvet").waitFor();
    await app.becomes(() => app.id("preset-velvet").dblclick());
    await page.waitForFunction(() => document.querySelectorAll("[data-frame]").length === 21);
    assert.equal((await app.api("/v1/lineages")).items.length, before + 1);
  });

  await step("keeps the generation and the address when a link is invalid", async () => {
    const here = page.url();
    await page.evaluate(() => (location.hash = "#/lineage/00000000-0000-7000-8000-000000000000"));
    await app.id("error").waitFor();
    assert.equal(page.url(), here);
    assert.ok(await app.ready());
    await page.getByRole("button", { name: "Dismiss" }).click();
  });

  await step(
    "keeps a note after a reload, and scrolls the strip to the shown generation",
    async () => {
      for (let k = 0; k < 20; k += 1) await app.becomes(() => app.id("reroll").click());
      const { centre } = await app.generation(await app.ready());
      await app.id("note").pressSequentially("in haste");
      await page.reload();
      await app.ready();
      assert.equal(await app.id("note").inputValue(), "in haste");
      assert.equal((await app.api(`/v1/individuals/${centre.id}`)).note, "in haste");
      await page.waitForFunction(() => {
        const [now, strip] = [".stop[aria-current]", ".strip"].map((name) =>
          document.querySelector(name).getBoundingClientRect(),
        );
        return now.left >= strip.left && now.right <= strip.right;
      });
    },
  );

  await step("loads failed pictures once the server is back", async () => {
    await page.route("**/*.png*", (route) => route.abort());
    await app.id("reroll").click();
    await page.waitForFunction(() => document.querySelectorAll(".again").length >= 20, null, {
      timeout: 90_000,
    });
    await page.unroute("**/*.png*");
    await page.evaluate(() => document.dispatchEvent(new Event("visibilitychange")));
    await page.waitForFunction(
      () => document.body.dataset.ready && document.querySelectorAll(".again").length === 0,
    );
  });

  await step("says why the server refuses pictures, and does not ask for them again", async () => {
    const asked = [];
    const detail = "the scene has nine lights";
    const refuse = (route) => {
      asked.push(route.request().url());
      const body = JSON.stringify({ title: "Invalid input", status: 422, detail });
      return route.fulfill({ status: 422, contentType: "application/problem+json", body });
    };
    await page.route("**/v1/thumbnails/**", refuse);
    await app.id("reroll").click();
    const said = app.cell(7).getByTestId("refused");
    await said.waitFor();
    assert.equal(await said.textContent(), detail);
    await page.waitForFunction(() => document.querySelectorAll("p.refused").length >= 20);
    // The server draws them all the same and says so: each is asked for once more.
    for (const url of new Set(asked)) assert.ok((await page.request.get(url)).ok());
    await page.waitForTimeout(2000);
    const before = asked.length;
    await page.waitForTimeout(3000);
    assert.equal(asked.length, before);
    assert.ok((await page.locator("p.refused").count()) >= 20);
    await page.unroute("**/v1/thumbnails/**", refuse);
    for (const again of (await page.locator(".again").all()).reverse()) await again.click();
    await app.ready();
    assert.equal(await page.locator(".refused").count(), 0);
  });

  await step("works when the browser refuses storage", async () => {
    const other = await page.context().newPage();
    await other.addInitScript(() => {
      for (const name of ["localStorage", "sessionStorage"]) {
        Object.defineProperty(globalThis, name, {
          get: () => {
            throw new DOMException("denied", "SecurityError");
          },
        });
      }
    });
    await other.goto(`${base}/#/lineage/%E0%A4%A`);
    await other.goto(base);
    await other.locator('body[data-ready]:not([data-ready=""])').waitFor({ state: "attached" });
    assert.equal(await other.locator("[data-frame]").count(), 21);
    await other.close();
  });
  app.path = "/";
  app.quiet();
}
