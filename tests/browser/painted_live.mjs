// Painted materials drawn live, compared with the server's pictures: a lamp, coloured lights with
// shadows, an environment, a backdrop; the object while it is rotated.

import { allLit, asServerDraws, hold, noneLit, slide } from "./live.mjs";
import { goTo, turnByHand } from "./materials.mjs";
import { poster } from "./server.mjs";

/**
 * Largest share of pixels apart: edges of paint are as wide as pixels in both. What is left are
 * edges of the object before itself and of shadows, a smaller share in larger frames.
 */
const APART = 0.02;
const LARGE = { width: 1440, height: 985 };

/** Runs the journey; `shot` saves a screenshot. */
export async function paintedLive(app, step, shot, base) {
  const { page } = app;
  const send = poster(base);
  const size = page.viewportSize();
  await page.setViewportSize(LARGE);
  const { lineage: before } = await app.generation(await app.ready());

  /** Opens a painted lineage in a scene. */
  const opened = async (name, scene, seed) => {
    const { id: of } = await send("/v1/scenes", scene);
    const { id } = await send("/v1/lineages", { name, start: "painted", scene: of });
    await send(`/v1/lineages/${id}/generations`, { parents: [], seed });
    await goTo(app, id);
    return app.generation(await app.ready());
  };

  /** Compares at two angles of the light. */
  const compared = async (generation, name) => {
    const text = [];
    for (const degrees of [75, 250]) {
      await hold(app, "light", degrees);
      await allLit(page);
      text.push(await asServerDraws(app, generation, degrees, base, null, APART));
      await shot(`40-${name}-${degrees}`);
    }
    await app.reshown(() => slide(app, "light", 250));
    await noneLit(page);
    return text.join("; ");
  };

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
