// A journey through the page in a real Chromium: breed, recombine, undo, redo, upload, keyboard, a
// narrow screen. Screenshots go to $BROOD_PICTURES, or target/browser. Prints one line of figures
// at the end; any failure exits with 1.

import { strict as assert } from "node:assert";
import { existsSync } from "node:fs";
import { mkdir, readFile } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

import { broodExport } from "./brood_export.mjs";
import { bumps, bumpsLive } from "./bumps.mjs";
import { clearLive } from "./clear_live.mjs";
import { compare, compareByFinger } from "./compare.mjs";
import { comparison, comparisonByFinger } from "./comparison.mjs";
import { edited, editedByFinger, editedLive } from "./edited.mjs";
import { favourites, favouritesByFinger, lineages } from "./favourites.mjs";
import { film } from "./film.mjs";
import { hurried } from "./hurried.mjs";
import { inspect, inspectByFinger, limitedLive } from "./inspect.mjs";
import { exported, live } from "./live.mjs";
import { long } from "./long.mjs";
import { materials } from "./materials.mjs";
import { models, modelsLive } from "./models.mjs";
import { neighboursLive } from "./neighbours.mjs";
import { BroodPage } from "./page.mjs";
import { painted } from "./painted.mjs";
import { painter } from "./painter.mjs";
import { paintedLive } from "./painted_live.mjs";
import { photo, photoByFinger } from "./photo.mjs";
import { sceneImages, sceneImagesByFinger, sceneImagesLive } from "./scene_images.mjs";
import { search, searchByFinger } from "./search.mjs";
import { binary, startServer } from "./server.mjs";
import { shadowsLive } from "./shadows.mjs";
import { steer } from "./steer.mjs";
import { surrounded } from "./surrounded.mjs";
import { surroundings } from "./surroundings.mjs";
import { target, targetByFinger } from "./target.mjs";
import { troubled } from "./troubled.mjs";
import { visitor } from "./visitor.mjs";

const FLAGS = [
  "--headless",
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];
/** Flags for no WebGL at all, and for WebGL in software. */
const PLAIN = [...FLAGS, "--disable-gpu", "--disable-3d-apis"];
const DRAWING = [...FLAGS, "--enable-unsafe-swiftshader"];
const TIMEOUT_MS = 120_000;
const pictures =
  process.env.BROOD_PICTURES ?? fileURLToPath(new URL("../../target/browser", import.meta.url));

const PYRAMID = await readFile(new URL("../data/pyramid.obj", import.meta.url), "utf8");

/** Saves a picture of the page by name. */
const shotOf = (app) => (name) => app.page.screenshot({ path: join(pictures, `${name}.png`) });

let steps = 0;

/** Runs a step of the journey, and prints its time and the text that it returns. */
async function step(name, work) {
  const start = performance.now();
  try {
    const result = await work();
    steps += 1;
    const text = typeof result === "string" ? `, ${result}` : "";
    console.log(`${name}: ${Math.round(performance.now() - start)} ms${text}`);
    return result;
  } catch (error) {
    error.message = `${name}: ${error.message}`;
    throw error;
  }
}

