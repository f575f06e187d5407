// One journey through the page in a real Chromium: breed, recombine, undo, redo, upload, keyboard, a narrow screen.
// Screenshots go to $BROOD_PICTURES, or target/browser. Ends with one line of figures; any failure ends it with 1.

import { strict as assert } from "node:assert";
import { existsSync } from "node:fs";
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

import { compare, compareByFinger } from "./compare.mjs";
import { comparison, comparisonByFinger } from "./comparison.mjs";
import { film } from "./film.mjs";
import { hurried } from "./hurried.mjs";
import { inspect, inspectByFinger, limitedLive } from "./inspect.mjs";
import { exported, live } from "./live.mjs";
import { materials } from "./materials.mjs";
import { models, modelsLive } from "./models.mjs";
import { BroodPage } from "./page.mjs";
import { search, searchByFinger } from "./search.mjs";
import { binary, startServer } from "./server.mjs";
import { target, targetByFinger } from "./target.mjs";
import { visitor } from "./visitor.mjs";

const FLAGS = [
  "--headless", "--no-sandbox", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync",
];
/** Without any WebGL, and with the browser's own in software. */
const PLAIN = [...FLAGS, "--disable-gpu", "--disable-3d-apis"];
const DRAWING = [...FLAGS, "--enable-unsafe-swiftshader"];
const TIMEOUT_MS = 60_000;
const pictures = process.env.BROOD_PICTURES ?? fileURLToPath(new URL("../../target/browser", import.meta.url));

const PYRAMID = `v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v 0 1.5 0
f 1 2 3 4
f 1 5 2
f 2 5 3
f 3 5 4
f 4 5 1
`;

let steps = 0;

async function step(name, work) {
  const start = performance.now();
  try {
    const result = await work();
    steps += 1;
    console.log(`${name}: ${Math.round(performance.now() - start)} ms`);
    return result;
  } catch (error) {
    error.message = `${name}: ${error.message}`;
    throw error;
  }
}

