// Painted materials drawn live, compared with the server's pictures: a lamp, coloured lights with
// shadows, an environment, a backdrop; the object while it is rotated.

import { comparedAround, openLineage } from "./drawn_live.mjs";
import { allLit, noneLit } from "./live.mjs";
import { goTo, turnByHand } from "./materials.mjs";

/**
 * Largest share of pixels apart: edges of paint are as wide as pixels in both. What is left are
 * edges of the object before itself and of shadows, a smaller share in larger frames.
 */
const APART = 0.02;
const LARGE = { width: 1440, height: 985 };

/** Runs the journey; `shot` saves a screenshot. */
export async function paintedLive(app, step, shot, base) {
  const { page } = app;
  const size = page.viewportSize();
  await page.setViewportSize(LARGE);
  const { lineage: before } = await app.generation(await app.ready());

  const opened = (name, scene, seed) =>
    openLineage(app, base, { name, start: "painted", scene }, seed);
  const compared = (generation, name) =>
    comparedAround(app, shot, base, generation, `40-${name}`, APART);

  await step("draws painted materials live like the server", async () => {
    const generation = await opened("Painted", { mesh: "knob", lights: [{}] }, 3);
    const text = await compared(generation, "painted");
    await turnByHand(app, async () => {
      await allLit(page);
      await shot("40-painted-turning");
    });
    await noneLit(page);
    return text;
  });

  await step("draws shadows and coloured lights on painted materials like the server", async () => {
    const lights = [{}, { position: [-3, 1, 2], intensity: [6, 3, 1] }];
    const scene = { mesh: "knob", lights, shadows: true };
    return compared(await opened("Painted in shadow", scene, 4), "painted-shadows");
  });

  await step("draws painted materials in an environment that turns like the server", async () => {
    const lights = [
      { kind: "environment", image: "studio", rotation_deg: 40, scale: [1, 0.8, 0.6] },
      {},
    ];
    return compared(await opened("Painted studio", { mesh: "knob", lights }, 5), "painted-studio");
  });

  await goTo(app, before);
  await page.setViewportSize(size);
  app.quiet();
}
