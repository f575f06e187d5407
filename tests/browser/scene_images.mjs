// Images of scenes: a picture behind the object, and normal maps of the object, of another object
// and of the ground. Live frames with a picture behind them are compared with the server's.

import { strict as assert } from "node:assert";

import { comparedAround, openLineage } from "./drawn_live.mjs";
import { change, seen } from "./edited.mjs";
import { allLit, asServerDraws, hold, loseContext, noneLit, slide, underLamp } from "./live.mjs";
import { goTo, turnByHand } from "./materials.mjs";
import { drop, painting } from "./painted.mjs";
import { asPhone } from "./photo.mjs";
import { onPixels } from "./pixels.mjs";
import { poster } from "./server.mjs";

/** Largest difference of a code of the picture behind the object. */
const CODES = 4;
/**
 * Largest share of pixels apart: edges of the object before the picture, which the page mixes in
 * codes and the server in linear light.
 */
const APART = 0.06;

/** A file for a field. @param {string} base64 */
const png = (name, base64) => ({
  name,
  mimeType: "image/png",
  buffer: Buffer.from(base64, "base64"),
});
const BROKEN = { name: "broken.png", mimeType: "image/png", buffer: Buffer.from("no picture") };

/** PNG of a normal map of round bumps, drawn by the browser. @returns base64 */
const bumps = (page) =>
  page.evaluate(() => {
    const side = 128;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [side, side];
    const context = canvas.getContext("2d");
    const image = context.createImageData(side, side);
    for (let y = 0; y < side; y += 1)
      for (let x = 0; x < side; x += 1) {
        const angle = (at) => (8 * Math.PI * at) / side;
        // Steeper ones take the server ten times as long.
        const slopes = [0.22 * Math.sin(angle(x)), -0.22 * Math.sin(angle(y))];
        const length = Math.hypot(...slopes, 1);
        const codes = [...slopes, 1].map((part) => 127.5 + (127.5 * part) / length);
        image.data.set([...codes, 255], 4 * (y * side + x));
      }
    context.putImageData(image, 0, 0);
    return canvas.toDataURL("image/png").split(",")[1];
  });

/** PNG that is opaque on the left and clear on the right, drawn by the browser. @returns base64 */
export const glass = (page) =>
  page.evaluate(() => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [150, 400];
    const context = canvas.getContext("2d");
    const ramp = context.createLinearGradient(0, 0, 150, 0);
    ramp.addColorStop(0.2, "rgb(40 120 230)");
    ramp.addColorStop(0.9, "rgb(250 220 60 / 0)");
    context.fillStyle = ramp;
    context.fillRect(0, 0, 150, 400);
    return canvas.toDataURL("image/png").split(",")[1];
  });

/** Codes of the upper left pixel of the picture in the centre, and the share that is covered. */
const corner = (app) =>
  app.page.evaluate(async () => {
    const image = document.querySelector("[data-testid=centre] img");
    await image.decode();
    const [width, height] = [image.naturalWidth, image.naturalHeight];
    const pen = new OffscreenCanvas(width, height).getContext("2d");
    pen.drawImage(image, 0, 0);
    const { data } = pen.getImageData(0, 0, width, height);
    let opaque = 0;
    for (let at = 3; at < data.length; at += 4) opaque += data[at] > 250 ? 1 : 0;
    return { code: [...data.slice(0, 4)], covered: opaque / width / height };
  });

