// Page object of the journeys: elements, waiting for pictures, and the API.

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";

const axeFile = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

/** Path of the page in modules. */
export const MODULES = "/web/index.html";

/** Milliseconds within which the screen shows what was asked for, on a slow machine. */
const SETTLES_MS = 60_000;

/**
 * True for the address of a picture. On a slow machine one may take longer than the server waits;
 * the page then asks again after the time that the answer names.
 */
const isPicture = (url) => /\.(a?png|webp)$/.test(new URL(url, "http://localhost").pathname);

/** One open page. Waits for states and never for a time. */
export class BroodPage {
  #base;
  /** Errors of scripts, of the content security policy and of requests; all are failures. */
  complaints = [];
  /**
   * Path of the page: `/` loads one script, MODULES each module by itself, so that a test can
   * import the page's own.
   */
  path = "/";
  /** True for console messages that are expected. */
  ignores = () => false;

  constructor(page, base) {
    this.page = page;
    this.#base = base;
    this.seeded = this.#seedBroods();
    page.on("pageerror", (error) => this.complaints.push(`script: ${error.message}`));
    page.on("console", (message) => {
      const text = message.text();
      const isLate = text.includes(" 503 ") && isPicture(message.location().url);
      if (message.type() === "error" && !isLate && !this.ignores(text))
        this.complaints.push(`console: ${text}`);
    });
    page.on("response", (response) => {
      const [status, url] = [response.status(), response.url()];
      const isLate = status === 503 && isPicture(url) && "retry-after" in response.headers();
      if (status >= 500 && !isLate) this.complaints.push(`${status} for ${url}`);
    });
  }

  /**
   * Numbers the seeds of the broods that the page breeds, so that each run of a journey sees the
   * same materials. An attempt that is repeated keeps its seed.
   */
  async #seedBroods() {
    const seeds = new Map();
    await this.page.route("**/v1/lineages/*/generations", async (route) => {
      const request = route.request();
      if (request.method() !== "POST") return route.fallback();
      const key = request.headers()["idempotency-key"];
      if (!seeds.has(key)) seeds.set(key, seeds.size + 1);
      await route.fallback({ postData: { seed: seeds.get(key), ...request.postDataJSON() } });
    });
  }

  id(name) {
    return this.page.getByTestId(name);
  }

  cell(slot) {
    return this.id(`cell-${slot}`);
  }

  /** Waits until the pictures of a part of the page are loaded: at least `least`. */
  drawn(id, least) {
    return this.page.waitForFunction(
      ([name, count]) => {
        const images = [...document.querySelectorAll(`[data-testid=${name}] img`)];
        return (
          images.length >= count &&
          images.every((image) => image.complete && image.naturalWidth > 0)
        );
      },
      [id, least],
    );
  }

  /** Asserts that nothing in an element sticks out sideways. */
  async fits(element) {
    const sideways = await element.evaluate((it) => it.scrollWidth - it.clientWidth);
    assert.ok(sideways <= 0, "nothing sticks out sideways");
  }

  /** Opens the page; on an empty server it creates a believable lineage. */
  async open(hash = "") {
    await this.seeded;
    await this.page.goto(this.#base + this.path + hash);
    return this.ready();
  }

  /**
   * Waits until all pictures of a generation other than the given one are loaded; returns its id.
   */
  async ready(previous = "") {
    const not = previous ? `:not([data-ready="${previous}"])` : "";
    const body = this.page.locator(`body[data-ready]:not([data-ready=""])${not}`);
    await body.waitFor({ state: "attached" });
    return body.getAttribute("data-ready");
  }

  /** Waits until a generation is shown with all its pictures. */
  async shows(generation) {
    await this.page.locator(`body[data-ready="${generation}"]`).waitFor({ state: "attached" });
  }

  /** Runs an action that leads to another generation; returns its id. */
  async becomes(act) {
    const before = await this.ready();
    await act();
    return this.ready(before);
  }

  /**
   * Runs an action that changes the lineage's scene; returns the scene once its pictures are shown.
   */
  async reshown(act) {
    const src = () => this.cell(0).locator("img").first().getAttribute("src");
    const before = await src();
    const patched = this.page.waitForResponse((it) => it.request().method() === "PATCH");
    await act();
    const answer = await patched;
    assert.equal(answer.status(), 200);
    await this.cell(0).locator(`img:not([src="${before}"])`).first().waitFor();
    await this.ready();
    return this.api(`/v1/scenes/${(await answer.json()).scene}`);
  }

  /** Reads JSON from the API, independently of the page. */
  async api(path) {
    const response = await fetch(this.#base + path);
    assert.equal(response.status, 200, `${path}: ${response.status}`);
    return response.json();
  }

  /**
   * Reads until the value is right: what is on the screen may lag behind what was asked for. Fails
   * with `wrong(value)` if it does not become so.
   */
  async comesTo(read, isRight, wrong) {
    const end = performance.now() + SETTLES_MS;
    for (;;) {
      const value = await read();
      if (isRight(value)) return value;
      assert.ok(performance.now() < end, wrong(value));
      await this.page.waitForTimeout(100);
    }
  }

  generation(id) {
    return this.api(`/v1/generations/${id}`);
  }

  /** Asserts that the accessibility checker finds nothing. */
  async accessible(where) {
    await this.page.evaluate(await readFile(axeFile, "utf8"));
    const found = await this.page.evaluate(async () => (await globalThis.axe.run()).violations);
    const shown = found.map(
      (it) => `${it.id}: ${it.help} (${it.nodes.map((node) => node.target).join(" | ")})`,
    );
    assert.deepEqual(shown, [], `axe, ${where}`);
  }

  quiet() {
    assert.deepEqual(this.complaints, [], "the page complained");
  }
}
