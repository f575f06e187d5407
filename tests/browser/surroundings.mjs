// The ground and another object: put there, moved, given materials, and taken away.

import { strict as assert } from "node:assert";

/** Share of opaque pixels of the picture in the centre, as the browser shows it. */
const covered = (app) =>
  app.page.evaluate(async () => {
    const image = document.querySelector("[data-testid=centre] img");
    await image.decode();
    const pen = new OffscreenCanvas(64, 64).getContext("2d");
    pen.drawImage(image, 0, 0, 64, 64);
    const { data } = pen.getImageData(0, 0, 64, 64);
    let opaque = 0;
    for (let at = 3; at < data.length; at += 4) opaque += data[at] > 250 ? 1 : 0;
    return opaque / 4096;
  });

/** Runs the part of the journey; `shot` saves a screenshot. */
export async function surroundings(app, step, shot) {
  const { page } = app;
  const ground = page.locator("label", { has: app.id("ground") });

  await step("puts the object on the ground", async () => {
    assert.ok((await covered(app)) < 0.9);
    const scene = await app.reshown(() => ground.click());
    assert.deepEqual(scene.ground, {});
    assert.ok((await covered(app)) > 0.9, "the ground fills the picture");
  });

  await step("puts a golden ball beside it, and moves it", async () => {
    const { objects: [ball] } = await app.reshown(() => app.id("neighbour").selectOption("sphere"));
    assert.equal(ball.stands, true);
    const material = app.id("neighbour-material");
    await material.focus();
    await material.locator("option[value=gold]").waitFor({ state: "attached" });
    const gilt = await app.reshown(() => material.selectOption("gold"));
    assert.equal(gilt.objects[0].material, "gold");
    const { objects: [moved] } = await app.reshown(() => app.id("neighbour-around").fill("20"));
    assert.ok(moved.position[2] > 1.5 * ball.position[2], "it is further in front");
    await shot("40-surroundings");
    await app.accessible("surroundings");
  });

  await step("breeds among them", async () => {
    const bred = await app.generation(await app.becomes(() => app.cell(4).click()));
    assert.equal(bred.individuals.length, 20);
    const scene = await app.reshown(() => app.id("neighbour-material").selectOption("centre"));
    assert.equal(scene.objects[0].material, bred.centre.hash);
    await shot("40-surroundings-bred");
  });

  await step("lights them as in a studio, with shadows", async () => {
    const scene = await app.reshown(() => app.id("stage-light").click());
    assert.deepEqual(scene.lights.map(({ kind, shadows }) => [kind, shadows ?? true]), [
      ["environment", false], ["sphere", true],
    ]);
    assert.equal(scene.shadows, true);
    await shot("40-surroundings-studio");
  });

  await step("takes the studio, ball and ground away", async () => {
    await app.reshown(() => app.id("environment").selectOption("none"));
    await app.reshown(() => app.id("light-kind").selectOption("point"));
    const left = await app.reshown(() => app.id("neighbour").selectOption("none"));
    assert.equal((left.objects ?? []).length, 0);
    const bare = await app.reshown(() => ground.click());
    assert.equal(bare.ground ?? null, null);
  });
}
