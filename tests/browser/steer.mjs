// Steering: chips beside the mutation slider, by mouse and keyboard.

import { strict as assert } from "node:assert";

export async function steer(app, step, shot) {
  const { page } = app;
  const chip = (word) => page.getByTestId(`steer-${word}`);

  await step("steers a brood", async () => {
    await chip("warmer").check();
    // A word that contradicts replaces the other one; the keyboard does the same as the mouse.
    await chip("cooler").focus();
    await page.keyboard.press("Space");
    await chip("glossier").check();
    assert.deepEqual([await chip("warmer").isChecked(), await chip("cooler").isChecked()], [false, true]);
    // Believable programs can have a pattern.
    assert.ok(await chip("more-pattern").isEnabled());
    const child = await app.generation(await app.becomes(() => app.cell(3).click()));
    assert.deepEqual(child.steer, ["cooler", "glossier"]);
    await page.getByText("cooler, glossier", { exact: true }).waitFor();
    await shot("1-steered");
    await app.accessible("steered");
    for (const word of ["cooler", "glossier"]) await chip(word).uncheck();
  });
}
