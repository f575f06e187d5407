// Measures frames per second of live drawing, 21 materials under the circling light, and how many
// exported programs keep their bits, in headless Chromium: `node tests/browser/rate.mjs [--angle
// NAME] [--hardware] [--side PX] [--seconds S] [--objects NAME,...] [--environment NAME]
// [--shadows] [--ground] [--preset NAME] [--seeds N,...] [--programs N]`, with $BROOD_BIN and
// $CHROMIUM as for the journey. In an environment programs are isotropic and homogeneous. --ground
// puts the object on the ground beside a golden ball. --preset draws children of a painted preset
// instead of random programs. Without --angle the browser's software renderer draws; with it, the
// system's: gl-egl for OpenGL on a Linux machine without a screen, gl, vulkan, metal or d3d11
// elsewhere. This is a measurement and not a test: it prints one line of JSON for each object and
// seed, and one for the exports. It fails only if --hardware is given and software draws. `cargo
// xtask bench live` makes tables of the output.

import { parseArgs } from "node:util";
import { chromium } from "playwright-core";

import { runExports } from "./exports.mjs";
import { MODULES } from "./page.mjs";
import { binary, poster, startServer } from "./server.mjs";

const { values } = parseArgs({
  options: {
    angle: { type: "string" },
    hardware: { type: "boolean", default: false },
    side: { type: "string", default: "640" },
    seconds: { type: "string", default: "9" },
    objects: { type: "string", default: "sphere" },
    environment: { type: "string" },
    shadows: { type: "boolean", default: false },
    ground: { type: "boolean", default: false },
    preset: { type: "string" },
    seeds: { type: "string", default: "7" },
    programs: { type: "string", default: "0" },
  },
});
/** Waits until background compilation has ended. */
const SETTLING_MS = 5000;
/** Width of the window; its height follows from the size of the frames. */
const WIDTH_PX = 1400;
const HEIGHT_PX = 900;
const DEADLINE_MS = 600_000;

const number = (name) => {
  const value = Number(values[name]);
  if (!(value >= 0)) throw new Error(`--${name} needs a number, not ${values[name]}`);
  return value;
};
const [side, seconds, programs] = ["side", "seconds", "programs"].map(number);
const driver = values.angle
  ? [
      "--use-gl=angle",
      `--use-angle=${values.angle}`,
      "--ignore-gpu-blocklist",
      ...(values.angle === "vulkan" ? ["--enable-features=Vulkan"] : []),
    ]
  : ["--enable-unsafe-swiftshader"];
const say = (found) => console.log(JSON.stringify(found));

/** Creates a lineage with one random brood; returns its address on the page. */
async function made(url, object, seed) {
  const send = poster(url);
  const { environment: image } = values;
  const lights = [{}, ...(image ? [{ kind: "environment", image, fixed: true }] : [])];
  const ball = { mesh: "sphere", position: [1.1, 0, 0.6], scale: 0.4, stands: true, material: "gold" };
  const around = values.ground ? { ground: {}, objects: [ball] } : {};
  const { shadows } = values;
  const scene = await send("/v1/scenes", { mesh: object, lights, shadows, ...around });
  const { preset } = values;
  const kind = preset
    ? { start: "painted" }
    : { dialect: image ? { isotropic: true, homogeneous: true } : {} };
  const { id } = await send("/v1/lineages", { name: "rate", scene: scene.id, ...kind });
  const adopted = preset && (await send(`/v1/lineages/${id}/adoptions`, { presets: [preset] }));
  const parents = adopted ? [adopted.individuals[0].id] : [];
  const bred = await send(`/v1/lineages/${id}/generations`, { parents, seed });
  return `${url}${MODULES}#/lineage/${id}/generation/${bred.id}`;
}

/** Name of the renderer in this browser. */
const drawer = (page) =>
  page.evaluate(async () => {
    const { openContext } = await import("/web/live/canvas.js");
    const context = openContext(document.createElement("canvas"));
    return { renderer: context?.renderer ?? null, software: context?.software ?? true };
  });

/** Frames of the display over some seconds, and the size of the drawing buffer. */
const watch = (page) =>
  page.evaluate(async (seconds) => {
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
    const canvas = document.querySelector("canvas.live");
    const total = steps.reduce((sum, step) => sum + step, 0);
    steps.sort((a, b) => a - b);
    const rounded = (value) => Math.round(10 * value) / 10;
    return {
      fps: rounded((1000 * steps.length) / total),
      median_ms: rounded(steps[steps.length >> 1]),
      p95_ms: rounded(steps[Math.floor(steps.length * 0.95)]),
      buffer: [canvas.width, canvas.height],
    };
  }, seconds);

/**
 * Frames per second of the display without drawing, with a full buffer, and at the resolution that
 * the page chooses.
 */
async function rates(page, url) {
  await page.goto(url);
  const light = page.getByTestId("light-moves");
  await page.locator("[data-testid=light-moves]:enabled").waitFor();
  await page.waitForTimeout(SETTLING_MS);
  const across = await page.evaluate(
    () => document.querySelector("canvas.live").parentElement.getBoundingClientRect().width,
  );
  await page.setViewportSize({ width: WIDTH_PX, height: HEIGHT_PX + Math.round(side - across) });
  const idle = await watch(page);
  const chosen = await page.evaluateHandle(async () => {
    const { AdaptiveResolution } = await import("/web/live/resolution.js");
    const { step } = AdaptiveResolution.prototype;
    AdaptiveResolution.prototype.step = () => false;
    return { resume: () => (AdaptiveResolution.prototype.step = step) };
  });
  const begun = Date.now();
  await light.click();
  await page.waitForFunction(() => document.querySelectorAll(".pictures.lit").length === 21);
  const all_drawn_ms = Date.now() - begun;
  await page.waitForTimeout(SETTLING_MS);
  const whole = await watch(page);
  await chosen.evaluate((pace) => pace.resume());
  await page.waitForTimeout(SETTLING_MS);
  return { display_fps: idle.fps, all_drawn_ms, whole, paced: await watch(page) };
}

/** Runs exported programs and compares them bit for bit. */
async function exports(page) {
  const found = await runExports(page, binary, values.programs);
  const kept = found.models.filter(({ kept }) => kept).length;
  const { renderer, programs, exact, values: count, differing, within_exact, failures } = found;
  return {
    renderer,
    exports: {
      programs,
      exact,
      values: count,
      differing,
      within_exact,
      failures: failures.length,
      kinds: found.models.length,
      kinds_kept: kept,
    },
  };
}

const server = await startServer();
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: [
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    ...driver,
  ],
});
try {
  // A new page for each figure, so that nothing is compiled yet; reduced motion, so that the light
  // starts with its button.
  const inPage = async (work) => {
    const page = await browser.newPage({
      viewport: { width: WIDTH_PX, height: HEIGHT_PX },
      reducedMotion: "reduce",
    });
    page.setDefaultTimeout(DEADLINE_MS);
    const found = await work(page);
    await page.close();
    return found;
  };
  const by = await inPage(async (page) => {
    await page.goto(server.url);
    return drawer(page);
  });
  if (by.renderer === null)
    throw new Error("this browser has no WebGL 2 here; another --angle may have");
  if (values.hardware && by.software) throw new Error(`${by.renderer}: this is software`);
  for (const object of values.objects.split(",")) {
    for (const seed of values.seeds.split(",")) {
      const url = await made(server.url, object, seed);
      say({ ...by, object, seed, ...(await inPage((page) => rates(page, url))) });
    }
  }
  if (programs > 0) say(await inPage(exports));
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
} finally {
  await browser.close();
  await server.stop();
}
