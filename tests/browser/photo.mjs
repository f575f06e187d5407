// Photographs without a scene file: the ball, its crop and its light are placed on the picture. The
// pictures are renders of known scenes; only their pixels reach the page.

import { strict as assert } from "node:assert";

import { poster } from "./server.mjs";

/** Size of the picture. */
const [WIDTH, HEIGHT] = [720, 480];
/** Scene of the picture: a ball beside the middle, under one light. */
const TRUTH = {
  mesh: "sphere",
  camera: { eye: [0.9, -0.35, 5.2], target: [0.9, -0.35, 0], fov_y_deg: 40 },
  lights: [{ kind: "directional", direction: [-0.55, -0.6, -0.62] }],
};

/** Renders a glossy material in a scene. */
async function photograph(base, scene, name) {
  const post = poster(base);
  const { id } = await post("/v1/scenes", scene);
  const lineage = await post("/v1/lineages", { name: "Photographed", scene: id });
  const made = await post(`/v1/lineages/${lineage.id}/adoptions`, { presets: ["model-plastic"] });
  const individual = made.individuals[0].id;
  const format = name.split(".").at(-1);
  const answer = await fetch(
    `${base}/v1/individuals/${individual}/render.${format}?size=${WIDTH}x${HEIGHT}`,
  );
  assert.equal(answer.status, 200, `${answer.url}: ${answer.status}`);
  return { name, mimeType: `image/${format}`, buffer: Buffer.from(await answer.arrayBuffer()) };
}

/** The beginning of a JPEG file that is to be turned by 90 degrees, from a lens of 85 mm. */
const CAMERA = Buffer.concat([
  Buffer.from("ffe10040457869660000", "hex"),
  Buffer.from("4d4d002a00000008", "hex"),
  // Orientation 6, and the place of the fields of Exif: the focal length.
  Buffer.from("0002011200030000000100060000876900040000000100000026" + "00000000", "hex"),
  Buffer.from("0001a405000300000001005500000000" + "0000", "hex"),
]);

/** The picture as a JPEG file of a camera that was held upright. */
export async function asPhone(page, { buffer }) {
  const turned = await page.evaluate(async (bytes) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(bytes)]));
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [bitmap.height, bitmap.width];
    const context = canvas.getContext("2d");
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.translate(0, bitmap.width);
    context.rotate(-Math.PI / 2);
    context.drawImage(bitmap, 0, 0);
    const blob = await new Promise((done) => canvas.toBlob(done, "image/jpeg", 0.95));
    return [...new Uint8Array(await blob.arrayBuffer())];
  }, [...buffer]);
  const file = Buffer.concat([Buffer.from(turned.slice(0, 2)), CAMERA, Buffer.from(turned.slice(2))]);
  return { name: "phone.jpg", mimeType: "image/jpeg", buffer: file };
}

/** Opens the form of a new search with a picture. */
async function openWith(app, picture) {
  await app.open();
  await app.page.keyboard.press("s");
  await app.id("searches-dialog").waitFor();
  await app.id("searches-dialog").getByRole("button", { name: "New search" }).first().click();
  await app.id("target-file").setInputFiles(picture);
  // An EXR alone may be a slice.
  if (picture.name.endsWith(".exr")) await app.id("target-kind").selectOption("image");
  await app.id("view-0-photo").waitFor();
}

/** Number in a field. */
const number = async (app, name) => Number(await app.id(`view-0-${name}`).inputValue());

/** Outline that a sphere of this radius has in the picture: middle and radius. */
function circleOfTruth(radius = 1) {
  const { eye, fov_y_deg } = TRUTH.camera;
  const [x, y, z] = eye.map((part) => -part);
  const distance2 = x * x + y * y + z * z;
  const sine2 = radius ** 2 / distance2;
  const k = (z * z) / distance2 - sine2;
  const scale = HEIGHT / 2 / Math.tan((fov_y_deg * Math.PI) / 360);
  const off = -z / distance2 / k;
  return {
    x: WIDTH / 2 + x * off * scale,
    y: HEIGHT / 2 - y * off * scale,
    radius: Math.sqrt((sine2 * Math.sqrt(1 - sine2)) / k ** 1.5) * scale,
  };
}

/** Angle between two directions of light relative to the eye, degrees. */
function angle(a, b) {
  const length = (v) => Math.hypot(...v);
  const cosine = a.reduce((sum, part, at) => sum + part * b[at], 0) / length(a) / length(b);
  return (Math.acos(Math.min(1, cosine)) * 180) / Math.PI;
}

/** Drags from a point of the picture to another, in its pixels. */
async function drag(app, from, to) {
  const paper = app.id("view-0-paper");
  await paper.scrollIntoViewIfNeeded();
  const points = await paper.evaluate(
    (svg, ends) =>
      ends.map(({ x, y }) => {
        const at = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
        return { x: at.x, y: at.y };
      }),
    [from, to],
  );
  await app.page.mouse.move(points[0].x, points[0].y);
  await app.page.mouse.down();
  await app.page.mouse.move((points[0].x + points[1].x) / 2, (points[0].y + points[1].y) / 2);
  await app.page.mouse.move(points[1].x, points[1].y);
  await app.page.mouse.up();
}

