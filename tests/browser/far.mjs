// Measures how long the page takes far from the server, in headless Chromium with a slow network:
// `node tests/browser/far.mjs [--latency MS] [--rate KBYTES_PER_S] [--runs N] [--clicks N]
// [--waterfall FILE] [--drawing]`, with $BROOD_BIN, $BROOD_WEB and $CHROMIUM as for the journey.
// This is a measurement and not a test: it prints one line of JSON for each visit and each click.
// `cargo xtask bench far` makes tables of the output.
//
// The browser delays each answer by the latency and shares the rate among all of them. It delays
// neither TCP handshakes nor the first packets of a connection. The server has a name that is not
// localhost, because browsers accept Brotli only there and over TLS, and else gzip.

import { writeFile } from "node:fs/promises";
import { parseArgs } from "node:util";
import { chromium } from "playwright-core";

import { poster, startServer } from "./server.mjs";

const { values } = parseArgs({
  options: {
    latency: { type: "string", default: "300" },
    rate: { type: "string", default: "200" },
    runs: { type: "string", default: "3" },
    clicks: { type: "string", default: "3" },
    waterfall: { type: "string" },
    drawing: { type: "boolean", default: false },
  },
});
const NAME = "far.test";
const DEADLINE_MS = 120_000;
/** Time after the last picture in which requests are still counted. */
const SETTLING_MS = 4000;
const SEED = 7;
/** Frames to click, by slot. */
const SLOTS = [3, 8, 12, 17, 5];

const number = (name) => {
  const value = Number(values[name]);
  if (!(value > 0)) throw new Error(`--${name} needs a positive number, not ${values[name]}`);
  return value;
};
const [latency, rate, runs, clicks] = ["latency", "rate", "runs", "clicks"].map(number);
const say = (found) => console.log(JSON.stringify(found));

/** Creates a lineage with a brood of a random parent, draws its pictures; returns its address. */
async function made(url) {
  const send = poster(url);
  const scene = await send("/v1/scenes", { mesh: "ball" });
  const lineage = await send("/v1/lineages", { name: "far", scene: scene.id, saturation: 0.65 });
  const breed = (parents) =>
    send(`/v1/lineages/${lineage.id}/generations`, { parents, mutation: 0.3, seed: SEED });
  const first = await breed([]);
  const second = await breed([first.individuals[2].id]);
  for (const { centre, individuals } of [first, second])
    for (const one of [centre, ...individuals].filter(Boolean))
      if (!(await fetch(url + one.thumbnail)).ok) throw new Error(`${one.thumbnail} is not drawn`);
  return `${url}/#/lineage/${lineage.id}/generation/${second.id}`;
}

/** Runs in the page: records when pictures of frames load, and when all are there. */
function record() {
  const far = { loads: [], ready: [], clicked: 0 };
  globalThis.far = far;
  document.addEventListener(
    "load",
    ({ target }) => {
      if (!(target instanceof HTMLImageElement) || !target.dataset.frame) return;
      const { frame, generation } = target.dataset;
      far.loads.push({ frame, generation, at: performance.now() });
    },
    true,
  );
  document.addEventListener("pointerdown", () => (far.clicked = performance.now()), true);
  document.addEventListener("DOMContentLoaded", () =>
    new MutationObserver(() => {
      const id = document.body.dataset.ready;
      if (id) far.ready.push({ id, at: performance.now() });
    }).observe(document.body, { attributes: true, attributeFilter: ["data-ready"] }),
  );
}

/** Counts requests and bytes on the wire, and keeps their times. */
function watchNetwork(client) {
  let requests = new Map();
  client.on("Network.requestWillBeSent", ({ requestId, request, timestamp }) => {
    if (request.url.startsWith("http"))
      requests.set(requestId, { url: request.url, method: request.method, start: timestamp, bytes: 0 });
  });
  client.on("Network.responseReceived", ({ requestId, response, timestamp }) => {
    const known = requests.get(requestId);
    if (known) Object.assign(known, { answered: timestamp, cached: response.fromDiskCache });
  });
  client.on("Network.dataReceived", ({ requestId, encodedDataLength }) => {
    const known = requests.get(requestId);
    if (known) known.bytes += encodedDataLength;
  });
  client.on("Network.loadingFinished", ({ requestId, timestamp, encodedDataLength }) => {
    const known = requests.get(requestId);
    if (known) Object.assign(known, { end: timestamp, bytes: encodedDataLength });
  });
  return {
    /** Requests since the last call, without those answered from the browser's cache. */
    take() {
      const all = [...requests.values()].filter((one) => !one.cached);
      requests = new Map();
      return all;
    },
  };
}