async function wide(app) {
  const shot = shotOf(app);

  await step("opens with believable materials", async () => {
    const generation = await app.generation(await app.open());
    assert.equal(generation.individuals.length, 20);
    assert.ok(generation.individuals.every(({ operator }) => operator === "random"));
    assert.equal(generation.energy_limit, true);
    const lineage = await app.api(`/v1/lineages/${generation.lineage}`);
    assert.deepEqual([lineage.start, lineage.energy_limit], ["believable", true]);
    await shot("1-believable");
    const child = await app.generation(await app.becomes(() => app.cell(5).click()));
    assert.ok(child.individuals.every(({ live_instructions: live }) => live === 18));
    await shot("1-believable-children");
  });

  await steer(app, step, shot);

  await step("starts a lineage with presets, and one of random programs", async () => {
    for (const [start, operator] of [["presets", "adopt"], ["wild", "random"]]) {
      await app.id("lineage-menu").click();
      await app.id("lineage-name").fill(`begun ${start}`);
      await app.page.getByRole("radio", { name: start }).check();
      const made = await app.generation(await app.becomes(() => app.id("lineage-new").click()));
      assert.ok(made.individuals.every((one) => one.operator === operator));
    }
  });

  const first = await step("draws a random brood", async () => {
    const generation = await app.generation(await app.becomes(() => app.id("afresh").click()));
    assert.equal(generation.individuals.length, 20);
    await shot("1-random");
    return generation;
  });

  let parent = first;
  for (const slot of [3, 11, 16]) {
    parent = await step(`breeds from cell ${slot}`, async () => {
      const child = await app.generation(await app.becomes(() => app.cell(slot).click()));
      assert.deepEqual(child.parents, [parent.individuals[slot].id]);
      assert.equal(child.centre.id, parent.individuals[slot].id);
      return child;
    });
  }
  await shot("2-third-generation");

  const recombined = await step("recombines by right click then left click", async () => {
    await app.cell(2).click({ button: "right" });
    await app.id("mate-badge").waitFor({ state: "visible" });
    const child = await app.generation(await app.becomes(() => app.cell(7).click()));
    assert.deepEqual(child.parents, [parent.individuals[7].id, parent.individuals[2].id]);
    assert.equal(child.individuals[0].operator, "recombine");
    await shot("3-recombined");
    return child;
  });

  await step("unmarks the mate on Escape", async () => {
    await app.cell(4).click({ button: "right" });
    await app.id("mate-badge").waitFor({ state: "visible" });
    await app.page.keyboard.press("Escape");
    await app.id("mate-badge").waitFor({ state: "hidden" });
  });

  await step("undoes twice and redoes", async () => {
    await app.id("undo").click();
    await app.shows(parent.id);
    await app.id("undo").click();
    await app.ready(parent.id);
    await app.id("redo").click();
    await app.shows(parent.id);
    await app.id("redo").click();
    await app.shows(recombined.id);
  });

  const branch = await step("branches from an earlier generation and loses nothing", async () => {
    await app.id("undo").click();
    await app.shows(parent.id);
    const child = await app.generation(await app.becomes(() => app.cell(0).click()));
    assert.deepEqual(child.parents, [parent.individuals[0].id]);
    const all = await app.api(`/v1/lineages/${child.lineage}/generations`);
    assert.ok(
      all.items.some((it) => it.id === recombined.id),
      "the other branch is still there",
    );
    await shot("4-branch");
    return child;
  });

  const keyed = await step("breeds by keyboard alone", async () => {
    await app.cell(0).focus();
    await app.page.keyboard.press("ArrowRight");
    const generation = await app.becomes(() => app.page.keyboard.press("Enter"));
    const child = await app.generation(generation);
    assert.deepEqual(child.parents, [branch.individuals[1].id]);
    return child;
  });

  await step("enters the frames by an arrow key while nothing has the focus", async () => {
    await app.cell(2).focus();
    await app.page.evaluate(() => /** @type {HTMLElement} */ (document.activeElement).blur());
    await app.page.keyboard.press("ArrowRight");
    await app.page.waitForFunction(() => document.activeElement?.matches('[data-cell="3"]'));
  });

  await step("re-rolls the same parents", async () => {
    const child = await app.generation(await app.becomes(() => app.id("reroll").click()));
    assert.deepEqual(child.parents, keyed.parents);
    assert.notEqual(child.seed, keyed.seed);
  });

  await step("shows an uploaded object", async () => {
    const before = await app.cell(0).locator("img").first().getAttribute("src");
    const answered = app.page.waitForResponse((it) => it.url().endsWith("/v1/meshes"));
    const file = { name: "pyramid.obj", mimeType: "model/obj", buffer: Buffer.from(PYRAMID) };
    await app.id("obj-file").setInputFiles(file);
    const answer = await answered;
    assert.equal(answer.status(), 201);
    const mesh = await answer.json();
    const moved = app.cell(0).locator(`img:not([src="${before}"])`).first();
    await moved.waitFor();
    await app.ready();
    const id = await app.page.locator("body").getAttribute("data-ready");
    const lineage = await app.api(`/v1/lineages/${(await app.generation(id)).lineage}`);
    const scene = await app.api(`/v1/scenes/${lineage.scene}`);
    assert.equal(scene.mesh, mesh.id);
    await shot("5-uploaded");
  });

  await step("turns and scales the object by hand", async () => {
    const box = await app.id("centre").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const mouse = app.page.mouse;
    const turned = await app.reshown(async () => {
      await mouse.move(x, y);
      await mouse.down();
      await mouse.move(x + 60, y + 20, { steps: 4 });
      await mouse.up();
    });
    assert.notDeepEqual(turned.rotation_deg, [0, 0, 0]);
    const scaled = await app.reshown(() => mouse.wheel(0, 300));
    assert.notEqual(scaled.scale, turned.scale);
    assert.deepEqual(scaled.rotation_deg, turned.rotation_deg);
    await shot("6-turned");
  });

  await step("keeps a favourite", async () => {
    const generation = await app.generation(await app.ready());
    const answered = app.page.waitForResponse((it) => it.request().method() === "PATCH");
    await app.cell(3).focus();
    await app.page.keyboard.press("f");
    assert.equal((await answered).status(), 200);
    const favourites = await app.api("/v1/individuals?favourite=true");
    assert.deepEqual(
      favourites.items.map((it) => it.id),
      [generation.individuals[3].id],
    );
  });

  await step("explains what is wrong with a broken object", async () => {
    const file = { name: "broken.obj", mimeType: "model/obj", buffer: Buffer.from("v 0 nan 0\n") };
    await app.id("obj-file").setInputFiles(file);
    const error = app.id("error");
    await error.waitFor({ state: "visible" });
    assert.match(await error.innerText(), /\b1\b/, "the line is named");
    // The browser logs the refused upload itself; any other message is a failure.
    app.complaints = app.complaints.filter((text) => !text.includes("422"));
  });

  await step("restores its state from the link", async () => {
    const generation = await app.ready();
    const hash = new URL(app.page.url()).hash;
    assert.ok(hash.includes(generation), `${hash} names ${generation}`);
    // As in another browser, which has to read the object's warnings.
    await app.page.evaluate(() => {
      for (const key of Object.keys(localStorage))
        if (key.includes("meshes")) localStorage.removeItem(key);
    });
    await app.page.reload();
    await app.shows(generation);
    await app.id("mesh-facts").waitFor({ state: "visible" });
  });

  await step("has no accessibility violations", () => app.accessible("1440 x 985"));
  app.quiet();
}

