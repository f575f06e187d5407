// Hard shadows drawn live, compared with the server's pictures.

import { strict as assert } from "node:assert";

import { allLit, asServerDraws, hold, noneLit, slide } from "./live.mjs";
import { goTo } from "./materials.mjs";
import { poster } from "./server.mjs";

/** Runs the journey; `shot` saves a screenshot. */
export async function shadowsLive(app, step, shot, base) {
  const { page } = app;
  const { lineage: before } = await app.generation(await app.ready());

  await step("moves hard shadows with the light like the server", async () => {
    const send = poster(base);
    const scene = {
      mesh: "knob",
      lights: [{}, { position: [-3, 1, 2], intensity: [6, 5, 4] }],
      film: { exposure: -1, tone: "none" },
    };
    const { id: plain } = await send("/v1/scenes", scene);
    const { id: shadowed } = await send("/v1/scenes", { ...scene, shadows: true });
    const { id } = await send("/v1/lineages", {
      name: "In shadow",
      start: "believable",
      scene: shadowed,
    });
    await send(`/v1/lineages/${id}/generations`, { parents: [], seed: 7 });
    await goTo(app, id);
    const generation = await app.generation(await app.ready());
    const text = [];
    for (const degrees of [75, 250]) {
      await hold(app, "light", degrees);
      await allLit(page);
      text.push(await asServerDraws(app, generation, degrees, base));
      await shot(`9-shadows-${degrees}`);
    }
    await assert.rejects(asServerDraws(app, generation, 250, base, plain), /apart in/);
    await app.reshown(() => slide(app, "light", 250));
    await noneLit(page);
    await goTo(app, before);
    return text.join("; ");
  });
}
