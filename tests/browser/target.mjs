// Pictures of known scenes as targets: shown as they are understood before anything starts, searched for, and looked at beside what was
// found and what is bred. The pictures are of a target that was measured, drawn by the server.

import { strict as assert } from "node:assert";

const SIDE_PX = 96;

/** The newest measured target, as it looks in the open lineage's scene. */
async function photograph(hand, base, name, light = "") {
  const generation = await hand.generation(await hand.ready());
  const { scene } = await hand.api(`/v1/lineages/${generation.lineage}`);
  const target = (await hand.api("/v1/targets")).items.find(({ kind }) => kind === "samples");
  const answer = await fetch(`${base}/v1/targets/${target.id}/render.png?size=${SIDE_PX}&scene=${scene}${light}`);
  assert.equal(answer.status, 200, `${answer.url}: ${answer.status}`);
  return { name, mimeType: "image/png", buffer: Buffer.from(await answer.arrayBuffer()) };
}

/** The scene of the open lineage, as a person would paste it. */
async function sceneText(hand) {
  const generation = await hand.generation(await hand.ready());
  const { scene } = await hand.api(`/v1/lineages/${generation.lineage}`);
  const { id: _, ...json } = await hand.api(`/v1/scenes/${scene}`);
  return JSON.stringify(json, null, 1);
}

/** Waits until all pictures of a part of the page are there. */
const drawn = (page, id, least) =>
  page.waitForFunction(([name, count]) => {
    const images = [...document.querySelectorAll(`[data-testid=${name}] img`)];
    return images.length >= count && images.every((image) => image.complete && image.naturalWidth > 0);
  }, [id, least]);

/** How much of the upper picture is seen, in percent. */
const seen = async (hand, pair) => Number(await hand.id(pair).locator("[data-seen]").getAttribute("data-seen"));

/** Opens the form of a new search. */
async function openForm(hand) {
  await hand.page.keyboard.press("s");
  await hand.id("searches-dialog").waitFor();
  await hand.id("searches-dialog").getByRole("button", { name: "New search" }).first().click();
  await hand.id("target-file").waitFor({ state: "attached" });
}