async function coming(app, base) {
  const shot = shotOf(app);
  await materials(app, step, shot);
  await compare(app, step, shot);
  await comparison(app, step, shot);
  await models(app, step, shot, binary);
  await bumps(app, step, shot, base);
  await painted(app, step, shot);
  await surroundings(app, step, shot);
  await sceneImages(app, step, shot);
  await edited(app, step, shot);
  await painter(app, step, shot);
}

async function keeping(app, base) {
  const shot = shotOf(app);
  await favourites(app, step, shot, base);
  await lineages(app, step, shot);
  await long(app, step, shot, base);
}

async function looking(app, base) {
  await inspect(app, step, shotOf(app), base);
  await broodExport(app, step, shotOf(app), base);
}

async function searching(app, base) {
  const shot = shotOf(app);
  await search(app, step, shot, base);
  await target(app, step, shot, base);
  await photo(app, step, shot, base);
}

async function inAHurry(app, base) {
  await hurried(app, step, base);
}

async function inTrouble(app, base) {
  await troubled(app, step, shotOf(app), base);
}

async function drawn(app, base) {
  const shot = shotOf(app);
  await live(app, step, shot, base);
  await surrounded(app, step, shot, base);
  await sceneImagesLive(app, step, shot, base);
  await shadowsLive(app, step, shot, base);
  await paintedLive(app, step, shot, base);
  await clearLive(app, step, shot, base);
  await neighboursLive(app, step, shot, base);
  await film(app, step, shot, base);
  await bumpsLive(app, step, shot, base);
  await limitedLive(app, step, shot, base);
  await modelsLive(app, step, shot, base);
  await editedLive(app, step, shot, base);
  await exported(app, step, binary);
  app.quiet();
}

