// Other objects and the ground drawn live, compared with the server's pictures: lit and painted
// ones, with shadows, while the object is rotated.

import { strict as assert } from "node:assert";

import { comparedAround, openLineage } from "./drawn_live.mjs";
import { allLit, hold, noneLit, slide } from "./live.mjs";
import { goTo, turnByHand } from "./materials.mjs";

/**
 * Largest share of pixels apart. Edges of objects and of shadows are all there is: edges have four
 * samples, shadows one, and the ground shows both in every frame.
 */
const APART = 0.06;
const LARGE = { width: 1440, height: 985 };
const LIGHTS = [{ position: [3, 4, 2.5] }, { position: [-3, 2.5, 2], intensity: [14, 11, 8] }];
const CAMERA = { orbit_deg: [15, 22] };

/** Runs the journey; `shot` saves a screenshot. */
export async function neighboursLive(app, step, shot, base) {
  const { page } = app;
  const size = page.viewportSize();
  await page.setViewportSize(LARGE);
  const { lineage: before } = await app.generation(await app.ready());

  const opened = (name, start, scene, seed) => openLineage(app, base, { name, start, scene }, seed);
  const compared = (generation, name) =>
    comparedAround(app, shot, base, generation, `41-${name}`, APART);

  await step("draws objects on the ground live like the server, in its exposure", async () => {
    const scene = {
      mesh: "knob", shadows: true, camera: CAMERA, lights: LIGHTS, ground: {},
      objects: [
        { mesh: "sphere", position: [1.1, 0, 0.6], scale: 0.4, stands: true, material: "gold" },
        { mesh: "torus", position: [-1.2, 0.2, 0.5], scale: 0.45, rotation_deg: [50, 20, 0] },
      ],
    };
    const generation = await opened("On the ground", "believable", scene, 7);
    const text = await compared(generation, "ground");
    await turnByHand(app, async () => {
      await allLit(page);
      await shot("41-ground-turning");
    });
    await noneLit(page);
    return text;
  });

  await step("draws painted and lit objects beside each other", async () => {
    const scene = {
      mesh: "knob", shadows: true, camera: CAMERA, lights: LIGHTS,
      ground: { material: "paint-toon" },
      film: { exposure: -1, tone: "filmic" },
      objects: [
        { mesh: "ball", position: [1.1, 0, 0.6], scale: 0.4, stands: true, material: "paint-toon" },
        { mesh: "cube", position: [-1, 0, 0.7], scale: 0.3, stands: true, material: "red-plastic" },
      ],
    };
    return compared(await opened("Painted beside", "painted", scene, 4), "painted-ground");
  });

  await step("draws painted objects on the ground under a directional and a spot light", async () => {
    const scene = {
      mesh: "knob", shadows: true, camera: CAMERA, ground: { material: "paint-toon" },
      lights: [
        { kind: "directional" },
        { kind: "spot", position: [-2, 3, 2], hotspot_deg: 5, falloff_deg: 12 },
      ],
      objects: [
        { mesh: "ball", position: [1.1, 0, 0.6], scale: 0.4, stands: true, material: "gold" },
      ],
      film: { exposure: -1, tone: "none" },
    };
    return compared(await opened("Under a sun", "painted", scene, 4), "sun");
  });

  await step("draws an object without ground or shadows", async () => {
    const scene = {
      mesh: "cube", rotation_deg: [0, 30, 0], lights: LIGHTS,
      film: { exposure: -1, tone: "none" },
      objects: [{ mesh: "sphere", position: [0.7, 0.3, 0.9], scale: 0.5, material: "gold" }],
    };
    return compared(await opened("A neighbour", "believable", scene, 5), "neighbour");
  });

  await step("keeps the server's pictures where others stand in an environment", async () => {
    const lights = [{}, { kind: "environment", image: "studio", shadows: false }];
    await opened("In a studio", "believable", { mesh: "knob", shadows: true, ground: {}, lights }, 6);
    await app.id("stills").waitFor();
    await hold(app, "light", 75);
    await page.locator("img.still").first().waitFor();
    await app.reshown(() => slide(app, "light", 75));
    assert.equal(await page.locator(".pictures.lit").count(), 0);
  });

  await goTo(app, before);
  await page.setViewportSize(size);
  app.quiet();
}
