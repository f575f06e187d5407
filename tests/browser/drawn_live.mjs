// What the tests of live drawing share: a lineage opened in a scene, and its frames beside the
// server's pictures.

import { allLit, asServerDraws, hold, noneLit, slide } from "./live.mjs";
import { goTo } from "./materials.mjs";
import { poster } from "./server.mjs";

/** Angles of the light at which frames are compared, in degrees. */
const ANGLES = [75, 250];

/**
 * Creates a lineage with a brood and opens it; `created` is its name, start and scene. The brood is
 * random, or has a preset as its parent.
 */
export async function openLineage(app, base, created, seed, preset = null) {
  const send = poster(base);
  const { id: scene } = await send("/v1/scenes", created.scene);
  const { id } = await send("/v1/lineages", { ...created, scene });
  const adopted = preset && (await send(`/v1/lineages/${id}/adoptions`, { presets: [preset] }));
  const parents = adopted ? [adopted.individuals[0].id] : [];
  await send(`/v1/lineages/${id}/generations`, { parents, seed });
  await goTo(app, id);
  return app.generation(await app.ready());
}

/**
 * Asserts that the frames of a generation equal the server's pictures at some angles of the light,
 * and leaves it at the last one. `most`: largest share of pixels apart; `name`: of the screenshots;
 * `query`: more parameters of the server's pictures.
 */
export async function comparedAround(app, shot, base, generation, name, most, query = "") {
  const text = [];
  for (const degrees of ANGLES) {
    await hold(app, "light", degrees);
    await allLit(app.page);
    text.push(await asServerDraws(app, generation, degrees, base, null, most, query));
    await shot(`${name}-${degrees}`);
  }
  await app.reshown(() => slide(app, "light", ANGLES.at(-1)));
  await noneLit(app.page);
  return text.join("; ");
}
