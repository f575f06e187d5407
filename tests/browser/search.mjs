// Searches: from a file of samples to a find that is bred on; bad files, pause, resume and cancel.

import { strict as assert } from "node:assert";

/**
 * Samples of a diffuse body with two lobes around the half vector, with noise of a few percent as measurements have it: what is known
 * exactly has a front of one.
 */
function samples(count) {
  let state = 7;
  const draw = () => (state = (state * 1103515245 + 12345) % 2147483648) / 2147483648;
  const direction = () => {
    const [z, turn] = [0.15 + 0.8 * draw(), 2 * Math.PI * draw()];
    return [Math.sqrt(1 - z * z) * Math.cos(turn), Math.sqrt(1 - z * z) * Math.sin(turn), z];
  };
  const rows = Array.from({ length: count }, () => {
    const [wi, wo] = [direction(), direction()];
    const half = wi.map((value, at) => value + wo[at]);
    const cos = half[2] / Math.hypot(...half);
    const values = [0.3, 0.2, 0.1].map((albedo) => (albedo / Math.PI + 0.4 * cos ** 120 + 0.2 * cos ** 8) * (0.975 + 0.05 * draw()));
    return [...wi, ...wo, ...values].join();
  });
  return ["wix,wiy,wiz,wox,woy,woz,r,g,b", ...rows].join("\n");
}

const GENERATIONS = 3;

const file = (name, text) => ({ name, mimeType: "text/csv", buffer: Buffer.from(text) });
const GOOD = file("lobe.csv", samples(600));
const BAD = file("bad.csv", samples(600).replace(/[^\n]*$/, "0,0,1,0,0,1,nan,1,1"));

/** Waits for a state of the search that is looked at. */
const stands = (hand, words) => hand.id("job-state").filter({ hasText: words }).waitFor();

/** The search that the address names. */
const present = (hand) => hand.api(`/v1/jobs/${/search\/([^/]+)$/.exec(hand.page.url())[1]}`);

/** Fills the form in as far as it has to be, and starts. */
async function start(hand, generations) {
  await hand.page.getByRole("radio", { name: "generations" }).check();
  await hand.id("search-budget").fill(String(generations));
  await hand.id("search-start").click();
  await hand.id("job-state").waitFor();
}

