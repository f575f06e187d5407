// Pictures of known scenes as targets: shown as the server understood them, searched for, and
// compared with results and the centre. The pictures are renders of a measured target.

import { strict as assert } from "node:assert";

import { poster } from "./server.mjs";

const SIDE_PX = 96;

/** Renders the newest measured target in the open lineage's scene. */
async function photograph(app, base, name, light = "") {
  const generation = await app.generation(await app.ready());
  const { scene } = await app.api(`/v1/lineages/${generation.lineage}`);
  const target = (await app.api("/v1/targets")).items.find(({ kind }) => kind === "samples");
  const answer = await fetch(
    `${base}/v1/targets/${target.id}/render.png?size=${SIDE_PX}&scene=${scene}${light}`,
  );
  assert.equal(answer.status, 200, `${answer.url}: ${answer.status}`);
  return { name, mimeType: "image/png", buffer: Buffer.from(await answer.arrayBuffer()) };
}

/** Opens a lineage under one lamp: pictures in environments cannot be searched for. */
async function underLamp(app, base) {
  const { id } = await poster(base)("/v1/lineages", { name: "Under a lamp", start: "believable" });
  await app.open(`#/lineage/${id}`);
}

/** Scene of the open lineage, as a user would paste it. */
async function sceneText(app) {
  const generation = await app.generation(await app.ready());
  const { scene } = await app.api(`/v1/lineages/${generation.lineage}`);
  const { id: _, ...json } = await app.api(`/v1/scenes/${scene}`);
  return JSON.stringify(json, null, 1);
}

/** Opacity of the upper picture, in percent. */
const seen = async (app, pair) =>
  Number(await app.id(pair).locator("[data-seen]").getAttribute("data-seen"));

/** Choice of the open lineage's scene, once the picture is shown. */
function inLineage(app) {
  return app
    .id("view-0-photo")
    .locator("xpath=..")
    .getByTestId("view-0-from")
    .getByRole("radio", { name: "the lineage's" });
}

/** Opens the form of a new search. */
async function openForm(app) {
  await app.page.keyboard.press("s");
  await app.id("searches-dialog").waitFor();
  await app.id("searches-dialog").getByRole("button", { name: "New search" }).first().click();
  await app.id("target-file").waitFor({ state: "attached" });
}

