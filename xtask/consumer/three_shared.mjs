// Shared by the tests of both formats of three.js: Chromium, files without a network, reference
// values, bounds and output. A test is run as `node TEST.mjs FILES PACKAGES`: FILES holds the files
// of `brood bench consumer`, PACKAGES has three.js in node_modules. $CHROMIUM names the browser.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { extname, join, resolve } from "node:path";

const browserTools = createRequire(new URL("../../tests/browser/", import.meta.url));
const { chromium } = browserTools("playwright-core");
/** Script of the accessibility checker. */
export const AXE = browserTools.resolve("axe-core/axe.min.js");

/** Origin of the files; requests to it never leave the browser. */
export const ORIGIN = "https://exports.test";
/** Milliseconds for the compilation of a shader by a software renderer. */
const TIMEOUT_MS = 120_000;
const MEDIA_TYPES = { ".html": "text/html", ".js": "text/javascript" };

const [files, packages] = process.argv.slice(2).map((folder) => resolve(folder));
const modules = join(packages, "node_modules");
export const version = JSON.parse(await readFile(join(modules, "three/package.json"))).version;

const doubles = (text) => {
  const bytes = Buffer.from(text, "base64");
  return new Float64Array(bytes.buffer, bytes.byteOffset, bytes.length / 8);
};

/** Pairs: wi, wo, u and v of each; and materials with `f`, red, green and blue of each pair. */
export async function readCases() {
  const listed = JSON.parse(await readFile(join(files, "cases.json")));
  const cases = listed.cases.filter((it) => it.file && it.f);
  return {
    pairs: [...doubles(listed.pairs)],
    cases: cases.map((it) => ({ ...it, f: doubles(it.f) })),
    refused: listed.cases.filter((it) => it.refused).length,
  };
}

/**
 * Starts Chromium with its software renderer. Pages get files from the folders only; `index` is the
 * page of the origin itself.
 */
export async function start(args = [], index = "") {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--headless", "--no-sandbox", "--no-first-run", "--disable-background-networking",
      "--enable-unsafe-swiftshader", ...args],
  });
  const context = await browser.newContext({
    reducedMotion: "reduce", viewport: { width: 420, height: 240 },
  });
  context.setDefaultTimeout(TIMEOUT_MS);
  const cdn = `https://cdn.jsdelivr.net/npm/three@${version}/`;
  await context.route("**/*", async (route) => {
    const url = route.request().url();
    if (url === `${ORIGIN}/`) return route.fulfill({ body: index, contentType: "text/html" });
    const file = [[cdn, join(modules, "three")], [`${ORIGIN}/`, files]]
      .filter(([start]) => url.startsWith(start))
      .map(([start, folder]) => join(folder, url.slice(start.length)))[0];
    if (!file) return route.abort();
    await route.fulfill({
      body: await readFile(file), contentType: MEDIA_TYPES[extname(file)],
      headers: { "access-control-allow-origin": "*" },
    });
  });
  return { browser, context };
}

/** Opens a page whose errors of scripts and shaders are failures. */
export async function openPage(context) {
  const page = await context.newPage();
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("console", (message) => {
    if (message.type() === "error") complaints.push(message.text());
  });
  return { page, complaints };
}

/** Mean |df cos| / mean f cos over the pairs whose values were found. */
export function errorOf(found, wanted, pairs) {
  let [difference, total] = [0, 0];
  for (let k = 0; k < found.length; k++) {
    const cosine = pairs[8 * Math.floor(k / 3) + 2];
    difference += Math.abs(found[k] - wanted[k]) * cosine;
    total += wanted[k] * cosine;
  }
  return difference / (total > 0 ? total : 1);
}

/**
 * The first pairs to draw, with the material's f cos of each: what a pixel of a plane shows of a
 * light of irradiance 1 at normal incidence. The eye's cosine is at least `cosine`: below it, the
 * place in a pixel is uncertain.
 */
export function drawnPairs({ pairs, f, count = 256, cosine = 0.05 }) {
  const places = Array.from({ length: pairs.length / 8 }, (_, k) => k)
    .filter((k) => pairs[8 * k + 5] > cosine).slice(0, count);
  return {
    drawable: places.flatMap((k) => pairs.slice(8 * k, 8 * k + 8)),
    reflected: places.flatMap((k) => [0, 1, 2].map((channel) => f[3 * k + channel] * pairs[8 * k + 2])),
  };
}

/** Mean |d| / mean of pixels, which hold the cosine already. */
export function errorOfPixels(found, wanted) {
  const flat = new Array(8 * wanted.length / 3).fill(1);
  return errorOf(found, wanted, flat);
}

/**
 * Bound of a material's mean |df cos| / mean f cos: the larger of `error`, and of `ratio` times the
 * change by rounding directions and texture positions to numbers of 32 bits; at most `most`.
 */
export const boundOf = (material, { error, ratio, most = Infinity }) =>
  Math.min(most, Math.max(error, ratio * material.rounding));

const medianOf = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];

/**
 * Runs `measure` on each material, prints a line for each and one for all, and sets the exit code.
 * `measure` returns figures with `value_error` and `passed`.
 */
export async function run(consumer, { cases, refused }, measure) {
  const results = [];
  for (const material of cases) {
    const started = performance.now();
    let result;
    try {
      result = await measure(material);
    } catch (error) {
      result = { value_error: null, passed: false, failure: error.message };
    }
    const seconds = Number(((performance.now() - started) / 1000).toFixed(2));
    results.push({ name: material.name, ...result, seconds });
    console.log(JSON.stringify(results.at(-1)));
  }
  const errors = results.map((it) => it.value_error).filter(Number.isFinite);
  const failed = results.filter((it) => !it.passed).map((it) => it.name);
  console.log(JSON.stringify({
    consumer, materials: results.length, refused, worst_error: Math.max(...errors),
    median_error: medianOf(errors), failed,
  }));
  process.exitCode = failed.length > 0 || results.length === 0 ? 1 : 0;
}
