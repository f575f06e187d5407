// Live drawing: frames compared with the server's pictures, the light, rotation, a lost context;
// and exported programs compared bit for bit.

import { strict as assert } from "node:assert";

import { runExports } from "./exports.mjs";
import { around } from "./materials.mjs";
import { onPixels } from "./pixels.mjs";

/** Programs that are run both ways. */
const PROGRAMS = 40;
/**
 * Limits for the pixels inside a frame's object: this share may differ from the server's picture by
 * more than this many codes of 255, because shadow borders and details below a pixel are
 * antialiased there. Wrong shading is wrong everywhere.
 */
const APART_CODES = 8;
const APART_SHARE = 0.08;

const lit = (page) => page.evaluate(() => document.querySelectorAll(".pictures.lit").length);
export const allLit = (page) =>
  page.waitForFunction(() => document.querySelectorAll(".pictures.lit").length === 21);
/** Asserts that no frame is drawn live and none drawn before is still visible. */
export const noneLit = (page) =>
  page.waitForFunction(
    () =>
      document.querySelectorAll(".pictures.lit").length === 0 &&
      getComputedStyle(document.querySelector("canvas.live")).visibility === "hidden",
  );

/** Moves a slider to a value. */
export function slide(app, name, value) {
  return app.id(name).evaluate((slider, to) => {
    slider.value = String(to);
    for (const kind of ["input", "change"])
      slider.dispatchEvent(new Event(kind, { bubbles: true }));
  }, value);
}

/** Removes the environment of the scene if there is one; returns the changed scene. */
export async function underLamp(app) {
  const environment = app.id("environment");
  if ((await environment.inputValue()) !== "none")
    return app.reshown(() => environment.selectOption("none"));
}

/** Loses the WebGL context, waits for the server's pictures, and restores the context. */
export async function loseContext(page) {
  await page.evaluate(() => {
    const gl = document.querySelector("canvas.live").getContext("webgl2");
    globalThis.lost = gl.getExtension("WEBGL_lose_context");
    globalThis.lost.loseContext();
  });
  await noneLit(page);
  await page.evaluate(() => globalThis.lost.restoreContext());
}

/** Drags a slider to a value without releasing it. */
export const hold = (app, name, value) =>
  app.id(name).evaluate((control, to) => {
    control.value = String(to);
    control.dispatchEvent(new Event("input", { bubbles: true }));
  }, value);

/**
 * Share of the pixels covered in the second PNG file that differ in the first, at the best of
 * several shifts: a frame may begin between two pixels.
 */
function apart(page, shown, wanted) {
  return onPixels(
    page,
    [shown, wanted],
    ([left, right], codes) => {
      if (left.width !== right.width) throw new Error(`${left.width} and ${right.width} pixels`);
      const shifted = (right_px, down_px) => {
        let off = 0;
        let count = 0;
        for (let y = 1; y + 1 < right.height; y++) {
          for (let x = 1; x + 1 < right.width; x++) {
            const at = 4 * (y * right.width + x);
            if (right.data[at + 3] < 255) continue;
            const from = at + 4 * (down_px * right.width + right_px);
            count += 1;
            off += [0, 1, 2].some(
              (channel) => Math.abs(left.data[from + channel] - right.data[at + channel]) > codes,
            )
              ? 1
              : 0;
          }
        }
        return off / count;
      };
      return Math.min(...[-1, 0, 1].flatMap((x) => [-1, 0, 1].map((y) => shifted(x, y))));
    },
    APART_CODES,
  );
}

/**
 * Number of pixels of the first PNG file that differ from its corner, among those with no object
 * within a few pixels in the second.
 */
function strayed(page, shown, wanted) {
  return onPixels(
    page,
    [shown, wanted],
    ([left, right], [near, codes]) => {
      const { width, height } = right;
      const isNear = (x, y) => {
        for (let v = Math.max(0, y - near); v <= Math.min(height - 1, y + near); v++)
          for (let u = Math.max(0, x - near); u <= Math.min(width - 1, x + near); u++)
            if (right.data[4 * (v * width + u) + 3] > 0) return true;
        return false;
      };
      let found = 0;
      // Frames have marks and buttons in their upper corners.
      const corner = 4 * (height - 2) * width + 8;
      for (let y = height >> 2; y + 1 < height; y++)
        for (let x = 1; x + 1 < width; x++) {
          const at = 4 * (y * width + x);
          const apart = [0, 1, 2].some(
            (channel) => Math.abs(left.data[at + channel] - left.data[corner + channel]) > codes,
          );
          if (apart && !isNear(x, y)) found += 1;
        }
      return found;
    },
    [4, 2],
  );
}

/** Picture of a frame on the screen, and the server's of the same size. */
async function bothPictures(app, { lineage, individuals }, slot, base, light = "", other = null) {
  const scene = other ?? (await app.api(`/v1/lineages/${lineage}`)).scene;
  const box = await app.cell(slot).locator(".pictures").boundingBox();
  const side = Math.floor(Math.min(box.width, box.height));
  const url = `${base}/v1/individuals/${individuals[slot].id}/render.png?size=${side}&scene=${scene}${light}`;
  const wanted = Buffer.from(await (await fetch(url)).arrayBuffer());
  const clip = { x: box.x, y: box.y, width: side, height: side };
  return [await app.page.screenshot({ clip }), wanted];
}

