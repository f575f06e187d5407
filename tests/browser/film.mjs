// Colour and strength of the light, and marks of clipped pixels: in the server's pictures and drawn
// live.

import { strict as assert } from "node:assert";

import { openLineage } from "./drawn_live.mjs";
import { allLit, hold, noneLit, slide } from "./live.mjs";
import { around } from "./materials.mjs";
import { onPixels } from "./pixels.mjs";

/** sRGB 128 in linear light. */
const HALF = 0.2158605;
/** sRGB code of the background, with which edge pixels are mixed. */
const SURROUND = 30;
/** Colour of the stripes on the screen. */
const MAGENTA = [255, 0, 179];

/**
 * Statistics of a frame's pixels: number of clearly lit ones, their largest blue, and number in the
 * stripes' colour.
 */
async function seen(app, cell) {
  const picture = await cell.locator(".pictures").screenshot();
  return onPixels(
    app.page,
    [picture],
    ([{ data }], stripe) => {
      let [lit, blue, striped] = [0, 0, 0];
      for (let at = 0; at < data.length; at += 4) {
        if (stripe.every((code, k) => Math.abs(data[at + k] - code) <= 2)) striped += 1;
        if (data[at] < 90) continue;
        lit += 1;
        blue = Math.max(blue, data[at + 2]);
      }
      return { lit, blue, striped };
    },
    MAGENTA,
  );
}

/** Largest blue among the clearly lit pixels of some frames; infinite if nothing is lit. */
async function blueness(app) {
  const found = [];
  for (const slot of [1, 6, 13, 17]) found.push(await seen(app, app.cell(slot)));
  const isLit = found.some(({ lit }) => lit > 50);
  return isLit ? Math.max(...found.map(({ blue }) => blue)) : Infinity;
}

/** Waits until no blue is left in the lit pixels. */
const losesBlue = (app) =>
  app.comesTo(
    () => blueness(app),
    (blue) => blue <= SURROUND,
    (blue) => `${blue} is the largest blue`,
  );

/** The scene of the lineage that is shown. */
async function shownScene(app) {
  const { lineage } = await app.generation(await app.ready());
  return app.api(`/v1/scenes/${(await app.api(`/v1/lineages/${lineage}`)).scene}`);
}

/** Number of pixels of the centre in the stripes' colour. */
const striped = async (app) => (await seen(app, app.id("centre"))).striped;

/** Number of clearly lit pixels of the centre. */
const lit = async (app) => (await seen(app, app.id("centre"))).lit;

const close = (found, wanted) =>
  assert.ok(Math.abs(found / wanted - 1) < 1e-6, `${found} is not ${wanted}`);

