// Painted materials: a lineage of them, bred, crossed, locked, and painted in the colours of a
// picture; what is only of BRDFs is off.

import { strict as assert } from "node:assert";

import { change, seen } from "./edited.mjs";
import { underLamp } from "./live.mjs";

/** Effects of an individual, as the server writes them. */
const effects = async (app, { hash }) => (await app.api(`/v1/genomes/${hash}`)).effects;

/** PNG of three paints, each from dark to bright, drawn by the browser. @returns base64 */
export const painting = (page) =>
  page.evaluate(() => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [300, 180];
    const context = canvas.getContext("2d");
    const paints = [["#542d15", "#f0823c"], ["#1e2c51", "#557de6"], ["#204625", "#5ac869"]];
    paints.forEach(([shade, paint], at) => {
      const ramp = context.createLinearGradient(0, 0, 300, 0);
      ramp.addColorStop(0, shade);
      ramp.addColorStop(1, paint);
      context.fillStyle = ramp;
      context.fillRect(0, 60 * at, 300, 60);
    });
    return canvas.toDataURL("image/png").split(",")[1];
  });

/** Drops a file on an element, as from a folder. */
export const drop = (element, { name, type, base64 }) =>
  element.evaluate(
    (to, file) => {
      const bytes = Uint8Array.from(atob(file.base64), (one) => one.charCodeAt(0));
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([bytes], file.name, { type: file.type }));
      for (const kind of ["dragover", "drop"])
        to.dispatchEvent(new DragEvent(kind, { bubbles: true, cancelable: true, dataTransfer }));
    },
    { name, type, base64 },
  );

/** Channels of a code from the strongest to the weakest, for example `rgb`. @param {string} code */
const order = (code) => {
  const value = (channel) => Number.parseInt(code.slice(1 + 2 * channel, 3 + 2 * channel), 16);
  return [0, 1, 2].sort((one, other) => value(other) - value(one)).map((at) => "rgb"[at]).join("");
};
/** Orders of the three paints. */
const PAINTS = ["rgb", "bgr", "gbr"];