/** Runs the part of the journey; `shot` saves a screenshot. */
export async function sceneImages(app, step, shot) {
  const { page } = app;
  const knobs = page.getByRole("complementary", { name: "Knobs" });
  const art = png("art.png", await painting(page));
  const map = png("bumps.png", await bumps(page));
  await underLamp(app);

  const behind = knobs.getByRole("group", { name: "Backdrop" });
  const choice = behind.getByLabel("Backdrop", { exact: true });

  await step("says why a file is no picture, and shows the backdrop of the scene again", async () => {
    await choice.selectOption({ label: "picture" });
    await behind.getByLabel("Open a picture of the backdrop").setInputFiles(BROKEN);
    await behind.getByRole("alert").getByText("must be a PNG or JPEG file").waitFor();
    assert.equal(await choice.inputValue(), "none");
    app.complaints = app.complaints.filter((text) => !text.includes("422"));
    await shot("46-no-picture");
  });

  let first = null;
  await step("shows a picture behind the object", async () => {
    await choice.selectOption({ label: "picture" });
    assert.equal(await behind.getByRole("alert").count(), 0);
    const scene = await app.reshown(() => app.id("backdrop-image").setInputFiles(art));
    assert.equal(scene.backdrop.kind, "image");
    assert.equal(await choice.inputValue(), "image");
    const small = behind.getByRole("img");
    assert.equal(await small.getAttribute("src"), `/v1/images/${scene.backdrop.image}`);
    await app.drawn("backdrop-field", 1);
    const { code, covered } = await corner(app);
    assert.equal(covered, 1);
    // The square in the middle begins at a fifth of the width: of the ramp from #542d15 to #f0823c.
    const wanted = [0x54 + 0.2 * (0xf0 - 0x54), 0x2d + 0.2 * (0x82 - 0x2d), 0x15 + 0.2 * (0x3c - 0x15)];
    wanted.forEach((one, at) => assert.ok(Math.abs(code[at] - one) < CODES, `${code} is ${wanted}`));
    first = code;
    await behind.scrollIntoViewIfNeeded();
    await shot("46-picture");
    await app.accessible("a picture behind the object");
    await app.fits(behind);
  });

  await step("turns a photograph upright", async () => {
    const phone = await asPhone(page, art);
    await app.reshown(() => app.id("backdrop-image").setInputFiles(phone));
    const { code } = await corner(app);
    first.forEach((one, at) => assert.ok(Math.abs(code[at] - one) < 3 * CODES, `${code} is ${first}`));
  });

  await step("replaces it by a picture that is dropped, and keeps what is clear", async () => {
    const file = { name: "glass.png", type: "image/png", base64: await glass(page) };
    const scene = await app.reshown(() => drop(behind, file));
    assert.equal(scene.backdrop.kind, "image");
    const { code, covered } = await corner(app);
    assert.ok(covered < 0.9, "the right of the picture is clear");
    assert.ok(code[3] === 255 && code[2] > 200, `${code} is blue`);
    await shot("46-clear-picture");
    await app.id("backdrop-image").setInputFiles(BROKEN);
    await behind.getByRole("alert").waitFor();
    assert.equal(await choice.inputValue(), "image");
    app.complaints = app.complaints.filter((text) => !text.includes("422"));
    const { backdrop } = await app.reshown(() => choice.selectOption({ label: "none" }));
    assert.equal(backdrop ?? null, null);
    assert.equal(await behind.getByRole("img").count(), 0);
  });

  await step("gives the object a normal map, and changes strength and repetitions", async () => {
    const own = knobs.getByRole("group", { name: "Normal map of the object" });
    await app.reshown(() => app.id("object").selectOption("sphere"));
    const before = await seen(app);
    const scene = await app.reshown(() => app.id("normal-map").setInputFiles(map));
    assert.deepEqual({ ...scene.normal_map, image: "" }, { image: "", strength: 1, repeat: 1 });
    assert.ok((await change(page, before, await seen(app))) > 0.05, "the bumps are seen");
    await own.getByRole("img").waitFor();
    const bumpy = await seen(app);
    const dented = await app.reshown(() => own.getByLabel("Strength").fill("-1"));
    assert.equal(dented.normal_map.strength, -1);
    assert.ok((await change(page, bumpy, await seen(app))) > 0.05, "bumps become dents");
    await own.getByLabel("Repeats").focus();
    const often = await app.reshown(() => page.keyboard.press("ArrowRight"));
    assert.deepEqual(often.normal_map, { ...scene.normal_map, strength: -1, repeat: 2 });
    await own.scrollIntoViewIfNeeded();
    await shot("46-normal-map");
    await app.accessible("a normal map");
    await app.fits(own);
    const knob = await app.reshown(() => app.id("object").selectOption("knob"));
    assert.deepEqual(knob.normal_map, often.normal_map);
    const removed = await app.reshown(() => app.id("normal-map-remove").click());
    assert.equal(removed.normal_map ?? null, null);
    await own.getByRole("img").waitFor({ state: "detached" });
  });

  await step("keeps numbers beyond the sliders, which a script has set", async () => {
    const { lineage } = await app.generation(await app.ready());
    const { scene: id, version } = await app.api(`/v1/lineages/${lineage}`);
    const scene = await app.api(`/v1/scenes/${id}`);
    const base = new URL(page.url()).origin;
    const image = await uploaded(base, map.buffer.toString("base64"));
    const normal_map = { image, strength: 0.55, repeat: 64.5 };
    const { id: beyond } = await poster(base)("/v1/scenes", { ...scene, normal_map, id: undefined });
    const before = await app.cell(0).locator("img").first().getAttribute("src");
    const headers = { "content-type": "application/json", "if-match": `"${version}"` };
    const init = { method: "PATCH", headers, body: JSON.stringify({ scene: beyond }) };
    assert.equal((await fetch(`${base}/v1/lineages/${lineage}`, init)).status, 200);
    await app.cell(0).locator(`img:not([src="${before}"])`).first().waitFor();
    await app.ready();
    assert.equal(await page.locator("output[for=normal-repeat]").textContent(), "64.5");
    const weaker = await app.reshown(() => app.id("normal-strength").fill("0.3"));
    assert.deepEqual([weaker.normal_map.strength, weaker.normal_map.repeat], [0.3, 64.5]);
    await app.reshown(() => app.id("normal-map-remove").click());
  });

  await step("gives the ground and another object normal maps", async () => {
    const ground = page.locator("label", { has: app.id("ground") });
    await app.reshown(() => ground.click());
    await app.reshown(() => app.id("neighbour").selectOption("sphere"));
    const flat = await seen(app);
    const beneath = await app.reshown(() => app.id("ground-normal-map").setInputFiles(map));
    assert.equal(beneath.ground.normal_map.repeat, 1);
    const often = await app.reshown(() => app.id("ground-normal-repeat").fill("8"));
    assert.equal(often.ground.normal_map.repeat, 8);
    const group = knobs.getByRole("group", { name: "Normal map of the other object" });
    const file = { name: "bumps.png", type: "image/png", base64: map.buffer.toString("base64") };
    const both = await app.reshown(() => drop(group, file));
    assert.equal(both.objects[0].normal_map.image, both.ground.normal_map.image);
    assert.equal(both.normal_map ?? null, null);
    assert.ok((await change(page, flat, await seen(app))) > 0.01, "the bumps are seen");
    const moved = await app.reshown(() => app.id("neighbour-around").fill("300"));
    assert.deepEqual(moved.objects[0].normal_map, both.objects[0].normal_map);
    const ball = await app.reshown(() => app.id("neighbour").selectOption("ball"));
    assert.deepEqual(ball.objects[0].normal_map, both.objects[0].normal_map);
    await group.scrollIntoViewIfNeeded();
    await shot("46-normal-maps-around");
    await app.accessible("normal maps around");
    await app.fits(knobs);
    const smooth = await app.reshown(() => app.id("neighbour-normal-map-remove").click());
    assert.equal(smooth.objects[0].normal_map ?? null, null);
    await app.reshown(() => app.id("neighbour").selectOption("none"));
    const bare = await app.reshown(() => ground.click());
    assert.equal(bare.ground ?? null, null);
  });
  app.quiet();
}