async function wide(hand) {
  const shot = (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) });

  const first = await step("opens with a random brood", async () => {
    const id = await hand.open();
    const generation = await hand.generation(id);
    assert.equal(generation.individuals.length, 20);
    await shot("1-random");
    return generation;
  });

  let parent = first;
  for (const slot of [3, 11, 16]) {
    parent = await step(`breeds from cell ${slot}`, async () => {
      const child = await hand.generation(await hand.becomes(() => hand.cell(slot).click()));
      assert.deepEqual(child.parents, [parent.individuals[slot].id]);
      assert.equal(child.centre.id, parent.individuals[slot].id);
      return child;
    });
  }
  await shot("2-third-generation");

  const recombined = await step("recombines by right click then left click", async () => {
    await hand.cell(2).click({ button: "right" });
    await hand.id("mate-badge").waitFor({ state: "visible" });
    const child = await hand.generation(await hand.becomes(() => hand.cell(7).click()));
    assert.deepEqual(child.parents, [parent.individuals[7].id, parent.individuals[2].id]);
    assert.equal(child.individuals[0].operator, "recombine");
    await shot("3-recombined");
    return child;
  });

  await step("forgets the mate on Escape", async () => {
    await hand.cell(4).click({ button: "right" });
    await hand.id("mate-badge").waitFor({ state: "visible" });
    await hand.page.keyboard.press("Escape");
    await hand.id("mate-badge").waitFor({ state: "hidden" });
  });

  await step("undoes twice and redoes", async () => {
    await hand.id("undo").click();
    await hand.shows(parent.id);
    await hand.id("undo").click();
    await hand.ready(parent.id);
    await hand.id("redo").click();
    await hand.shows(parent.id);
    await hand.id("redo").click();
    await hand.shows(recombined.id);
  });

  const branch = await step("branches from an earlier generation and loses nothing", async () => {
    await hand.id("undo").click();
    await hand.shows(parent.id);
    const child = await hand.generation(await hand.becomes(() => hand.cell(0).click()));
    assert.deepEqual(child.parents, [parent.individuals[0].id]);
    const all = await hand.api(`/v1/lineages/${child.lineage}/generations`);
    assert.ok(all.items.some((it) => it.id === recombined.id), "the other branch is still there");
    await shot("4-branch");
    return child;
  });

  const keyed = await step("breeds by keyboard alone", async () => {
    await hand.cell(0).focus();
    await hand.page.keyboard.press("ArrowRight");
    const generation = await hand.becomes(() => hand.page.keyboard.press("Enter"));
    const child = await hand.generation(generation);
    assert.deepEqual(child.parents, [branch.individuals[1].id]);
    return child;
  });

  await step("re-rolls the same parents", async () => {
    const child = await hand.generation(await hand.becomes(() => hand.id("reroll").click()));
    assert.deepEqual(child.parents, keyed.parents);
    assert.notEqual(child.seed, keyed.seed);
  });

  await step("shows an uploaded object", async () => {
    const before = await hand.cell(0).locator("img").first().getAttribute("src");
    const answered = hand.page.waitForResponse((it) => it.url().endsWith("/v1/meshes"));
    const file = { name: "pyramid.obj", mimeType: "model/obj", buffer: Buffer.from(PYRAMID) };
    await hand.id("obj-file").setInputFiles(file);
    const answer = await answered;
    assert.equal(answer.status(), 201);
    const mesh = await answer.json();
    const moved = hand.cell(0).locator(`img:not([src="${before}"])`).first();
    await moved.waitFor();
    await hand.ready();
    const id = await hand.page.locator("body").getAttribute("data-ready");
    const lineage = await hand.api(`/v1/lineages/${(await hand.generation(id)).lineage}`);
    const scene = await hand.api(`/v1/scenes/${lineage.scene}`);
    assert.equal(scene.mesh, mesh.id);
    await shot("5-uploaded");
  });

  await step("turns and scales the object by hand", async () => {
    const box = await hand.id("centre").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const mouse = hand.page.mouse;
    const turned = await hand.reshown(async () => {
      await mouse.move(x, y);
      await mouse.down();
      await mouse.move(x + 60, y + 20, { steps: 4 });
      await mouse.up();
    });
    assert.notDeepEqual(turned.rotation_deg, [0, 0, 0]);
    const scaled = await hand.reshown(() => mouse.wheel(0, 300));
    assert.notEqual(scaled.scale, turned.scale);
    assert.deepEqual(scaled.rotation_deg, turned.rotation_deg);
    await shot("6-turned");
  });

  await step("keeps a favourite", async () => {
    const generation = await hand.generation(await hand.ready());
    const answered = hand.page.waitForResponse((it) => it.request().method() === "PATCH");
    await hand.cell(3).focus();
    await hand.page.keyboard.press("f");
    assert.equal((await answered).status(), 200);
    const favourites = await hand.api("/v1/individuals?favourite=true");
    assert.deepEqual(favourites.items.map((it) => it.id), [generation.individuals[3].id]);
  });

  await step("says what is wrong with a broken object", async () => {
    const file = { name: "broken.obj", mimeType: "model/obj", buffer: Buffer.from("v 0 nan 0\n") };
    await hand.id("obj-file").setInputFiles(file);
    const error = hand.id("error");
    await error.waitFor({ state: "visible" });
    assert.match(await error.innerText(), /\b1\b/, "the line is named");
    // The browser itself logs the refused upload; nothing else may stand in the log.
    hand.complaints = hand.complaints.filter((text) => !text.includes("422"));
  });

  await step("restores its state from the link", async () => {
    const generation = await hand.ready();
    const hash = new URL(hand.page.url()).hash;
    assert.ok(hash.includes(generation), `${hash} names ${generation}`);
    // As in another browser: what was odd about the object is asked for again.
    await hand.page.evaluate(() => {
      for (const key of Object.keys(localStorage)) if (key.includes("meshes")) localStorage.removeItem(key);
    });
    await hand.page.reload();
    await hand.shows(generation);
    await hand.id("mesh-facts").waitFor({ state: "visible" });
  });

  await step("has nothing that hinders access", () => hand.accessible("1440 x 985"));
  hand.quiet();
}

