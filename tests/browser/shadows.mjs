// Hard shadows, and directional and spot lights, drawn live, compared with the server's pictures.

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

  await step("draws directional and spot lights like the server, without and with shadows", async () => {
    const scene = {
      mesh: "knob",
      rotation_deg: [10, 30, 0],
      lights: [
        { kind: "directional", direction: [-2, -1, -2], irradiance_w_m2: [3, 2.6, 2] },
        { kind: "spot", position: [-3, 1, 2], intensity: [14, 15, 16] },
      ],
      film: { exposure: -1, tone: "none" },
    };
    const under = async (name, given) => {
      const created = { name, start: "believable", scene: { ...scene, ...given } };
      const generation = await openLineage(app, base, created, 7);
      return comparedAround(app, shot, base, generation, `9-${name.toLowerCase().replace(" ", "-")}`);
    };
    const text = [await under("Parallel light", {}), await under("Low sun", { shadows: true })];
    await goTo(app, before);
    return text.join("; ");
  });
}