/** Runs the journey, with gold in the centre; `shot` saves a screenshot. */
export async function film(app, step, shot, base) {
  const { page } = app;
  await openLineage(app, base, { name: "Film", start: "believable", scene: { mesh: "knob" } }, 7);
  const before = await app.ready();
  await app.id("presets").click();
  await app.id("preset-gold").click();
  await around(page, before);
  const settled = () =>
    page.waitForFunction(
      () => document.querySelector("[data-testid=light-color]")?.disabled === false,
    );

  const intensity = await step(
    "colours the light, live while dragging and then in the scene",
    async () => {
      await settled();
      assert.equal(await app.id("light-color").inputValue(), "#ffffff");
      await hold(app, "light-color", "#ff8000");
      await allLit(page);
      await losesBlue(app);
      await shot("15-light-held");
      const scene = await app.reshown(() => slide(app, "light-color", "#ff8000"));
      await noneLit(page);
      await losesBlue(app);
      const [r, g, b] = scene.lights[0].intensity;
      close(g / r, HALF);
      assert.equal(b, 0);
      return r;
    },
  );

  await step("changes the light's intensity in stops, also by key, and reads it back", async () => {
    const stronger = await app.reshown(() => slide(app, "light-ev", 1));
    close(stronger.lights[0].intensity[0], 2 * intensity);
    await app.id("light-ev").focus();
    const sent = [];
    const count = (request) =>
      request.method() === "POST" && request.url().endsWith("/v1/scenes") && sent.push(request);
    page.on("request", count);
    const by_key = await app.reshown(async () => {
      await page.keyboard.down("ArrowRight");
      await page.keyboard.down("ArrowRight");
      await page.keyboard.up("ArrowRight");
    });
    page.off("request", count);
    close(by_key.lights[0].intensity[0], 2 ** 1.5 * intensity);
    assert.equal(sent.length, 1, "a key that is held is one change");
    await page.reload();
    await app.ready();
    await settled();
    assert.equal(await app.id("light-color").inputValue(), "#ff8000");
    assert.equal(await app.id("light-ev").inputValue(), "1.5");
  });

  await step("keeps the light as strong on an object of another size", async () => {
    const { mesh, lights } = await app.reshown(() => app.id("object").selectOption("sphere"));
    assert.equal(mesh, "sphere");
    assert.ok(lights[0].intensity[0] < 2 ** 1.5 * intensity, "a smaller object is lit from nearer");
    await page.waitForFunction(
      () => document.querySelector("output[for=light-ev]").textContent === "+1.5 EV",
    );
  });

  await step("marks clipped pixels, in the server's pictures and drawn live", async () => {
    await app.reshown(() => slide(app, "exposure", 3));
    assert.equal(await striped(app), 0);
    await page.getByRole("switch", { name: "Show clipping" }).check();
    await page.waitForFunction(
      () => document.querySelectorAll("[data-testid=marks]").length === 21,
    );
    // The marks appear after their picture has been read.
    await page.waitForFunction(
      () => document.querySelector("[data-cell=centre] [data-testid=marks]").width > 300,
    );
    // At first the marks are those of a smaller picture, or none.
    let before = 0;
    const marked = await app.comesTo(
      () => striped(app),
      (count) => {
        const still = count > 100 && count === before;
        before = count;
        return still;
      },
      (count) => `${count} pixels are marked`,
    );
    await shot("16-clipped");
    await app.accessible("clipped");
    const { light_deg } = await shownScene(app);
    await hold(app, "light", light_deg + 1);
    await allLit(page);
    await app.comesTo(
      () => striped(app),
      (drawn) => Math.abs(drawn / marked - 1) < 0.2,
      (drawn) => `${marked} pixels in the picture and ${drawn} drawn live`,
    );
    await shot("17-clipped-live");
    await page.getByRole("switch", { name: "Show clipping" }).uncheck();
    await page.waitForFunction(() => document.querySelectorAll("[data-testid=marks]").length === 0);
    assert.equal(await striped(app), 0);
    await app.reshown(() => slide(app, "light", light_deg + 2));
    await noneLit(page);
  });

  await step("resets the light to white", async () => {
    await app.reshown(() => slide(app, "light-ev", 0));
    const scene = await app.reshown(() => app.id("light-white").click());
    assert.equal(scene.lights[0].intensity, null);
  });

  await step(
    "uses other kinds of light, shadows and a tone curve, some in the server's pictures",
    async () => {
      const kind = app.id("light-kind");
      const far = await app.reshown(() => kind.selectOption("directional"));
      assert.equal(far.lights[0].kind, "directional");
      const strong = await app.reshown(() => slide(app, "light-ev", 1));
      close([strong.lights[0].irradiance_w_m2].flat()[0], 2 * Math.PI);
      const shadowed = await app.reshown(() =>
        page.getByRole("switch", { name: "shadows" }).check(),
      );
      assert.equal(shadowed.shadows, true);
      const curved = await app.reshown(() => page.getByRole("radio", { name: "Filmic" }).check());
      assert.equal(curved.film.tone, "filmic");
      assert.equal(await app.id("stills").count(), 0);
      await hold(app, "light", 90);
      await allLit(page);
      await app.reshown(() => slide(app, "light", 0));
      const spot = await app.reshown(() => kind.selectOption("spot"));
      assert.equal(spot.lights[0].kind, "spot");
      await hold(app, "light-cone", 40);
      await allLit(page);
      const whole = await lit(app);
      await hold(app, "light-cone", 4);
      await app.comesTo(
        () => lit(app),
        (narrow) => narrow < 0.5 * whole,
        (narrow) => `${narrow} pixels are lit in a narrow cone, ${whole} in a wide one`,
      );
      const wide = await app.reshown(() => slide(app, "light-cone", 40));
      const soft = await app.reshown(() => slide(app, "light-softness", 0.5));
      assert.equal(wide.lights[0].falloff_deg, 40);
      assert.deepEqual([soft.lights[0].falloff_deg, soft.lights[0].hotspot_deg], [40, 20]);
      assert.equal(await app.id("stills").count(), 0);
      await shot("18-spot");
      const lamp = "TILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 60\n0 45 90\n0\n100 60 0\n";
      const file = (name, text) => ({
        name,
        mimeType: "application/octet-stream",
        buffer: Buffer.from(text),
      });
      const profiled = await app.reshown(() =>
        app.id("light-ies").setInputFiles(file("lamp.ies", lamp)),
      );
      assert.equal(profiled.lights[0].kind, "ies");
      assert.match(await app.id("stills").textContent(), /server renders/);
      await hold(app, "light", 90);
      await page.locator("img.still").first().waitFor();
      await noneLit(page);
      const turned = await app.reshown(() => slide(app, "light", 90));
      assert.equal(turned.light_deg, 90);
      await app.reshown(() => slide(app, "light", 0));
      await app.id("light-environment").setInputFiles(file("sky.hdr", "no picture"));
      const said = page
        .locator("section", { has: page.locator("#light-title") })
        .getByRole("alert");
      await said.waitFor();
      app.complaints = app.complaints.filter((text) => !text.includes("422"));
      await shot("18-lamp");
      await app.accessible("kinds of light");
      await app.reshown(() => page.getByRole("radio", { name: "Linear" }).check());
      await app.reshown(() => page.getByRole("switch", { name: "shadows" }).uncheck());
      const plain = await app.reshown(() => kind.selectOption("point"));
      assert.ok(!plain.shadows && plain.lights[0].kind === "point");
    },
  );
}