/** Reads the picture, and returns its view as the server understood it. */
async function understood(app) {
  const answered = app.page.waitForResponse(
    (it) => it.request().method() === "POST" && it.url().endsWith("/v1/targets"),
  );
  await app.id("views-read").click();
  const answer = await answered;
  assert.equal(answer.status(), 201, await answer.text());
  await app.id("target-understood").waitFor();
  await app.drawn("target-understood", 4);
  return answer.json();
}

/** Runs the journey; `shot` saves a screenshot. */
export async function photo(app, step, shot, base) {
  const { page } = app;
  app.ignores = (text) => text.includes("422");
  const truth = circleOfTruth();
  const light = TRUTH.lights[0].direction;

  await step("finds a ball and its light in a photograph", async () => {
    await openWith(app, await photograph(base, TRUTH, "ball.png"));
    assert.ok(await app.id("view-0-from").getByRole("radio", { name: "from the picture" }).isChecked());
    const found = {
      x: await number(app, "circle-x"),
      y: await number(app, "circle-y"),
      radius: await number(app, "circle-radius"),
    };
    const off = Math.hypot(found.x - truth.x, found.y - truth.y);
    console.log(`circle off by ${off.toFixed(2)} px, radius by ${(found.radius - truth.radius).toFixed(2)} px`);
    assert.ok(off < 3 && Math.abs(found.radius - truth.radius) < 3, JSON.stringify({ found, truth }));
    assert.ok(await app.id("view-0-surface").getByRole("radio", { name: "highlight" }).isChecked());
    // The crop is around the ball.
    assert.ok((await number(app, "crop-w")) < WIDTH && (await number(app, "crop-x")) > 0);
    await shot("71-photo");
    await app.accessible("a photograph");
  });

  await step("estimates the scene of a photograph from its pixels", async () => {
    await app.id("view-0-crop-whole").click();
    await app.id("view-0-fov").fill("40");
    await app.id("view-0-fov").blur();
    const target = await understood(app);
    const [view] = target.views;
    assert.deepEqual([view.size_px, view.crop ?? null], [[WIDTH, HEIGHT], null]);
    const degrees = angle(view.scene.lights[0].direction, light);
    const eye = view.scene.camera.eye.map((part, at) => part - TRUTH.camera.eye[at]);
    console.log(`light off by ${degrees.toFixed(2)} degrees, eye by ${Math.hypot(...eye).toFixed(3)} radii`);
    assert.ok(degrees < 4, `light off by ${degrees} degrees`);
    assert.ok(Math.hypot(...eye) < 0.15, `eye off by ${eye}`);
    assert.ok(view.gain_solved && view.pixels.used > 5000, JSON.stringify(view.pixels));
    await app.id("target-understood").scrollIntoViewIfNeeded();
    await shot("72-photo-understood");
  });

  await step("crops by dragging, moves circle and spot, and says what is wrong", async () => {
    await app.id("view-0-paper").scrollIntoViewIfNeeded();
    await drag(app, { x: WIDTH - 1, y: HEIGHT - 1 }, { x: 520, y: 440 });
    const [width, height] = [await number(app, "crop-w"), await number(app, "crop-h")];
    assert.ok(Math.abs(width - 520) < 4 && Math.abs(height - 440) < 4, `${width} x ${height}`);
    const before = [await number(app, "circle-x"), await number(app, "spot-x")];
    await drag(app, { x: truth.x - 40, y: truth.y + 40 }, { x: truth.x - 10, y: truth.y + 40 });
    const moved = await number(app, "circle-x");
    assert.ok(Math.abs(moved - before[0] - 30) < 3, `${moved} after ${before[0]}`);
    await app.id("view-0-circle-find").click();
    assert.ok(Math.abs((await number(app, "circle-x")) - truth.x) < 3);
    const radius = truth.radius * Math.SQRT1_2;
    await drag(app, { x: truth.x + radius, y: truth.y - radius }, { x: truth.x + 70, y: truth.y - 70 });
    assert.ok(Math.abs((await number(app, "circle-radius")) - 99) < 4);
    await app.id("view-0-circle-find").click();
    // A spot beside the ball.
    await app.id("view-0-spot-x").fill("700");
    await app.id("views-read").click();
    await page.locator("#view-0-wrong [data-testid=error]").filter({ hasText: "not on the object" }).waitFor();
    await shot("73-photo-refused");
    await app.id("view-0-spot-find").click();
    const target = await understood(app);
    assert.deepEqual(target.views[0].crop, [0, 0, width, height]);
    assert.deepEqual(target.views[0].size_px, [width, height]);
    assert.ok(angle(target.views[0].scene.lights[0].direction, light) < 5);
  });

  await step("searches for the material of a photograph, and corrects its scene", async () => {
    await app.id("view-0-refine").selectOption("nearly");
    const stated = await understood(app);
    assert.equal(stated.views[0].refine.light_deg, 2);
    await app.id("search-strategy").selectOption("analytic");
    await page.getByRole("radio", { name: "evaluations" }).check();
    await app.id("search-budget").fill("300");
    await app.id("search-start").click();
    await app.id("job-state").filter({ hasText: "done" }).waitFor();
    await app.drawn("found-pair", 3);
    const row = app.id("found-views").locator("tbody tr").first();
    const [, rmse, flip] = await row.getByRole("cell").allInnerTexts();
    console.log(`a fit with RMSE ${rmse}, FLIP ${flip}`);
    assert.ok(Number(flip) < 0.2, `FLIP ${flip}`);
    await app.drawn("found-extremes", 2);
    await app.id("found-corrections").getByText("light 1 to the right").waitFor();
    const [view] = (await app.api(`/v1/targets/${stated.id}`)).views;
    // A ball shows only the angle between light and camera.
    const between = ({ lights, camera }) => angle(lights[0].direction, camera.eye);
    const off = [view, view.corrected].map(({ scene }) => Math.abs(between(scene) - between(TRUTH)));
    console.log(`light off by ${off.map((each) => each.toFixed(2)).join(" degrees, then ")} degrees`);
    assert.ok(off[1] < 5, `light off by ${off}`);
    await shot("74-photo-found");
    await app.id("found-extremes").scrollIntoViewIfNeeded();
    await shot("74-photo-open");
  });

  await step("turns a photograph upright as its camera says, and reads the lens", async () => {
    await openWith(app, await asPhone(page, await photograph(base, TRUTH, "ball.png")));
    const size = await app.id("view-0-paper").getAttribute("viewBox");
    assert.equal(size, `0 0 ${WIDTH} ${HEIGHT}`);
    assert.ok(await app.id("view-0-lens").getByRole("radio", { name: "zoom" }).isChecked());
    assert.ok(Math.abs((await number(app, "circle-x")) - truth.x) < 4);
    await app.id("view-0-crop-whole").click();
    const { views } = await understood(app);
    assert.deepEqual(views[0].size_px, [WIDTH, HEIGHT]);
    assert.ok(angle(views[0].scene.lights[0].direction, light) < 8);
  });

  await step("places a mesh on a picture of linear radiance, and turns it", async () => {
    const scene = { ...TRUTH, mesh: "torus", rotation_deg: [50, 20, 0] };
    await openWith(app, await photograph(base, scene, "ring.exr"));
    await app.id("view-0-object").selectOption("torus");
    await app.id("photo-outline").first().waitFor();
    const head = await (await fetch(`${base}/v1/meshes/torus/geometry`)).arrayBuffer();
    const circle = circleOfTruth(new DataView(head).getFloat64(48, true));
    const fields = { "circle-x": circle.x, "circle-y": circle.y, "circle-radius": circle.radius };
    const turns = { "turn-x": 50, "turn-y": 20, fov: 40 };
    for (const [name, value] of Object.entries({ ...fields, ...turns }))
      await app.id(`view-0-${name}`).fill(value.toFixed(1));
    await app.id("view-0-crop-whole").click();
    await shot("75-photo-mesh");
    const [view] = (await understood(app)).views;
    const eye = view.scene.camera.eye.map((part, at) => part - TRUTH.camera.eye[at]);
    assert.ok(Math.hypot(...eye) < 0.02, `eye off by ${eye}`);
    assert.deepEqual(view.scene.rotation_deg, [50, 20, 0]);
    await shot("75-photo-mesh-understood");
    const outline = () => app.id("photo-outline").getAttribute("d");
    const before = await outline();
    await app.id("view-0-drag").getByRole("radio", { name: "turns it" }).check();
    await drag(app, { x: truth.x - 30, y: truth.y }, { x: truth.x + 30, y: truth.y + 20 });
    assert.notEqual(await outline(), before);
    assert.notEqual(await number(app, "turn-y"), 0);
    await app.accessible("a mesh over a photograph");
  });
  app.quiet();
}

/** The same on a small touch screen. */
export async function photoByFinger(app, step, shot, base) {
  await step("places a ball on a photograph on a screen of 360 pixels", async () => {
    await openWith(app, await photograph(base, TRUTH, "a photograph with a long name, as phones write them.png"));
    await app.fits(app.id("searches-dialog"));
    await app.id("view-0-paper").scrollIntoViewIfNeeded();
    await shot("76-narrow-photo");
    await app.accessible("360 x 740, a photograph");
    await app.id("view-0-surface").scrollIntoViewIfNeeded();
    await shot("77-narrow-photo-fields");
    await understood(app);
    await app.fits(app.id("searches-dialog"));
    await app.id("searches-close").tap();
  });
}