/** Images of scenes on a screen of 360 pixels. */
export async function sceneImagesByFinger(app, step, shot) {
  const { page } = app;
  await step("shows images of the scene on a screen of 360 pixels", async () => {
    const map = png("bumps.png", await bumps(page));
    const art = png("art.png", await painting(page));
    await app.id("knobs-toggle").tap();
    const knobs = page.getByRole("complementary", { name: "Knobs" });
    const own = knobs.getByRole("group", { name: "Normal map of the object" });
    await app.reshown(() => app.id("normal-map").setInputFiles(map));
    await app.drawn("normal-map-field", 1);
    await own.scrollIntoViewIfNeeded();
    await app.fits(knobs);
    await app.accessible("a normal map, 360 x 740");
    await shot("46-normal-map-narrow");
    await app.id("backdrop").selectOption("image");
    await app.reshown(() => app.id("backdrop-image").setInputFiles(art));
    await app.id("backdrop-field").scrollIntoViewIfNeeded();
    await app.fits(knobs);
    await shot("46-picture-narrow");
    await app.reshown(() => app.id("backdrop").selectOption("none"));
    await app.reshown(() => app.id("normal-map-remove").tap());
    await page.getByRole("button", { name: "Close the knobs" }).tap();
  });
}

/** Uploads a PNG; returns its id. @param {string} base @param {string} base64 */
export async function uploaded(base, base64) {
  const headers = { "content-type": "image/png" };
  const body = Buffer.from(base64, "base64");
  const answer = await fetch(`${base}/v1/images`, { method: "POST", headers, body });
  assert.equal(answer.status, 201);
  return (await answer.json()).id;
}

/**
 * Largest difference of codes between a frame on the screen and the server's picture of it over
 * the page, above the object and between the buttons in the upper corners.
 */