/** The journey; `shot` takes a picture of the page. It comes after a search for something measured. */
export async function target(hand, step, shot, base) {
  const { page } = hand;
  hand.ignores = (text) => text.includes("422");
  const own = (at) => hand.id(`view-${at}-from`).getByRole("radio", { name: "its own" });

  await step("stops an upload, and keeps what was chosen", async () => {
    await hand.ready();
    await openForm(hand);
    await page.route("**/v1/targets", (route) => (route.request().method() === "POST" ? undefined : route.continue()));
    await hand.id("target-file").setInputFiles({ name: "slow.csv", mimeType: "text/csv", buffer: Buffer.alloc(4096, 48) });
    await hand.id("target-sending").getByRole("progressbar").waitFor();
    await shot("61-target-sending");
    await hand.accessible("an upload");
    await hand.id("target-stop").click();
    await hand.id("target-sending").waitFor({ state: "detached" });
    assert.equal(await page.locator("[data-testid=error][data-place=target]").count(), 0);
    await page.getByText("slow.csv").waitFor();
    await page.unroute("**/v1/targets");
  });

  await step("takes a picture of the open lineage's scene, and shows what it is taken for before anything starts", async () => {
    const { length } = (await hand.api("/v1/jobs")).items;
    await hand.id("target-file").setInputFiles(await photograph(hand, base, "lobe.png"));
    assert.ok(await hand.id("view-0-from").getByRole("radio", { name: "the lineage's" }).isChecked());
    assert.ok(await hand.id("search-start").isDisabled(), "nothing was read yet");
    await hand.id("views-read").click();
    await hand.id("target-understood").waitFor();
    await drawn(page, "target-understood", 4);
    const fates = await hand.id("understood-fates").innerText();
    assert.match(fates, /used[\s\S]*background/);
    assert.equal((await hand.api("/v1/jobs")).items.length, length);
    await page.keyboard.press("x");
    assert.equal(await seen(hand, "understood"), 100);
    await page.keyboard.press("x");
    await hand.id("understood-flip").click();
    assert.equal(await seen(hand, "understood"), 100);
    await hand.id("understood-flip").press("Enter");
    assert.equal(await seen(hand, "understood"), 0);
    await hand.id("understood-blend").fill("50");
    assert.equal(await seen(hand, "understood"), 50);
    await shot("62-target-understood");
    await hand.accessible("a picture as understood");
  });

  await step("does not offer it any more once it is said to be something else", async () => {
    const before = await hand.api("/v1/targets");
    const removed = page.waitForResponse((it) => it.request().method() === "DELETE");
    await hand.id("target-kind").selectOption("samples");
    assert.equal((await removed).status(), 204);
    await page.locator("[data-testid=error][data-place=target]").waitFor();
    assert.ok(await hand.id("search-start").isDisabled());
    await page.waitForFunction((count) => document.querySelectorAll(".known li").length === count, before.items.length - 1);
    assert.equal((await hand.api("/v1/targets")).items.length, before.items.length - 1);
    await hand.id("target-kind").selectOption("image");
  });

  await step("says at its field what is wrong with a scene, and keeps the text", async () => {
    await own(0).check();
    const wrong = '{"mesh": "sphere", "lights": [{"kind": "ambient"}]}';
    await hand.id("view-0-scene").fill(wrong);
    await hand.id("views-read").click();
    const error = page.locator("#view-0-wrong [data-testid=error]");
    await error.filter({ hasText: "ambient" }).waitFor();
    assert.equal(await hand.id("view-0-scene").inputValue(), wrong);
    assert.equal(await hand.id("view-0-scene").getAttribute("aria-invalid"), "true");
    await shot("63-target-scene-refused");
    await hand.accessible("a scene that was refused");
    await hand.id("view-0-scene").fill("{");
    await hand.id("views-read").click();
    await error.filter({ hasText: "no JSON" }).waitFor();
  });

  const job = await step("takes a second picture under another light, held out, and searches", async () => {
    await hand.id("view-0-scene").fill(await sceneText(hand));
    await hand.id("views-add").setInputFiles(await photograph(hand, base, "a second picture of the same lobe, under a light from another side.png", "&light_deg=75"));
    await hand.id("view-1-light").fill("75");
    await hand.id("view-1-held").check();
    await hand.id("views-read").click();
    await hand.id("target-understood").waitFor();
    await hand.id("understood-views").getByRole("radio", { name: "2 held out" }).check();
    await drawn(page, "target-understood", 4);
    await hand.id("search-strategy").selectOption("lobes");
    await page.getByRole("radio", { name: "evaluations" }).check();
    await hand.id("search-budget").fill("300");
    await hand.id("search-start").click();
    await hand.id("job-state").filter({ hasText: "done" }).waitFor();
    const found = await hand.api(`/v1/jobs/${/search\/([^/]+)$/.exec(page.url())[1]}`);
    assert.deepEqual(found.budget, { evaluations: 300 });
    return found;
  });

  await step("shows the picture over the find, the one that was held out, and the find under another light", async () => {
    await drawn(page, "found-pair", 3);
    const rows = hand.id("found-views").locator("tbody tr");
    assert.equal(await rows.count(), 2);
    const [, rmse, flip] = await rows.first().getByRole("cell").allInnerTexts();
    assert.ok(Number(rmse) > 0 && Number(flip) > 0 && Number(flip) < 1, `RMSE ${rmse}, FLIP ${flip}`);
    await page.keyboard.press("x");
    assert.equal(await seen(hand, "found-pair"), 100);
    await page.keyboard.press("x");
    await shot("64-target-found");
    await hand.accessible("a find beside its picture");
    await hand.id("found-view-1").click();
    await hand.id("found-pair").locator("img[src*='view=1']").first().waitFor();
    await shot("65-target-held-out");
    await hand.id("found-light").fill("200");
    await hand.id("found-light").blur();
    await hand.id("found-alone").waitFor();
    await hand.id("found-picture").locator("img[src*='light_deg=200']").waitFor();
    await shot("66-target-another-light");
    await hand.id("found-light-rest").click();
    await hand.id("found-pair").waitFor();
  });

  await step("shows the target in the place of the centre while breeding on", async () => {
    const before = await hand.ready();
    await hand.id("found-breed").click();
    await hand.id("searches-dialog").waitFor({ state: "detached" });
    await hand.ready(before);
    await hand.id("target-here").waitFor();
    await hand.id("centre").focus();
    await page.keyboard.press("t");
    const name = () => hand.id("centre").getAttribute("aria-label");
    assert.match(await name(), /the target is shown in its place/);
    await drawn(page, "target-in-centre", 1);
    await drawn(page, "sought-sides", 2);
    await shot("67-target-in-centre");
    await hand.accessible("the target in the centre");
    const { generations } = await hand.api(`/v1/lineages/${job.lineage}`);
    // A click on the target only puts the centre back.
    await hand.id("centre").click();
    assert.doesNotMatch(await name(), /the target/);
    assert.equal((await hand.api(`/v1/lineages/${job.lineage}`)).generations, generations);
    await hand.id("target-here").click();
    await page.keyboard.press("Escape");
    assert.doesNotMatch(await name(), /the target/);
    await hand.id("target-view").selectOption("1");
    await hand.id("sought-sides").locator("img[src*='view=1']").first().waitFor();
    const wanted = (await hand.api(`/v1/targets/${job.target}`)).views[1].scene;
    const scene = await hand.reshown(() => hand.id("target-scene").click());
    assert.equal(scene.light_deg, wanted.light_deg);
    await hand.id("target-scene").waitFor({ state: "detached" });
  });
  hand.quiet();
}

/** The same by finger on a small screen. */
export async function targetByFinger(hand, step, shot, base) {
  const { page } = hand;
  const sideways = () => hand.id("searches-dialog").evaluate((it) => it.scrollWidth - it.clientWidth);

  await step("shows a picture as understood on a screen of 360 pixels", async () => {
    await hand.id("searches").tap();
    await hand.id("searches-dialog").getByRole("button", { name: "New search" }).first().tap();
    await hand.id("target-file").setInputFiles(await photograph(hand, base, "a picture with a name that does not fit into three hundred and sixty pixels.png"));
    assert.ok((await sideways()) <= 0, "nothing sticks out sideways");
    await shot("68-narrow-target");
    await hand.id("views-read").tap();
    await hand.id("target-understood").waitFor();
    await drawn(page, "target-understood", 4);
    await hand.id("understood-flip").tap();
    assert.equal(await seen(hand, "understood"), 100);
    assert.ok((await sideways()) <= 0, "nothing sticks out sideways");
    await shot("69-narrow-target-understood");
    await hand.accessible("360 x 740, a picture as understood");
    await hand.id("searches-close").tap();
    await hand.id("searches-dialog").waitFor({ state: "detached" });
  });
}