/** Records in the page how many frames are drawn live, at every animation frame. */
const recordLit = (page) =>
  page.evaluate(() => {
    globalThis.litCounts = new Set();
    const look = () => {
      globalThis.litCounts?.add(document.querySelectorAll(".pictures.lit").length);
      if (globalThis.litCounts) requestAnimationFrame(look);
    };
    look();
  });

/** Ends the record; returns the numbers in order. */
const recordedLit = (page) =>
  page.evaluate(() => {
    const found = [...globalThis.litCounts].sort((a, b) => a - b);
    globalThis.litCounts = null;
    return found;
  });

/**
 * Asserts that live frames equal the server's pictures with the light at an angle, in the
 * lineage's scene or another; `most` is the largest share of pixels apart in the median of frames,
 * `query` more parameters of the server's pictures.
 */
export async function asServerDraws(app, generation, light_deg, base, scene = null, most = APART_SHARE, query = "") {
  const found = [];
  const light = `&light_deg=${light_deg}${query}`;
  for (const slot of [0, 2, 4, 7, 9, 12, 13, 16, 19]) {
    const both = await bothPictures(app, generation, slot, base, light, scene);
    found.push(await apart(app.page, ...both));
  }
  const text = `apart in ${found.map((share) => (100 * share).toFixed(1))} % of the pixels`;
  assert.ok(found.sort((one, other) => one - other)[found.length >> 1] < most, text);
  return text;
}

