// The light's colour and strength, and the marks of what the film cannot hold: in the server's pictures and drawn live.

import { strict as assert } from "node:assert";

import { allLit, noneLit, slide } from "./live.mjs";

/** sRGB 128 in linear light. */
const HALF = 0.2158605;
/** The code of what is behind the frames; a rim is mixed with it. */
const SURROUND = 30;
/** Of the stripes, as the screen has them. */
const MAGENTA = [255, 0, 179];

/** Puts a slider somewhere and holds it there. */
const hold = (hand, name, value) =>
  hand.id(name).evaluate((control, to) => {
    control.value = String(to);
    control.dispatchEvent(new Event("input", { bubbles: true }));
  }, value);

/** What is seen of a frame: how many pixels are clearly lit, the largest blue of those, and how many are of the stripes' colour. */
async function seen(hand, cell) {
  const picture = await cell.locator(".pictures").screenshot();
  return hand.page.evaluate(async ([base64, stripe]) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let [lit, blue, striped] = [0, 0, 0];
    for (let at = 0; at < data.length; at += 4) {
      if (stripe.every((code, k) => Math.abs(data[at + k] - code) <= 2)) striped += 1;
      if (data[at] < 90) continue;
      lit += 1;
      blue = Math.max(blue, data[at + 2]);
    }
    return { lit, blue, striped };
  }, [picture.toString("base64"), MAGENTA]);
}

/** The largest blue of what is clearly lit in some frames. */
async function blueness(hand) {
  const found = [];
  for (const slot of [1, 6, 13, 17]) found.push(await seen(hand, hand.cell(slot)));
  assert.ok(found.some(({ lit }) => lit > 50), "something is lit");
  return Math.max(...found.map(({ blue }) => blue));
}

/** How many pixels of the centre have the stripes' colour. */
const striped = async (hand) => (await seen(hand, hand.id("centre"))).striped;

const close = (found, wanted) => assert.ok(Math.abs(found / wanted - 1) < 1e-6, `${found} is not ${wanted}`);

