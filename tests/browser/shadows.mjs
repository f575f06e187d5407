// Hard shadows drawn live, compared with the server's pictures.

import { strict as assert } from "node:assert";

import { comparedAround, openLineage } from "./drawn_live.mjs";
import { asServerDraws } from "./live.mjs";
import { goTo } from "./materials.mjs";
import { poster } from "./server.mjs";

/** Runs the journey; `shot` saves a screenshot. */
export async function shadowsLive(app, step, shot, base) {
  const { lineage: before } = await app.generation(await app.ready());

  await step("moves hard shadows with the light like the server", async () => {
    const scene = {
      mesh: "knob",
      lights: [{}, { position: [-3, 1, 2], intensity: [6, 5, 4] }],
      film: { exposure: -1, tone: "none" },
    };
    const created = { name: "In shadow", start: "believable", scene: { ...scene, shadows: true } };
    const generation = await openLineage(app, base, created, 7);
    const text = await comparedAround(app, shot, base, generation, "9-shadows");
    const { id: plain } = await poster(base)("/v1/scenes", scene);
    await assert.rejects(asServerDraws(app, generation, 250, base, plain), /apart in/);
    await goTo(app, before);
    return text;
  });
}