async function coming(hand) {
  const shot = (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) });
  await materials(hand, step, shot);
  await compare(hand, step, shot);
  await comparison(hand, step, shot);
  await models(hand, step, shot, binary);
}

async function looking(hand, base) {
  await inspect(hand, step, (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) }), base);
}

async function searching(hand, base) {
  const shot = (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) });
  await search(hand, step, shot, base);
  await target(hand, step, shot, base);
}

async function inAHurry(hand, base) {
  await hurried(hand, step, base);
}

async function drawn(hand, base) {
  const shot = (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) });
  await live(hand, step, shot, base);
  await film(hand, step, shot);
  await limitedLive(hand, step, shot, base);
  await modelsLive(hand, step, shot, base);
  await exported(hand, step, binary);
  hand.quiet();
}

async function first(hand, base) {
  await visitor(hand, step, (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) }), base);
}

async function narrow(hand, base) {
  await step("breeds by tap on a screen of 360 pixels", async () => {
    await hand.open();
    const sideways = () => document.documentElement.scrollWidth - document.documentElement.clientWidth;
    assert.ok((await hand.page.evaluate(sideways)) <= 0, "nothing sticks out sideways");
    await hand.becomes(() => hand.cell(5).tap());
    await hand.page.screenshot({ path: join(pictures, "7-narrow.png") });
    await hand.accessible("360 x 740");
  });
  await compareByFinger(hand, step, (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) }));
  await inspectByFinger(hand, step, (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) }));
  await comparisonByFinger(hand, step, (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) }));
  await searchByFinger(hand, step, (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) }));
  await targetByFinger(hand, step, (name) => hand.page.screenshot({ path: join(pictures, `${name}.png`) }), base);
  hand.quiet();
}

async function main() {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  assert.ok(existsSync(executablePath), `no browser at ${executablePath}: install chromium or set $CHROMIUM`);
  await mkdir(pictures, { recursive: true });
  const server = await startServer();
  // Whoever comes for the first time finds nothing that others made.
  const empty = await startServer();
  let browser, ended;
  try {
    for (const [journey, args, options, { url } = server] of [
      [first, PLAIN, { viewport: { width: 1100, height: 760 } }, empty],
      [wide, PLAIN, { viewport: { width: 1440, height: 985 } }],
      [narrow, PLAIN, { viewport: { width: 360, height: 740 }, hasTouch: true }],
      [coming, PLAIN, { viewport: { width: 1440, height: 985 } }],
      [inAHurry, PLAIN, { viewport: { width: 1440, height: 985 } }],
      [looking, PLAIN, { viewport: { width: 1440, height: 985 }, permissions: ["clipboard-read", "clipboard-write"] }],
      [searching, PLAIN, { viewport: { width: 1440, height: 985 } }, empty],
      [drawn, DRAWING, { viewport: { width: 1100, height: 760 } }],
    ]) {
      browser = await chromium.launch({ executablePath, args });
      const context = await browser.newContext({ ...options, reducedMotion: "reduce" });
      context.setDefaultTimeout(TIMEOUT_MS);
      const hand = new BroodPage(await context.newPage(), url);
      try {
        await journey(hand, url);
      } catch (error) {
        await hand.page.screenshot({ path: join(pictures, "failed.png") });
        console.error(`the page complained: ${JSON.stringify(hand.complaints)}`);
        throw error;
      }
      await browser.close();
    }
  } catch (error) {
    console.error(`the servers' logs end so:\n${[server, empty].map((it) => it.log().slice(-4000)).join("\n")}`);
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
  process.exitCode = 1;
});