/** The journey; `shot` takes a picture of the page. */
export async function film(hand, step, shot) {
  const { page } = hand;
  const settled = () => page.waitForFunction(() => document.querySelector("[data-testid=light-color]")?.disabled === false);

  const intensity = await step("colours the light, live under the hand and then for good", async () => {
    await settled();
    assert.equal(await hand.id("light-color").inputValue(), "#ffffff");
    await hold(hand, "light-color", "#ff8000");
    await allLit(page);
    assert.ok((await blueness(hand)) <= SURROUND, "no blue is left");
    await shot("15-light-held");
    const scene = await hand.reshown(() => slide(hand, "light-color", "#ff8000"));
    await noneLit(page);
    assert.ok((await blueness(hand)) <= SURROUND, "nor in the server's pictures");
    const [r, g, b] = scene.lights[0].intensity;
    close(g / r, HALF);
    assert.equal(b, 0);
    return r;
  });

  await step("makes the light stronger by stops, by key too, and reads it back", async () => {
    const stronger = await hand.reshown(() => slide(hand, "light-ev", 1));
    close(stronger.lights[0].intensity[0], 2 * intensity);
    await hand.id("light-ev").focus();
    const sent = [];
    const count = (request) => request.method() === "POST" && request.url().endsWith("/v1/scenes") && sent.push(request);
    page.on("request", count);
    const by_key = await hand.reshown(async () => {
      await page.keyboard.down("ArrowRight");
      await page.keyboard.down("ArrowRight");
      await page.keyboard.up("ArrowRight");
    });
    page.off("request", count);
    close(by_key.lights[0].intensity[0], 2 ** 1.5 * intensity);
    assert.equal(sent.length, 1, "a key that is held is one change");
    await page.reload();
    await hand.ready();
    await settled();
    assert.equal(await hand.id("light-color").inputValue(), "#ff8000");
    assert.equal(await hand.id("light-ev").inputValue(), "1.5");
  });

  await step("keeps the light as strong on an object of another size", async () => {
    const { mesh, lights } = await hand.reshown(() => hand.id("object").selectOption("sphere"));
    assert.equal(mesh, "sphere");
    assert.ok(lights[0].intensity[0] < 2 ** 1.5 * intensity, "a smaller object is lit from nearer");
    await page.waitForFunction(() => document.querySelector("output[for=light-ev]").textContent === "+1.5 EV");
  });

  await step("marks what is burnt out, in the pictures and drawn live", async () => {
    await hand.reshown(() => slide(hand, "exposure", 3));
    assert.equal(await striped(hand), 0);
    await page.getByRole("switch", { name: "clipped" }).check();
    await page.waitForFunction(() => document.querySelectorAll("[data-testid=marks]").length === 21);
    // The marks come when their picture has been read.
    await page.waitForFunction(() => document.querySelector("[data-cell=centre] [data-testid=marks]").width > 300);
    let marked = 0;
    // At first they may be those of the picture before the exposure was changed.
    for (let tries = 0; tries < 100 && marked <= 100; tries += 1) {
      marked = await striped(hand);
      await page.waitForTimeout(100);
    }
    assert.ok(marked > 100, `${marked} pixels are marked`);
    await shot("16-clipped");
    await hand.accessible("clipped");
    await slide(hand, "light", 1);
    await allLit(page);
    const drawn = await striped(hand);
    assert.ok(Math.abs(drawn / marked - 1) < 0.2, `${marked} pixels in the picture and ${drawn} drawn live`);
    await shot("17-clipped-live");
    await page.getByRole("switch", { name: "clipped" }).uncheck();
    await page.waitForFunction(() => document.querySelectorAll("[data-testid=marks]").length === 0);
    assert.equal(await striped(hand), 0);
    await slide(hand, "light", 0);
    await noneLit(page);
  });

  await step("gives white light back", async () => {
    await hand.reshown(() => slide(hand, "light-ev", 0));
    const scene = await hand.reshown(() => hand.id("light-white").click());
    assert.equal(scene.lights[0].intensity, null);
  });

  await step("lights by other kinds, with shadows and a tone curve, in pictures of the server", async () => {
    const kind = hand.id("light-kind");
    const far = await hand.reshown(() => kind.selectOption("directional"));
    assert.equal(far.lights[0].kind, "directional");
    const strong = await hand.reshown(() => slide(hand, "light-ev", 1));
    close([strong.lights[0].irradiance_w_m2].flat()[0], 2 * Math.PI);
    const shadowed = await hand.reshown(() => page.getByRole("switch", { name: "shadows" }).check());
    assert.equal(shadowed.shadows, true);
    const curved = await hand.reshown(() => page.getByRole("radio", { name: "filmic" }).check());
    assert.equal(curved.film.tone, "filmic");
    assert.match(await hand.id("stills").textContent(), /pictures of the server/);
    await slide(hand, "light", 90);
    await noneLit(page);
    await slide(hand, "light", 0);
    const lamp = "TILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 60\n0 45 90\n0\n100 60 0\n";
    const file = (name, text) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(text) });
    const profiled = await hand.reshown(() => hand.id("light-ies").setInputFiles(file("lamp.ies", lamp)));
    assert.equal(profiled.lights[0].kind, "ies");
    await hand.id("light-environment").setInputFiles(file("sky.hdr", "no picture"));
    const said = page.locator("section", { has: page.locator("#light-title") }).getByRole("alert");
    await said.waitFor();
    hand.complaints = hand.complaints.filter((text) => !text.includes("422"));
    await shot("18-lamp");
    await hand.accessible("kinds of light");
    await hand.reshown(() => page.getByRole("radio", { name: "no curve" }).check());
    await hand.reshown(() => page.getByRole("switch", { name: "shadows" }).uncheck());
    const plain = await hand.reshown(() => kind.selectOption("point"));
    assert.ok(!plain.shadows && plain.lights[0].kind === "point");
  });
}