async function apartAbove(app, { lineage, individuals }, slot, base, light_deg) {
  const { scene } = await app.api(`/v1/lineages/${lineage}`);
  const box = await app.cell(slot).locator(".pictures").boundingBox();
  const side = Math.floor(Math.min(box.width, box.height));
  const query = `size=${side}&scene=${scene}&light_deg=${light_deg}`;
  const url = `${base}/v1/individuals/${individuals[slot].id}/render.png?${query}`;
  const wanted = Buffer.from(await (await fetch(url)).arrayBuffer());
  const shown = await app.page.screenshot({ clip: { x: box.x, y: box.y, width: side, height: side } });
  const below = await app.page.evaluate(() =>
    getComputedStyle(document.querySelector(".stage")).backgroundColor.match(/\d+/g).map(Number));
  return onPixels(
    app.page,
    [shown, wanted],
    ([left, right], under) => {
      let most = 0;
      const { width, height } = right;
      for (let y = 2; y < height >> 4; y++)
        for (let x = Math.ceil(width / 4); x < (3 * width) / 4; x++) {
          const at = 4 * (y * width + x);
          const opacity = right.data[at + 3] / 255;
          for (const channel of [0, 1, 2]) {
            const over = right.data[at + channel] * opacity + under[channel] * (1 - opacity);
            most = Math.max(most, Math.abs(left.data[at + channel] - over));
          }
        }
      return most;
    },
    below,
  );
}

/** Pictures behind the object drawn live, and normal maps, which are not; after `surrounded`. */
export async function sceneImagesLive(app, step, shot, base) {
  const { page } = app;
  const { lineage: before } = await app.generation(await app.ready());
  const opened = (name, start, scene, seed) => openLineage(app, base, { name, start, scene }, seed);
  const film = { exposure: -1, tone: "filmic" };
  const backdrop = async (base64) => ({ kind: "image", image: await uploaded(base, base64) });

  await step("draws a picture behind objects live like the server, without exposure", async () => {
    const scene = { mesh: "knob", lights: [{}], film, backdrop: await backdrop(await painting(page)) };
    const generation = await opened("Before a picture", "believable", scene, 7);
    const text = await comparedAround(app, shot, base, generation, "46-before-picture", APART);
    await turnByHand(app, async () => {
      await allLit(page);
      // The picture stays while the object turns.
      assert.ok((await apartAbove(app, generation, 9, base, 250)) <= CODES);
      await shot("46-before-picture-turning");
    });
    await noneLit(page);
    return text;
  });

  await step("draws what is clear in it, behind painted materials and other objects", async () => {
    const objects = [{ mesh: "cube", position: [0.7, 0.3, 0.9], scale: 0.4, material: "gold" }];
    const scene = { mesh: "knob", lights: [{}], objects, backdrop: await backdrop(await glass(page)) };
    const generation = await opened("Before glass", "painted", scene, 4);
    await hold(app, "light", 75);
    await allLit(page);
    const text = await asServerDraws(app, generation, 75, base);
    const apart = [];
    for (const slot of [2, 9, 16]) apart.push(await apartAbove(app, generation, slot, base, 75));
    await shot("46-before-glass");
    assert.ok(Math.max(...apart) <= CODES, `apart by ${apart} codes above the object`);
    await app.reshown(() => slide(app, "light", 75));
    await noneLit(page);
    return `${text}; above it by ${apart.map((codes) => codes.toFixed(1))} codes`;
  });

  await step("loads the picture again after the context was lost", async () => {
    await hold(app, "light", 130);
    await allLit(page);
    await loseContext(page);
    await hold(app, "light", 200);
    await allLit(page);
    const generation = await app.generation(await app.ready());
    assert.ok((await apartAbove(app, generation, 9, base, 200)) <= CODES);
    await app.reshown(() => slide(app, "light", 200));
    await noneLit(page);
  });

  await step("keeps the server's pictures where there is a normal map", async () => {
    const map = png("bumps.png", await bumps(page));
    assert.equal(await app.id("stills").count(), 0);
    await app.reshown(() => app.id("normal-map").setInputFiles(map));
    await app.id("stills").filter({ hasText: "no normal maps" }).waitFor();
    await hold(app, "light", 75);
    await page.locator("img.still").first().waitFor();
    await app.reshown(() => slide(app, "light", 75));
    assert.equal(await page.locator(".pictures.lit").count(), 0);
    await app.reshown(() => app.id("normal-map-remove").click());
    await app.id("stills").waitFor({ state: "detached" });
    await hold(app, "light", 20);
    await allLit(page);
    await app.reshown(() => slide(app, "light", 20));
    await noneLit(page);
  });

  await goTo(app, before);
  app.quiet();
}
