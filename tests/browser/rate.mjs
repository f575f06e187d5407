// How many frames a second the page draws live, 21 materials under the circling light, in headless Chromium with software
// WebGL: `node tests/browser/rate.mjs [--side PX] [--seconds S] [--object NAME] [--seed N]`, with $BROOD_BIN and $CHROMIUM as
// the journey has them. A measurement, not a test: it prints what it found, whatever that is. The window is chosen so that the
// frames are as many pixels across; what the page makes of a slow machine is switched off.

import { parseArgs } from "node:util";
import { chromium } from "playwright-core";

import { startServer } from "./server.mjs";

const { values } = parseArgs({
  options: {
    side: { type: "string", default: "640" },
    seconds: { type: "string", default: "9" },
    object: { type: "string", default: "sphere" },
    seed: { type: "string", default: "7" },
  },
});
/** Until what was compiled in the background no longer is. */
const SETTLING_MS = 5000;

async function made(url, { seed, object }) {
  const send = async (path, body) => {
    const answer = await fetch(`${url}${path}`, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
    if (!answer.ok) throw new Error(`${path}: ${await answer.text()}`);
    return answer.json();
  };
  const scene = await send("/v1/scenes", { mesh: object });
  const lineage = await send("/v1/lineages", { name: "rate", scene: scene.id });
  const bred = await send(`/v1/lineages/${lineage.id}/generations`, { parents: [], seed });
  return `${url}/#/lineage/${lineage.id}/generation/${bred.id}`;
}

const server = await startServer();
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--no-first-run", "--disable-background-networking", "--enable-unsafe-swiftshader"],
});
try {
  const page = await browser.newPage({ viewport: { width: 1400, height: 900 } });
  page.setDefaultTimeout(120_000);
  await page.goto(await made(server.url, values));
  await page.locator("[data-testid=light-moves]:enabled").waitFor();
  const across = () => page.evaluate(() => document.querySelector("canvas.live").parentElement.getBoundingClientRect().width);
  const height = 900 + Math.round(Number(values.side) - (await across()));
  await page.setViewportSize({ width: 1400, height });
  await page.evaluate(async () => {
    const { Pace } = await import("/web/live/stage.js");
    Pace.prototype.step = () => false;
  });
  await page.getByRole("button", { name: "Let the light circle" }).click();
  await page.waitForFunction(() => document.querySelectorAll(".pictures.lit").length === 21);
  await page.waitForTimeout(SETTLING_MS);
  const found = await page.evaluate(async (seconds) => {
    const canvas = document.querySelector("canvas.live");
    const steps = [];
    await new Promise((done) => {
      const start = performance.now();
      let last = null;
      const tick = (now) => {
        if (last !== null) steps.push(now - last);
        last = now;
        if (now - start < 1000 * seconds) requestAnimationFrame(tick);
        else done(null);
      };
      requestAnimationFrame(tick);
    });
    const total = steps.reduce((sum, step) => sum + step, 0);
    steps.sort((a, b) => a - b);
    return { buffer: [canvas.width, canvas.height], frames: steps.length, fps: (1000 * steps.length) / total, median_ms: steps[steps.length >> 1], p95_ms: steps[Math.floor(steps.length * 0.95)] };
  }, Number(values.seconds));
  console.log(JSON.stringify({ object: values.object, seed: values.seed, ...found }));
} finally {
  await browser.close();
  await server.stop();
}
