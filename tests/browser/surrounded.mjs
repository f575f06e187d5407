// Environments drawn live, compared with the server's pictures: at rest, turning, with a backdrop.

import { strict as assert } from "node:assert";

import { allLit, asServerDraws, hold, noneLit, slide, underLamp } from "./live.mjs";
import { goTo, turnByHand } from "./materials.mjs";
import { poster } from "./server.mjs";

/** Draws environments live, in a lineage of isotropic homogeneous believable programs. */
export async function surrounded(app, step, shot, base) {
  const { page } = app;
  const { lineage: before } = await app.generation(await app.ready());

  let generation = null;
  await step("draws an environment live like the server, under a lamp that circles", async () => {
    const send = poster(base);
    const { id } = await send("/v1/lineages", { name: "Surrounded", start: "believable" });
    const constraints = { isotropic: true, homogeneous: true };
    await send(`/v1/lineages/${id}/generations`, { parents: [], seed: 5, constraints });
    await goTo(app, id);
    generation = await app.generation(await app.ready());
    assert.equal(generation.lineage, id);
    await app.reshown(() => slide(app, "exposure", -1));
    const lamp = await app.reshown(() => slide(app, "light-ev", -1));
    assert.equal(lamp.lights.length, 1);
    await app.reshown(() => app.id("environment").selectOption("studio"));
    await app.reshown(() => slide(app, "environment-rotation", 40));
    const scene = await app.reshown(() => slide(app, "environment-ev", -0.5));
    assert.equal(scene.lights[1].rotation_deg, 40);
    assert.ok(Math.abs(scene.lights[1].scale[1] - 2 ** -0.5) < 1e-9);
    await hold(app, "light", 75);
    await allLit(page);
    const text = await asServerDraws(app, generation, 75, base);
    await shot("9-studio");
    await app.reshown(() => slide(app, "light", 20));
    await noneLit(page);
    return text;
  });

  await step("turns an environment live like the server", async () => {
    const { scene: id } = await app.api(`/v1/lineages/${generation.lineage}`);
    const scene = await app.api(`/v1/scenes/${id}`);
    const text = [];
    for (const to of [131, 308]) {
      await hold(app, "environment-rotation", to);
      await allLit(page);
      const lights = scene.lights.map((light) =>
        light.kind === "environment" ? { ...light, rotation_deg: to } : light,
      );
      const { id: turned } = await poster(base)("/v1/scenes", { ...scene, lights, id: undefined });
      text.push(await asServerDraws(app, generation, scene.light_deg ?? 0, base, turned));
      await shot(`9-studio-turned-${to}`);
    }
    const kept = await app.reshown(() => slide(app, "environment-rotation", 308));
    assert.equal(kept.lights[1].rotation_deg, 308);
    await noneLit(page);
    return text.join("; ");
  });

  await step("shows a backdrop live like the server, under a tone curve", async () => {
    const backdrop = app.id("backdrop");
    await app.reshown(() => backdrop.selectOption("environment"));
    const blurred = await app.reshown(() => slide(app, "backdrop-blur", 20));
    assert.deepEqual(blurred.backdrop, { kind: "environment", blur_deg: 20 });
    await app.reshown(() => page.getByRole("radio", { name: "Filmic" }).check());
    await hold(app, "light", 75);
    await allLit(page);
    const around = await asServerDraws(app, generation, 75, base);
    await shot("9-backdrop");
    await app.reshown(() => slide(app, "light", 30));
    await noneLit(page);
    await app.reshown(() => backdrop.selectOption("color"));
    const green = await app.reshown(() => slide(app, "backdrop-color", "#0a8c3c"));
    assert.equal(Math.round(255 * green.backdrop.color[1]), 0x8c);
    await hold(app, "light", 75);
    await allLit(page);
    const plain = await asServerDraws(app, generation, 75, base);
    await app.accessible("a backdrop");
    await app.reshown(() => slide(app, "light", 20));
    await noneLit(page);
    await app.reshown(() => page.getByRole("radio", { name: "Linear" }).check());
    await app.reshown(() => backdrop.selectOption("environment"));
    return `${around}; one colour: ${plain}`;
  });

  await step("turns the object live in an environment without a lamp", async () => {
    const dark = await app.reshown(() => app.id("light-kind").selectOption("none"));
    assert.deepEqual(
      dark.lights.map(({ kind }) => kind),
      ["environment"],
    );
    assert.ok(await app.id("light-moves").isDisabled(), "nothing circles");
    await turnByHand(app, async () => {
      await allLit(page);
      await shot("9-studio-turning");
    });
    await noneLit(page);
    await app.accessible("an environment");
  });

  await step("removes the environment", async () => {
    await app.reshown(() => app.id("light-kind").selectOption("point"));
    const plain = await underLamp(app);
    assert.ok(!plain.backdrop, "no environment is left to show");
    assert.deepEqual(
      plain.lights.map(({ kind }) => kind),
      ["point"],
    );
  });

  await step("moves a light and an environment that circle live like the server", async () => {
    const send = poster(base);
    const lights = [{}, { kind: "environment", image: "interior" }];
    const film = { exposure: -1, tone: "none" };
    const { id: scene } = await send("/v1/scenes", { mesh: "ball", lights, film });
    const { id } = await send("/v1/lineages", { name: "Circling", start: "believable", scene });
    const constraints = { isotropic: true, homogeneous: true };
    await send(`/v1/lineages/${id}/generations`, { parents: [], seed: 6, constraints });
    await goTo(app, id);
    const circling = await app.generation(await app.ready());
    await hold(app, "light", 100);
    await allLit(page);
    const text = await asServerDraws(app, circling, 100, base);
    await shot("9-circling");
    await app.reshown(() => slide(app, "light", 100));
    await noneLit(page);
    await goTo(app, before);
    return text;
  });
}