/** Runs the journey, after a search for a measured target; `shot` saves a screenshot. */
export async function target(app, step, shot, base) {
  const { page } = app;
  app.ignores = (text) => text.includes("422");
  const own = (at) => app.id(`view-${at}-from`).getByRole("radio", { name: "a scene file" });

  await step("stops an upload, and keeps the chosen file", async () => {
    await underLamp(app, base);
    await openForm(app);
    await page.route("**/v1/targets", (route) =>
      route.request().method() === "POST" ? undefined : route.continue(),
    );
    await app
      .id("target-file")
      .setInputFiles({ name: "slow.csv", mimeType: "text/csv", buffer: Buffer.alloc(4096, 48) });
    await app.id("target-sending").getByRole("progressbar").waitFor();
    await shot("61-target-sending");
    await app.accessible("an upload");
    await app.id("target-sending-stop").click();
    await app.id("target-sending").waitFor({ state: "detached" });
    assert.equal(await page.locator("[data-testid=error][data-place=target]").count(), 0);
    await page.getByText("slow.csv").waitFor();
    await page.unroute("**/v1/targets");
  });

  await step(
    "reads a picture of the open lineage's scene, and shows it as the server understood it",
    async () => {
      const { length } = (await app.api("/v1/jobs")).items;
      await app.id("target-file").setInputFiles(await photograph(app, base, "lobe.png"));
      await inLineage(app).check();
      assert.ok(await app.id("search-start").isDisabled(), "nothing was read yet");
      await app.id("views-read").click();
      await app.id("target-understood").waitFor();
      await app.drawn("target-understood", 4);
      const statuses = await app.id("pixel-statuses").innerText();
      assert.match(statuses, /used[\s\S]*background/);
      assert.equal((await app.api("/v1/jobs")).items.length, length);
      await page.keyboard.press("x");
      assert.equal(await seen(app, "understood"), 100);
      await page.keyboard.press("x");
      await app.id("understood-flip").click();
      assert.equal(await seen(app, "understood"), 100);
      await app.id("understood-flip").press("Enter");
      assert.equal(await seen(app, "understood"), 0);
      await app.id("understood-blend").fill("50");
      assert.equal(await seen(app, "understood"), 50);
      await shot("62-target-understood");
      await app.accessible("a picture as understood");
    },
  );

  await step("deletes the target when its file is read as another kind", async () => {
    const before = await app.api("/v1/targets");
    const removed = page.waitForResponse((it) => it.request().method() === "DELETE");
    await app.id("target-kind").selectOption("samples");
    assert.equal((await removed).status(), 204);
    await page.locator("[data-testid=error][data-place=target]").waitFor();
    assert.ok(await app.id("search-start").isDisabled());
    await page.waitForFunction(
      (count) => document.querySelectorAll(".known li").length === count,
      before.items.length - 1,
    );
    assert.equal((await app.api("/v1/targets")).items.length, before.items.length - 1);
    await app.id("target-kind").selectOption("image");
  });

  await step("explains at its field what is wrong with a scene, and keeps the text", async () => {
    await own(0).check();
    // The light is behind the ball.
    const wrong =
      '{"camera": {"orthographic": 1.2}, "lights": [{"kind": "directional", "direction": [0, 0, 1]}]}';
    await app.id("view-0-scene").fill(wrong);
    await app.id("views-read").click();
    const error = page.locator("#view-0-wrong [data-testid=error]");
    await error.filter({ hasText: "no light of the scene" }).waitFor();
    assert.equal(await app.id("view-0-scene").inputValue(), wrong);
    assert.equal(await app.id("view-0-scene").getAttribute("aria-invalid"), "true");
    await shot("63-target-scene-refused");
    await app.accessible("a scene that was refused");
    await app.id("view-0-scene").fill("{");
    await app.id("views-read").click();
    await error.filter({ hasText: "not valid JSON" }).waitFor();
  });

  const job = await step(
    "adds a second picture under another light, held out, and searches",
    async () => {
      await app.id("view-0-scene").fill(await sceneText(app));
      await app
        .id("views-add")
        .setInputFiles(
          await photograph(
            app,
            base,
            "a second picture of the same lobe, under a light from another side.png",
            "&light_deg=75",
          ),
        );
      await app.id("view-1-light").fill("75");
      await app.id("view-1-held").check();
      await app.id("views-read").click();
      await app.id("target-understood").waitFor();
      await app.id("understood-views").getByRole("radio", { name: "2 held out" }).check();
      await app.drawn("target-understood", 4);
      await app.id("search-strategy").selectOption("lobes");
      await page.getByRole("radio", { name: "evaluations" }).check();
      await app.id("search-budget").fill("300");
      await app.id("search-start").click();
      await app.id("job-state").filter({ hasText: "done" }).waitFor();
      const found = await app.api(`/v1/jobs/${/search\/([^/]+)$/.exec(page.url())[1]}`);
      assert.deepEqual(found.budget, { evaluations: 300 });
      return found;
    },
  );

  await step(
    "shows both pictures over the result, and the result under another light",
    async () => {
      await app.drawn("found-pair", 3);
      const rows = app.id("found-views").locator("tbody tr");
      assert.equal(await rows.count(), 2);
      const [, rmse, flip] = await rows.first().getByRole("cell").allInnerTexts();
      assert.ok(
        Number(rmse) > 0 && Number(flip) > 0 && Number(flip) < 1,
        `RMSE ${rmse}, FLIP ${flip}`,
      );
      await page.keyboard.press("x");
      assert.equal(await seen(app, "found-pair"), 100);
      await page.keyboard.press("x");
      await shot("64-target-found");
      await app.accessible("a find beside its picture");
      await app.id("found-view-1").click();
      await app.id("found-pair").locator("img[src*='view=1']").first().waitFor();
      await shot("65-target-held-out");
      await app.id("found-light").fill("200");
      await app.id("found-light").blur();
      await app.id("found-alone").waitFor();
      await app.id("found-picture").locator("img[src*='light_deg=200']").waitFor();
      await shot("66-target-another-light");
      await app.id("found-light-rest").click();
      await app.id("found-pair").waitFor();
    },
  );

  await step("shows the target in place of the centre while breeding", async () => {
    const before = await app.ready();
    await app.id("found-breed").click();
    await app.id("searches-dialog").waitFor({ state: "detached" });
    await app.ready(before);
    await app.id("target-here").waitFor();
    await app.id("centre").focus();
    await page.keyboard.press("t");
    const name = () => app.id("centre").getAttribute("aria-label");
    assert.match(await name(), /the target is shown in its place/);
    await app.drawn("target-in-centre", 1);
    await app.drawn("active-target-sides", 2);
    await shot("67-target-in-centre");
    await app.accessible("the target in the centre");
    const { generations } = await app.api(`/v1/lineages/${job.lineage}`);
    // A click on the target only shows the centre again.
    await app.id("centre").click();
    assert.doesNotMatch(await name(), /the target/);
    assert.equal((await app.api(`/v1/lineages/${job.lineage}`)).generations, generations);
    await app.id("target-here").click();
    await page.keyboard.press("Escape");
    assert.doesNotMatch(await name(), /the target/);
    await app.id("target-view").selectOption("1");
    await app.id("active-target-sides").locator("img[src*='view=1']").first().waitFor();
    const wanted = (await app.api(`/v1/targets/${job.target}`)).views[1].scene;
    const scene = await app.reshown(() => app.id("target-scene").click());
    assert.equal(scene.light_deg, wanted.light_deg);
    await app.id("target-scene").waitFor({ state: "detached" });
  });
  app.quiet();
}

/** The same on a small touch screen. */
export async function targetByFinger(app, step, shot, base) {
  const { page } = app;
  await step("shows a target's picture and scene on a screen of 360 pixels", async () => {
    await underLamp(app, base);
    await app.id("searches").tap();
    await app.id("searches-dialog").getByRole("button", { name: "New search" }).first().tap();
    await app
      .id("target-file")
      .setInputFiles(
        await photograph(
          app,
          base,
          "a picture with a name that does not fit into three hundred and sixty pixels.png",
        ),
      );
    await app.fits(app.id("searches-dialog"));
    await inLineage(app).check();
    await shot("68-narrow-target");
    await app.id("views-read").tap();
    await app.id("target-understood").waitFor();
    await app.drawn("target-understood", 4);
    await app.id("understood-flip").tap();
    assert.equal(await seen(app, "understood"), 100);
    await app.fits(app.id("searches-dialog"));
    await shot("69-narrow-target-understood");
    await app.accessible("360 x 740, a picture as understood");
    await app.id("searches-close").tap();
    await app.id("searches-dialog").waitFor({ state: "detached" });
  });
}