/** The journey; `shot` takes a picture of the page. */
export async function search(hand, step, shot, base) {
  const { page } = hand;
  const dialog = hand.id("searches-dialog");
  hand.ignores = (text) => text.includes("422");

  await step("finds the searches by key, and is told what a search is", async () => {
    await hand.open();
    await page.keyboard.press("s");
    await dialog.waitFor();
    await page.getByText("A search lets the machine breed").waitFor();
    await shot("50-searches-none");
    await hand.accessible("no searches");
    await dialog.getByRole("button", { name: "New search" }).first().click();
    await hand.id("target-file").waitFor({ state: "attached" });
    assert.equal(await page.evaluate(() => document.activeElement?.id), "searches-title");
    assert.ok(await hand.id("search-start").isDisabled(), "there is nothing to match yet");
  });

  await step("says what is wrong with a bad file, and keeps what was filled in", async () => {
    await hand.id("search-seed").fill("7");
    await hand.id("target-file").setInputFiles(BAD);
    const error = page.locator("[data-testid=error][data-place=target]");
    await error.filter({ hasText: "row 600" }).waitFor();
    assert.equal(await hand.id("search-seed").inputValue(), "7");
    assert.ok(await hand.id("search-start").isDisabled());
    await shot("51-search-bad-file");
    await hand.id("target-file").setInputFiles(file("unnamed.dat", samples(600)));
    await hand.id("target-kind").selectOption("samples");
    await hand.id("target-understood").waitFor();
    assert.equal(await error.count(), 0);
  });

  await step("shows what was understood before anything starts", async () => {
    await hand.id("target-file").setInputFiles(GOOD);
    const understood = hand.id("target-understood");
    await understood.waitFor();
    await page.getByText("lobe.csv").waitFor();
    const words = await understood.innerText();
    const [fitted, held] = [/fitted to\s+(\d+)/, /held out\s+(\d+)/].map((pattern) => Number(pattern.exec(words)?.[1]));
    assert.ok(fitted + held === 600 && held > 0, words);
    assert.equal((await hand.api("/v1/jobs")).items.length, 0);
    await shot("52-search-understood");
    await hand.accessible("a new search");
  });

  await step("says which number is wrong", async () => {
    await hand.id("search-budget").fill("soon");
    await hand.id("search-start").click();
    await page.locator("[data-testid=error][data-place=search]").waitFor();
    assert.equal(await hand.id("search-budget").getAttribute("aria-invalid"), "true");
  });

  const job = await step("searches, and shows how", async () => {
    await hand.id("search-strategy").selectOption("lobes");
    await start(hand, GENERATIONS);
    // A curve without a rise has no height and counts as hidden, so its chart is to be visible, and it to have a stroke.
    await hand.id("search-course").locator("svg[role=img]").first().waitFor();
    const curve = hand.id("search-course").locator("svg[role=img] > path.curve").first();
    await curve.waitFor({ state: "attached" });
    const drawn = await curve.evaluate((path) => {
      const { visibility, display, stroke, opacity } = getComputedStyle(path);
      return visibility === "visible" && display !== "none" && stroke !== "none" && opacity !== "0";
    });
    assert.ok(drawn, "the curve is drawn");
    await hand.id("found-picture").locator("img").first().waitFor();
    await shot("53-search-running");
    await stands(hand, "done");
    const ended = await present(hand);
    assert.equal(ended.state, "succeeded");
    assert.equal(String(ended.seed), "7");
    assert.equal(ended.strategy, "lobes");
    assert.equal(ended.generation, GENERATIONS);
    assert.match(await hand.id("job-figures").innerText(), new RegExp(`100 % of ${GENERATIONS} generations`));
    return ended;
  });

  const { items: front } = await hand.api(`/v1/jobs/${job.id}/front`);
  const shortest = [...front].sort((a, b) => a.operations - b.operations || a.e_log - b.e_log)[0];

  await step("goes along the front by key, and looks at a find under another light", async () => {
    assert.ok(front.length > 1, "there is more than one find");
    const points = page.getByRole("radiogroup", { name: /^Front/ }).getByRole("radio");
    await points.first().waitFor();
    assert.equal(await points.count(), front.length);
    await points.and(page.getByRole("radio", { checked: true })).focus();
    await page.keyboard.press("Home");
    assert.equal(await page.evaluate(() => document.activeElement?.getAttribute("aria-checked")), "true");
    await page.getByTestId("found-picture").locator(`img[src*="${shortest.individual}"]`).waitFor();
    await hand.id("found-light").fill("90");
    await hand.id("found-light").blur();
    await page.getByTestId("found-picture").locator("img[src*='light_deg=90']").first().waitFor();
    await shot("54-search-front");
    await hand.accessible("a search that is done");
    await hand.id("found-light-rest").click();
    await hand.id("front-table").locator("tbody button").first().click();
    await page.getByTestId("found-picture").locator(`img[src*="${front[0].individual}"]`).waitFor();
  });

  await step("shows the target beside the find at the same light, and over it", async () => {
    const pair = hand.id("found-pair");
    const sources = await pair.locator("img").evaluateAll((images) => images.map((image) => image.getAttribute("src")));
    const [beside, find, over] = sources.map((source) => new URL(source, base));
    assert.equal(beside.href, over.href);
    assert.ok(beside.pathname.includes(job.target) && find.pathname.includes(front[0].individual), sources.join());
    assert.deepEqual(["scene", "size", "light_deg"].map((name) => beside.searchParams.get(name)), ["scene", "size", "light_deg"].map((name) => find.searchParams.get(name)));
    const seen = () => pair.locator("[data-seen]").getAttribute("data-seen");
    await page.keyboard.down("x");
    assert.equal(await seen(), "100");
    await page.keyboard.up("x");
    await hand.id("found-pair-flip").click();
    assert.equal(await seen(), "0");
    await hand.id("found-pair-blend").fill("40");
    assert.equal(await seen(), "40");
    await hand.accessible("a find and its target");
  });

  await step("restores a search from its link, and lists it", async () => {
    await page.reload();
    await stands(hand, "done");
    await hand.id("front-0").waitFor();
    await hand.id("searches-all").click();
    await hand.id(`job-${job.id}`).filter({ hasText: "done" }).waitFor();
    await shot("55-searches");
    await hand.accessible("the list of searches");
    await hand.id(`job-${job.id}`).click();
    await stands(hand, "done");
    await page.goBack();
    await hand.id(`job-${job.id}`).click();
  });

  await step("looks into a find, and breeds from it", async () => {
    await hand.id("found-inspect").click();
    await hand.id("inspector").getByRole("heading", { name: "Physical checks" }).waitFor();
    await hand.id("inspector-close").click();
    const child = await hand.generation(await hand.becomes(() => hand.id("found-breed").click()));
    // The generation where the find was born is shown first.
    const bred = child.parents[0] === front[0].individual ? child : await hand.generation(await hand.ready(child.id));
    assert.deepEqual(bred.parents, [front[0].individual]);
    assert.equal(bred.lineage, job.lineage);
    assert.equal(bred.individuals.length, 20);
    assert.equal(await dialog.count(), 0);
    await shot("56-search-bred");
  });

  await step("pauses, resumes and cancels a longer one, started from what was bred", async () => {
    await page.getByTestId("search-from").click();
    await hand.id("search-start-clear").waitFor();
    // The target of before is still chosen.
    await hand.id("target-understood").or(hand.id(`target-${job.target}`)).first().waitFor();
    if (await hand.id(`target-${job.target}`).isVisible()) await hand.id(`target-${job.target}`).click();
    await start(hand, 5000);
    await stands(hand, "searching");
    await hand.id("job-pause").click();
    await stands(hand, "paused");
    assert.equal((await present(hand)).state, "paused");
    await hand.id("job-resume").click();
    await stands(hand, /searching|waiting/);
    await hand.id("job-cancel").click();
    await page.getByRole("group", { name: "Cancel the search?" }).waitFor();
    await hand.accessible("whether to cancel a search");
    await hand.id("job-cancel-yes").click();
    await stands(hand, "cancelled");
    const ended = await present(hand);
    assert.equal(ended.state, "cancelled");
    assert.equal(ended.lineage, job.lineage, "its finds are born beside what it started from");
    assert.ok((await hand.id("job-pause").isDisabled()) && (await hand.id("job-cancel").isDisabled()));
    await shot("57-search-cancelled");
    await hand.id("searches-close").click();
    await dialog.waitFor({ state: "detached" });
    assert.ok(!page.url().includes("/search/"));
  });
  hand.quiet();
}

/** The same by finger on a small screen, with the target that is there already. */
export async function searchByFinger(hand, step, shot) {
  const { page } = hand;
  const sideways = () => hand.id("searches-dialog").evaluate((it) => it.scrollWidth - it.clientWidth);

  await step("searches by finger on a screen of 360 pixels", async () => {
    await hand.id("searches").tap();
    await hand.id("searches-dialog").getByRole("button", { name: "New search" }).first().tap();
    await hand.id("target-file").setInputFiles(GOOD);
    await hand.id("target-understood").waitFor();
    assert.ok((await sideways()) <= 0, "nothing sticks out sideways");
    await shot("58-narrow-search-new");
    await hand.accessible("360 x 740, a new search");
    await start(hand, 1);
    await stands(hand, "done");
    await hand.id("found-picture").locator("img").first().waitFor();
    assert.ok((await sideways()) <= 0, "nothing sticks out sideways");
    await shot("59-narrow-search");
    await hand.id("search-front").scrollIntoViewIfNeeded();
    await shot("60-narrow-search-front");
    await hand.accessible("360 x 740, a search");
    await hand.id("searches-close").tap();
    await page.getByTestId("searches-dialog").waitFor({ state: "detached" });
  });
}
