// Clear materials drawn live, compared with the server's pictures: what their rays see of a
// backdrop, of objects and of the ground, at any angle of the light.

import { strict as assert } from "node:assert";

import { comparedAround, openLineage } from "./drawn_live.mjs";
import { hold, noneLit, slide } from "./live.mjs";
import { goTo, turnByHand } from "./materials.mjs";
import { glass, uploaded } from "./scene_images.mjs";

/**
 * Largest share of pixels apart: edges of the body, and of what it shows. Live frames have one ray
 * of each kind for a pixel.
 */
const APART = 0.06;
const LARGE = { width: 1440, height: 985 };

/** Runs the journey; `shot` saves a screenshot. */
export async function clearLive(app, step, shot, base) {
  const { page } = app;
  const size = page.viewportSize();
  await page.setViewportSize(LARGE);
  const { lineage: before } = await app.generation(await app.ready());

  const opened = (name, preset, scene, seed) =>
    openLineage(app, base, { name, start: "painted", scene }, seed, preset);
  const compared = (generation, name) =>
    comparedAround(app, shot, base, generation, `42-${name}`, APART, "&samples=1");

  await step("draws glass before a picture, clear in parts, live like the server", async () => {
    const backdrop = { kind: "image", image: await uploaded(base, await glass(page)) };
    const scene = { mesh: "knob", lights: [{}], backdrop };
    const generation = await opened("Glass", "paint-glass", scene, 3);
    const text = await compared(generation, "glass");
    await turnByHand(app, async () => {
      assert.equal(await page.locator(".pictures.lit").count(), 0, "the server draws a turned body");
    });
    await noneLit(page);
    return text;
  });

  await step("shows objects, the ground and their light in glass", async () => {
    const lights = [{ position: [3, 4, 2.5] }, { position: [-3, 2.5, 2], intensity: [14, 11, 8] }];
    const scene = {
      mesh: "ball", camera: { orbit_deg: [15, 22] }, lights, ground: { material: "paint-toon" },
      film: { exposure: -1, tone: "filmic" },
      objects: [
        { mesh: "sphere", position: [1.1, 0, 0.6], scale: 0.4, stands: true, material: "gold" },
        { mesh: "torus", position: [-1.2, 0.2, -0.5], scale: 0.45, rotation_deg: [50, 20, 0] },
      ],
    };
    return compared(await opened("Glass among", "paint-glass", scene, 5), "glass-among");
  });

  await step("casts the lighter shadows of clear bodies live, also on what glass shows", async () => {
    const scene = {
      mesh: "knob", shadows: true, camera: { orbit_deg: [15, 22] },
      lights: [{ position: [3, 4, 2.5] }, { kind: "directional", direction: [2, -2, -1] }],
      ground: {}, film: { exposure: -1, tone: "none" },
      backdrop: { kind: "color", color: [0.8, 0.5, 0.2] },
      objects: [
        { mesh: "sphere", position: [1.1, 0, 0.6], scale: 0.4, stands: true, material: "paint-toon" },
      ],
    };
    return compared(await opened("Clear shadows", "paint-jelly", scene, 6), "glass-shadows");
  });

  await step("keeps the server's pictures of glass in an environment, beside live frames", async () => {
    const lights = [{}, { kind: "environment", image: "studio" }];
    const { individuals } = await opened("Glass in a studio", "paint-glass", { mesh: "knob", lights }, 5);
    const code = individuals.map(({ id }) => fetch(`${base}/v1/individuals/${id}/exports/glsl-es-300`));
    const texts = await Promise.all((await Promise.all(code)).map((answer) => answer.text()));
    const opaque = texts.filter((text) => !text.includes("StyledGlass")).length;
    assert.ok(opaque > 0 && opaque < 20, `${opaque} children have no glass`);
    await hold(app, "light", 75);
    const isLit = (count) => document.querySelectorAll(".pictures.lit").length === count;
    await page.waitForFunction(isLit, opaque);
    await shot("42-glass-studio");
    await app.reshown(() => slide(app, "light", 75));
    await noneLit(page);
    return `${opaque} of 20 are live`;
  });

  await goTo(app, before);
  await page.setViewportSize(size);
  app.quiet();
}