/** Runs the part of the journey; `shot` saves a screenshot. */
export async function painted(app, step, shot) {
  const { page } = app;
  const details = page.getByRole("complementary", { name: "Details" });

  const first = await step("starts a lineage of painted materials", async () => {
    await app.id("lineage-menu").click();
    await app.id("lineage-name").fill("toons");
    await page.getByRole("radio", { name: "painted" }).check();
    const generation = await app.generation(await app.becomes(() => app.id("lineage-new").click()));
    for (const one of generation.individuals)
      assert.equal((await effects(app, one))[0].kind, "light");
    return generation;
  });

  await step("shows palettes, and why functions of BRDFs are off", async () => {
    const light = details.getByTestId("effects").locator("[data-effect=light]");
    const [{ parameters }] = await effects(app, first.individuals[0]);
    const swatches = light.locator("[data-parameter=palette] .swatch");
    await swatches.first().waitFor();
    assert.equal(await swatches.count(), parameters.palette.length);
    assert.equal(await swatches.first().getAttribute("title"), parameters.palette[0]);
    await details.getByTestId("painted-note").waitFor();
    for (const id of ["inspect", "search-from", "steer-warmer", "saturation", "energy-limit"])
      assert.ok(await app.id(id).isDisabled(), `${id} is off`);
    await app.id("exports").locator("summary").click();
    await app.id("export-vrm-mtoon").waitFor();
    const [code] = await Promise.all([
      page.waitForResponse((it) => it.url().includes("/exports/glsl-es-300?lights=")),
      page.waitForEvent("download"),
      app.id("export-glsl-es-300").click(),
    ]);
    assert.match(await code.text(), /vec3 styled\(StyledPoint at/);
    assert.equal(await app.id("export-limited").count(), 0);
    await app.id("exports").locator("summary").click();
    await shot("39-painted");
    await app.accessible("painted");
  });

  await step("breeds painted materials that keep a locked palette", async () => {
    await page.getByRole("button", { name: "Lock palette of light", exact: true }).click();
    await app.id("lock-sign").filter({ hasText: "1 parameter of an effect locked" }).waitFor();
    const bred = await app.generation(await app.becomes(() => app.id("centre").click()));
    const [{ parameters }] = await effects(app, bred.centre);
    for (const one of bred.individuals) {
      const [light] = await effects(app, one);
      assert.deepEqual(light.parameters.palette, parameters.palette);
    }
    await app.id("locks-unlock").click();
    await app.cell(2).click({ button: "right" });
    const mixed = await app.generation(await app.becomes(() => app.cell(7).click()));
    assert.equal(mixed.individuals[0].operator, "recombine");
    assert.ok((await effects(app, mixed.individuals[0])).length > 0);
  });

  const knobs = page.getByRole("complementary", { name: "Knobs" });
  const own = knobs.getByRole("group", { name: "Colours of a painting" });
  const regions = own.getByRole("listitem");
  const file = { name: "art.png", type: "image/png", base64: await painting(page) };
  /** Asserts that all children have colours of the painting, and returns their palettes. */
  const isPainted = async (brood) => {
    const palettes = [];
    for (const one of brood.individuals) {
      const [{ parameters }] = await effects(app, one);
      for (const code of parameters.palette)
        assert.ok(PAINTS.includes(order(code)), `${code} is of the painting`);
      palettes.push(parameters.palette);
    }
    return palettes;
  };

  await step("breeds in the colours of a painting that is dropped on the knobs", async () => {
    await drop(own, file);
    await regions.nth(2).waitFor();
    assert.equal(await regions.count(), 3);
    assert.deepEqual(await regions.first().getByRole("img").count(), 3);
    assert.match(await regions.first().innerText(), /^3[3-5] % of the picture$/);
    await shot("40-painting");
    await app.accessible("colours of a painting");
    await app.fits(own);
    const brood = await app.generation(await app.becomes(() => app.cell(4).click()));
    assert.equal(brood.painting.regions.length, 3);
    const palettes = (await isPainted(brood)).map(String);
    assert.ok(new Set(palettes).size > 5, "palettes differ");
    await details.getByText("colours of 3 regions").waitFor();
    await shot("41-painted-brood");
  });

  await step("keeps the colours of a painting after a reload, until they are cleared", async () => {
    await page.reload();
    await app.ready();
    await regions.nth(2).waitFor();
    await isPainted(await app.generation(await app.becomes(() => app.cell(1).click())));
    await own.getByRole("button", { name: "Clear the colours" }).click();
    await regions.first().waitFor({ state: "detached" });
    const brood = await app.generation(await app.becomes(() => app.cell(1).click()));
    assert.equal(brood.painting, undefined);
  });

  await step("says why a file has no colours, and takes a painting dropped anywhere", async () => {
    await drop(own, { ...file, base64: btoa("no picture") });
    await own.getByText("the picture must be a PNG or JPEG file").waitFor();
    app.complaints = app.complaints.filter((text) => !text.includes("422"));
    await shot("42-no-painting");
    await drop(app.id("centre"), file);
    await regions.nth(2).waitFor();
    assert.equal(await own.getByText("the picture must be a PNG or JPEG file").count(), 0);
    await own.getByRole("button", { name: "Clear the colours" }).click();
  });

  await step("paints with an image in place of a colour, and removes it", async () => {
    const before = await app.generation(await app.ready());
    const parent = before.centre ?? before.individuals[0];
    const images = details.getByRole("group", { name: "Images" });
    const place = images.getByLabel("Where");
    await place.selectOption({ label: "bright colour of the light" });
    const last = await seen(app);
    const png = { name: file.name, mimeType: file.type, buffer: Buffer.from(file.base64, "base64") };
    const opened = await app.becomes(() => images.getByLabel("Open an image").setInputFiles(png));
    const [child] = (await app.generation(opened)).individuals;
    assert.deepEqual(child.parents, [parent.id]);
    const { bright } = (await effects(app, child))[0].parameters;
    assert.equal(bright.share, 1);
    assert.ok((await change(page, last, await seen(app))) > 0.01, "the image is seen");
    const row = details.getByTestId("effects").locator("[data-effect=light] [data-image=bright]");
    assert.equal(await row.getByRole("img").getAttribute("src"), `/v1/images/${bright.image}`);
    await app.drawn("images", 1);
    await images.scrollIntoViewIfNeeded();
    await shot("42-image");
    await app.accessible("an image");
    await app.fits(images);
    await images.getByLabel("Share").fill("0.5");
    const shared = await app.generation(await app.becomes(() => app.id("image-apply").click()));
    assert.equal((await effects(app, shared.individuals[0]))[0].parameters.bright.share, 0.5);
    await row.getByText("50 %").waitFor();
    const removed = await app.generation(await app.becomes(() => app.id("image-remove").click()));
    await row.waitFor({ state: "detached" });
    assert.equal(removed.individuals[0].hash, parent.hash);
  });

  await step("makes a toon shape of a BRDF", async () => {
    await app.id("lineage-menu").click();
    await app.id("lineage-name").fill("toon shapes");
    await page.getByRole("radio", { name: "models" }).check();
    const models = await app.generation(await app.becomes(() => app.id("lineage-new").click()));
    // Pictures of brushed models take a second each in the studio.
    await underLamp(app);
    const made = await app.generation(await app.becomes(() => app.id("toon-shape").click()));
    const [one] = made.individuals;
    assert.ok(models.individuals.some(({ id }) => id === made.parents[0]));
    const [light] = await effects(app, one);
    assert.equal(light.parameters.by, "brdf");
    await details.getByTestId("painted-note").filter({ hasText: "paints what its BRDF" }).waitFor();
    await app.id("exports").locator("summary").click();
    await app.id("export-by-brdf").waitFor();
    await app.id("exports").locator("summary").click();
    assert.ok(!(await app.id("energy-limit").isDisabled()), "the limit acts on the BRDF");
    const bred = await app.generation(await app.becomes(() => app.id("centre").click()));
    for (const child of bred.individuals)
      assert.equal((await effects(app, child))[0].parameters.by, "brdf");
    await shot("39-toon-shapes");
  });
}
