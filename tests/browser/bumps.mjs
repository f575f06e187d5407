// Bumps: asked for, bred, locked and removed on the page; and drawn live like the server.

import { strict as assert } from "node:assert";

import { allLit, asServerDraws, hold, noneLit, slide } from "./live.mjs";
import { goTo } from "./materials.mjs";
import { poster } from "./server.mjs";

/** Bumps of the children of a generation: their lines in the genome's text. */
async function bumpsOf(app, base, { individuals }) {
  const text = async ({ hash }) => (await fetch(`${base}/v1/genomes/${hash}`, { headers: { accept: "text/x-brood" } })).text();
  const texts = await Promise.all(individuals.map(text));
  return texts.map((one) => one.split("\n").filter((line) => line.startsWith(".bump ")).join("\n"));
}

/** Runs the journey; `shot` saves a screenshot. */
export async function bumps(app, step, shot, base) {
  const { page } = app;
  const { lineage: before } = await app.generation(await app.ready());

  await step("breeds bumps, keeps them where they are locked, and removes them", async () => {
    const send = poster(base);
    const { id } = await send("/v1/lineages", { name: "Bumps", start: "models" });
    await send(`/v1/lineages/${id}/generations`, { parents: [], seed: 3 });
    await goTo(app, id);
    const choose = (name) =>
      app.id("bumps").getByRole("radio", { name, exact: true }).check();
    const bred = async (slot) => {
      const generation = await app.generation(await app.becomes(() => app.cell(slot).click()));
      return { generation, bumps: await bumpsOf(app, base, generation) };
    };
    assert.ok((await bred(2)).bumps.every((lines) => lines === ""));
    await choose("all");
    const first = await bred(4);
    assert.ok(first.bumps.every((lines) => lines.startsWith(".bump strength")));
    assert.ok(new Set(first.bumps).size > 15, "random bumps differ");
    await shot("44-bumps");
    await choose("as parents");
    await page.getByRole("switch", { name: "Lock bumps" }).check();
    const second = await bred(7);
    assert.ok(second.bumps.every((lines) => lines === first.bumps[7]), "locked bumps stay");
    assert.match(await app.id("locks-count").textContent(), /^bumps locked/);
    await app.id("locks-unlock").click();
    const third = await bred(1);
    assert.ok(third.bumps.some((lines) => lines !== first.bumps[7]), "bumps vary");
    assert.ok(third.bumps.every((lines) => lines !== ""), "children have the bumps of parents");
    await page.reload();
    await app.ready();
    await choose("none");
    assert.ok((await bred(5)).bumps.every((lines) => lines === ""));
    await app.accessible("bumps");
    await goTo(app, before);
    app.quiet();
  });
}

/** Compares live drawing of bumps with the server's pictures. */
export async function bumpsLive(app, step, shot, base) {
  const { lineage: before } = await app.generation(await app.ready());

  await step("draws bumps live like the server", async () => {
    const send = poster(base);
    const lights = [{ kind: "point" }];
    const { id: scene } = await send("/v1/scenes", { mesh: "knob", lights, film: { exposure: -1 } });
    const { id } = await send("/v1/lineages", { name: "Bumps, live", start: "believable", scene });
    const constraints = { isotropic: true, bumps: true };
    await send(`/v1/lineages/${id}/generations`, { parents: [], seed: 4, constraints });
    await goTo(app, id);
    const generation = await app.generation(await app.ready());
    // Bumps are finer than pixels: live drawing and one sample see their centres.
    const once = [base, null, undefined, "&samples=1"];
    const text = [];
    for (const degrees of [75, 250]) {
      await hold(app, "light", degrees);
      await allLit(app.page);
      text.push(await asServerDraws(app, generation, degrees, ...once));
      await shot(`44-bumps-${degrees}`);
    }
    await app.reshown(() => slide(app, "light", 250));
    await noneLit(app.page);
    return text.join("; ");
  });

  await goTo(app, before);
  app.quiet();
}