/** Runs the journey; `shot` saves a screenshot. */
export async function live(app, step, shot, base) {
  const { page } = app;
  // A software driver reports each read-back as slow.
  app.ignores = (text) => text.includes("GPU stall due to ReadPixels");

  const generation = await step(
    "opens without moving the light on a software renderer",
    async () => {
      const before = await app.open();
      const seen = await app.api(`/v1/lineages/${(await app.generation(before)).lineage}`);
      const { lights } = await app.api(`/v1/scenes/${seen.scene}`);
      assert.deepEqual(
        lights.map(({ kind, image, fixed }) => [kind, image, fixed]),
        [
          ["point", undefined, undefined],
          ["environment", "studio", true],
        ],
        "a new lineage is seen in the studio under a lamp",
      );
      await app.id("presets").click();
      await app.id("preset-pearl").click();
      await around(page, before);
      await app.reshown(() => app.id("object").selectOption("knob"));
      await underLamp(app);
      const id = await app.ready();
      await page.waitForFunction(
        () => document.querySelector("[data-testid=light-moves]")?.disabled === false,
      );
      assert.equal(await app.id("light-moves").getAttribute("aria-pressed"), "false");
      assert.equal(await lit(page), 0);
      return app.generation(id);
    },
  );

  await step("draws the frames like the server at every light angle", async () => {
    await app.reshown(() => slide(app, "exposure", -1));
    await hold(app, "light", 75);
    await allLit(page);
    await asServerDraws(app, generation, 75, base);
    await shot("8-live");
    const scene = await app.reshown(() => slide(app, "light", 75));
    assert.equal(scene.light_deg, 75);
    await noneLit(page);
  });

  await step("shows all pictures after a click under the light of the scene", async () => {
    const scene = await app.reshown(() => slide(app, "light", 40));
    const child = await app.generation(await app.becomes(() => app.cell(3).click()));
    const shown = await page.$$eval("img[data-frame]", (all) => all.map(({ src }) => src));
    assert.equal(shown.length, 21);
    const { thumbnail_px } = await app.api(`/v1/lineages/${child.lineage}`);
    for (const [slot, { id, thumbnail }] of child.individuals.entries()) {
      assert.ok(shown.includes(base + thumbnail), `the picture of frame ${slot} is shown`);
      const [frame, lit] = await Promise.all(
        [
          thumbnail,
          `/v1/individuals/${id}/render.png?size=${thumbnail_px}&scene=${scene.id}&light_deg=40`,
        ].map(async (path) => Buffer.from(await (await fetch(base + path)).arrayBuffer())),
      );
      assert.ok(frame.equals(lit), `frame ${slot} has the light at 40 degrees`);
    }
    await app.id("undo").click();
    await app.shows(generation.id);
  });

  await step("lets the light circle, and stops it", async () => {
    await page.getByRole("button", { name: "Let the light circle" }).click();
    const angle = () => app.id("light").inputValue();
    const before = await angle();
    await page.waitForFunction((was) => document.getElementById("light").value !== was, before);
    assert.ok(await app.id("light-dot").isVisible());
    await page.getByRole("button", { name: "Pause the light" }).click();
    await noneLit(page);
    assert.equal(await app.id("light-moves").getAttribute("aria-pressed"), "false");
    const { scene } = await app.api(`/v1/lineages/${generation.lineage}`);
    const { light_deg } = await app.api(`/v1/scenes/${scene}`);
    assert.equal(await angle(), String(Math.round(light_deg)));
    assert.notEqual(light_deg, 40);
    await app.reshown(() => slide(app, "light", 0));
    await page.waitForFunction(
      () => document.querySelector("output[for=light]").textContent === "0°",
    );
    await noneLit(page);
  });

  await step("rotates the object live while dragging", async () => {
    const box = await app.id("centre").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const { mouse } = page;
    await app.reshown(async () => {
      await mouse.move(x, y);
      await mouse.down();
      await mouse.move(x + 60, y + 20, { steps: 4 });
      await allLit(page);
      await shot("9-turning");
      await mouse.up();
    });
    await noneLit(page);
  });

  await step("draws other conventions like the server", async () => {
    await app.reshown(() => app.id("object").selectOption("sphere"));
    await app.id("conventions").locator("summary").click();
    const choose = (name) => app.reshown(() => page.getByRole("radio", { name }).check());
    const scene = await choose("z axis");
    assert.equal(scene.sphere_pole, "z");
    assert.equal((await choose("per triangle")).tangents, "triangle");
    await shot("9-conventions");
    await hold(app, "light", 75);
    await allLit(page);
    await asServerDraws(app, generation, 75, base);
    await app.reshown(() => slide(app, "light", 5));
    await app.accessible("conventions");
    await choose("per vertex");
    const { sphere_pole } = await app.reshown(() => app.id("object").selectOption("knob"));
    assert.equal(sphere_pole, undefined);
    assert.equal(await page.getByRole("radio", { name: "z axis" }).count(), 0);
  });

  await step("breeds under a moving light", async () => {
    await page.getByRole("button", { name: "Let the light circle" }).click();
    await allLit(page);
    const next = await app.becomes(async () => {
      await recordLit(page);
      await app.cell(7).click();
    });
    await allLit(page);
    assert.deepEqual(await recordedLit(page), [0, 21], "all frames have one light");
    const child = await app.generation(next);
    // Larger than before, then smaller: nothing is left of the larger one.
    for (const wheel of [-250, 500]) {
      const patched = page.waitForResponse((it) => it.request().method() === "PATCH");
      await app.id("centre").hover();
      await page.mouse.wheel(0, wheel);
      await patched;
      await app.ready();
    }
    await allLit(page);
    // Cells of the surface are read back some frames after a drag.
    await page.waitForTimeout(500);
    const [shown, wanted] = await bothPictures(app, child, 6, base);
    await shot("9-smaller");
    assert.equal(await strayed(page, shown, wanted), 0, "pixels beside the object are lit");
    await app.id("details-toggle").click();
    const [png] = await Promise.all([
      page.waitForRequest((it) => it.url().includes("/render.png?size=1024x")),
      page.waitForEvent("download"),
      page
        .getByText("Export", { exact: true })
        .click()
        .then(() => app.id("export-png").click()),
    ]);
    const asked = new URL(png.url()).searchParams;
    const { scene } = await app.api(`/v1/lineages/${child.lineage}`);
    assert.equal(asked.get("scene"), scene);
    assert.ok(Number(asked.get("light_deg")) > 0, `${png.url()} has the light of the screen`);
    await app.id("details-toggle").click();
    await page.getByRole("button", { name: "Pause the light" }).click();
    await noneLit(page);
  });

  await step(
    "shows the server's pictures when the context is lost, and draws again when it is restored",
    async () => {
      await hold(app, "light", 30);
      await allLit(page);
      await loseContext(page);
      await hold(app, "light", 200);
      await allLit(page);
      await app.reshown(() => slide(app, "light", 10));
      await noneLit(page);
    },
  );
  await step("has no accessibility violations with the light's controls", () =>
    app.accessible("live"),
  );
}

/** Runs exported programs in this browser and compares them bit for bit. */
export async function exported(app, step, binary) {
  await step(`runs ${PROGRAMS} exported programs to the bit`, async () => {
    const result = await runExports(app.page, binary, PROGRAMS);
    assert.deepEqual(result.failures, []);
    assert.deepEqual(
      [result.programs, result.exact, result.differing],
      [PROGRAMS, PROGRAMS, 0],
      JSON.stringify(result),
    );
    // The page draws with the shorter text.
    assert.deepEqual(
      [result.within_exact, result.within_differing],
      [PROGRAMS, 0],
      JSON.stringify(result),
    );
    assert.ok(result.styles > 0, JSON.stringify(result));
    assert.deepEqual([result.styles_exact, result.styles_differing], [result.styles, 0], JSON.stringify(result));
    // Inputs are f32 instead of f64: errors of a few units in the last place, more where a
    // program amplifies them.
    assert.ok(result.directions_p99 < 1e-3, JSON.stringify(result));
    assert.deepEqual(
      result.models.filter(({ kept }) => !kept),
      [],
      JSON.stringify(result.models),
    );
  });
}