const total = (requests) => ({
  requests: requests.length,
  bytes: requests.reduce((sum, one) => sum + one.bytes, 0),
});

/** Start, answer and end of each request in ms after the first, for a person to read. */
function waterfall(name, requests) {
  const zero = Math.min(...requests.map(({ start }) => start));
  const ms = (time) => (time ? String(Math.round(1000 * (time - zero))).padStart(6) : "     -");
  const lines = requests.map(
    ({ url, method, start, answered, end, bytes }) =>
      `${ms(start)} ${ms(answered)} ${ms(end)} ${String(bytes).padStart(7)} ${method} ${new URL(url).pathname.slice(0, 80)}`,
  );
  return `${name}\n start answer    end   bytes\n${lines.join("\n")}\n\n`;
}

/** Ids of the generation whose pictures are all there, awaited; not the given one. */
const ready = (page, previous = "") =>
  page
    .waitForFunction(
      (not) => {
        const id = document.body?.dataset.ready;
        return id && id !== not && id;
      },
      previous,
      { polling: 20 },
    )
    .then((handle) => handle.jsonValue());

async function visit(browser, url, run) {
  const context = await browser.newContext({
    viewport: { width: 1400, height: 900 },
    reducedMotion: "reduce",
  });
  context.setDefaultTimeout(DEADLINE_MS);
  await context.addInitScript(record);
  const page = await context.newPage();
  const client = await context.newCDPSession(page);
  await client.send("Network.enable");
  await client.send("Network.emulateNetworkConditions", {
    offline: false,
    latency,
    downloadThroughput: 1000 * rate,
    uploadThroughput: 1000 * rate,
  });
  const network = watchNetwork(client);
  let text = "";
  await page.goto(url, { waitUntil: "commit" });
  let id = await ready(page);
  const before = network.take();
  const times = await page.evaluate(() => ({
    first_picture_ms: globalThis.far.loads.find(({ frame }) => frame === "centre")?.at,
    any_picture_ms: globalThis.far.loads[0]?.at,
    all_pictures_ms: globalThis.far.ready[0]?.at,
  }));
  text += waterfall("visit", before);
  await page.waitForTimeout(SETTLING_MS);
  const after = network.take();
  text += waterfall("after the visit", after);
  say({ kind: "visit", run, ...times, ...total(before), later: total(after) });
  for (const slot of SLOTS.slice(0, clicks)) {
    await page.getByTestId(`cell-${slot}`).click();
    const previous = id;
    id = await ready(page, previous);
    const during = network.take();
    const found = await page.evaluate((generation) => {
      const { loads, ready, clicked } = globalThis.far;
      const own = loads.filter((one) => one.generation === generation);
      return {
        first_child_ms: own.find(({ frame }) => frame !== "centre").at - clicked,
        all_children_ms: ready.find((one) => one.id === generation).at - clicked,
      };
    }, id);
    text += waterfall(`click on ${slot}`, during);
    await page.waitForTimeout(SETTLING_MS);
    const later = network.take();
    text += waterfall(`after the click on ${slot}`, later);
    say({ kind: "click", run, slot, ...found, ...total(during), later: total(later) });
  }
  await context.close();
  return text;
}

const server = await startServer(["--allow-host", NAME]);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: [
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    `--host-resolver-rules=MAP ${NAME} 127.0.0.1`,
    ...(values.drawing ? ["--enable-unsafe-swiftshader"] : ["--disable-gpu", "--disable-3d-apis"]),
  ],
});
try {
  const url = (await made(server.url)).replace("127.0.0.1", NAME);
  for (let run = 1; run <= runs; run += 1) {
    // A new context has an empty cache.
    const text = await visit(browser, url, run);
    if (values.waterfall && run === 1) await writeFile(values.waterfall, text);
  }
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
} finally {
  await browser.close();
  await server.stop();
}