async function first(app, base) {
  await visitor(app, step, shotOf(app), base);
}

async function narrow(app, base) {
  await step("breeds by tap on a screen of 360 pixels", async () => {
    await app.open();
    await app.fits(app.page.locator("html"));
    await app.fits(app.id("lineage-menu").locator(".cut"));
    await app.becomes(() => app.cell(5).tap());
    await app.page.screenshot({ path: join(pictures, "7-narrow.png") });
    await app.accessible("360 x 740");
  });
  await compareByFinger(app, step, shotOf(app));
  await inspectByFinger(app, step, shotOf(app));
  await comparisonByFinger(app, step, shotOf(app));
  await favouritesByFinger(app, step, shotOf(app), base);
  await searchByFinger(app, step, shotOf(app));
  await targetByFinger(app, step, shotOf(app), base);
  await photoByFinger(app, step, shotOf(app), base);
  await editedByFinger(app, step, shotOf(app));
  await sceneImagesByFinger(app, step, shotOf(app));
  app.quiet();
}

async function main() {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  assert.ok(
    existsSync(executablePath),
    `no browser at ${executablePath}: install chromium or set $CHROMIUM`,
  );
  await mkdir(pictures, { recursive: true });
  const server = await startServer();
  // A first visit must find nothing that other journeys made.
  const empty = await startServer();
  let browser, ended;
  try {
    for (const [journey, args, options, { url } = server] of [
      [first, PLAIN, { viewport: { width: 1100, height: 760 } }, empty],
      [wide, PLAIN, { viewport: { width: 1440, height: 985 } }],
      [narrow, PLAIN, { viewport: { width: 360, height: 740 }, hasTouch: true }],
      [coming, PLAIN, { viewport: { width: 1440, height: 985 } }],
      [keeping, PLAIN, { viewport: { width: 1280, height: 900 } }],
      [inAHurry, PLAIN, { viewport: { width: 1440, height: 985 } }],
      [inTrouble, PLAIN, { viewport: { width: 1440, height: 985 } }],
      [
        looking,
        PLAIN,
        {
          viewport: { width: 1440, height: 985 },
          permissions: ["clipboard-read", "clipboard-write"],
        },
      ],
      [searching, PLAIN, { viewport: { width: 1440, height: 985 } }, empty],
      [drawn, DRAWING, { viewport: { width: 1100, height: 760 } }],
    ]) {
      browser = await chromium.launch({ executablePath, args });
      const context = await browser.newContext({ ...options, reducedMotion: "reduce" });
      context.setDefaultTimeout(TIMEOUT_MS);
      const app = new BroodPage(await context.newPage(), url);
      try {
        await journey(app, url);
      } catch (error) {
        await app.page.screenshot({ path: join(pictures, "failed.png") });
        console.error(`the page complained: ${JSON.stringify(app.complaints)}`);
        throw error;
      }
      await browser.close();
    }
  } catch (error) {
    console.error(
      `the servers' logs end so:\n${[server, empty].map((it) => it.log().slice(-4000)).join("\n")}`,
    );
    throw error;
  } finally {
    await browser?.close();
    ended = [await server.stop(), await empty.stop()];
  }
  assert.deepEqual(ended, [0, 0], "the servers ended cleanly");
  console.log(`browser journey: ${steps} steps passed, pictures in ${pictures}`);
}

main().catch((error) => {
  console.error(error);
  // The stack leaves out the step.
  console.error(error.message);
  process.exitCode = 1;
});
