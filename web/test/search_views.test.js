/** Pictures of known scenes: uploads, refusals, statuses of pixels. */
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  PIXEL_STATUSES, UNCERTAINTIES, buildUpload, correctionInWords, isDoubtful, isPicture, nameOfView, newPicture,
  pixelStatuses, pointedView, uncertaintyOf,
  readScene, share, stem,
} from "../search/views.js";

/** @param {string} name */
const file = (name) => /** @type {any} */ ({ name, size: 10 });
const OPEN = /** @type {any} */ ({
  id: "s-1",
  scene: { id: "s-1", mesh: "knob", light_deg: 0, film: { exposure: "auto" } },
});
/** @param {any} change @param {string} [name] */
const picture = (change, name = "knob.png") => ({
  ...newPicture(file(name), undefined, true),
  ...change,
});
/** @param {any[]} views @param {any} [open] */
const asked = (views, open = OPEN) => /** @type {any} */ (buildUpload(views, open));

test("one picture has the open lineage's scene and no unset fields", () => {
  const { spec, parts } = asked([picture({})]);
  assert.deepEqual(spec, {
    kind: "image",
    name: "knob",
    views: [{ picture: "picture-0", scene: "s-1", samples: "adaptive" }],
  });
  assert.deepEqual(Object.keys(parts), ["picture-0"]);
});

test("a picture without an open lineage has no scene field", () => {
  assert.equal(newPicture(file("a.png"), undefined, false).from, "default");
  assert.deepEqual(asked([picture({ from: "default" })], null).spec.views, [
    { picture: "picture-0", samples: "adaptive" },
  ]);
  assert.deepEqual(asked([picture({ from: "default", light: " 120° " })]).spec.views[0].scene, {
    light_deg: 120,
  });
});

test("a light angle is set in the full scene without its id", () => {
  assert.deepEqual(asked([picture({ light: "-30,5" })]).spec.views[0].scene, {
    mesh: "knob",
    light_deg: -30.5,
    film: { exposure: "auto" },
  });
  assert.deepEqual(
    asked([picture({ from: "given", text: '{"id": "x", "mesh": "cube"}', light: "10" })]).spec
      .views[0].scene,
    { mesh: "cube", light_deg: 10 },
  );
});

test("several pictures have parts of their own and all their settings", () => {
  const { spec, parts } = asked([
    picture({ mask: file("mask.png"), samples: "64" }),
    picture(
      {
        from: "given",
        text: "00000000-0000-7000-8000-000000000001",
        gain: true,
        held_out: true,
        samples: "adaptive",
      },
      "other.exr",
    ),
  ]);
  assert.deepEqual(spec.views, [
    { picture: "picture-0", mask: "mask-0", scene: "s-1", samples: 64 },
    {
      picture: "picture-1",
      scene: "00000000-0000-7000-8000-000000000001",
      samples: "adaptive",
      gain: true,
      held_out: true,
    },
  ]);
  assert.deepEqual(
    Object.entries(parts).map(([name, part]) => [name, part.name]),
    [
      ["picture-0", "knob.png"],
      ["mask-0", "mask.png"],
      ["picture-1", "other.exr"],
    ],
  );
});

test("a new picture copies the shared settings of the one before", () => {
  const before = picture({
    from: "given",
    text: "{}",
    samples: "16",
    gain: true,
    mask: file("m.png"),
    held_out: true,
  });
  const next = newPicture(file("b.png"), before, true);
  assert.deepEqual(
    [next.from, next.text, next.samples, next.gain, next.mask, next.held_out],
    ["given", "{}", "16", true, null, false],
  );
  assert.notEqual(next.key, before.key);
});

test("an invalid upload names the picture and the field", () => {
  for (const [views, at, field] of /** @type {[any[], number|null, string][]} */ ([
    [[], null, "picture"],
    [[picture({ held_out: true })], 0, "held_out"],
    [[picture({}), picture({ from: "given", text: "{mesh" })], 1, "scene"],
    [[picture({ from: "given", text: "" })], 0, "scene"],
    [[picture({ from: "given", text: "[1]" })], 0, "scene"],
    [[picture({ light: "left" })], 0, "light"],
    [
      [picture({ from: "given", text: "00000000-0000-7000-8000-000000000001", light: "5" })],
      0,
      "light",
    ],
  ])) {
    const { view, field: named, wrong } = asked(views);
    assert.deepEqual([view, named], [at, field], wrong);
  }
  assert.equal(asked([picture({})], null).field, "scene");
});

test("a scene is an object or an id", () => {
  assert.deepEqual(readScene(' {"mesh": "cube"} '), { scene: { mesh: "cube" } });
  assert.match(/** @type {any} */ (readScene("{'mesh'}")).wrong, /not valid JSON/);
});

test("pointedView finds the picture and the field of a refusal", () => {
  for (const [pointer, found] of /** @type {[any, any][]} */ ([
    ["/views/1/scene/lights/0/kind", { view: 1, field: "scene" }],
    ["/views/0/mask", { view: 0, field: "mask" }],
    ["/views/2", { view: 2, field: "picture" }],
    ["/views/0/picture", { view: 0, field: "picture" }],
    ["/scene/mesh", { view: 0, field: "scene" }],
    ["/file", { view: 0, field: "picture" }],
    ["/name", null],
    ["/views", null],
    [undefined, null],
    [null, null],
  ]))
    assert.deepEqual(pointedView(pointer), found, String(pointer));
});

test("pixelStatuses lists statuses that occur, in a fixed order", () => {
  const counts = /** @type {any} */ ({
    pixels: 100,
    used: 60,
    masked: 0,
    background: 39,
    edge: 1,
    clipped: 0,
    unlit: 0,
    half_lit: 0,
    several_lights: 0,
    grazing: 0,
    outlier: 0,
  });
  assert.deepEqual(
    pixelStatuses(counts).map(({ name, color, count }) => [name, color, count]),
    [
      ["used", "#4caf50", 60],
      ["background", "#30363d", 39],
      ["at edges", "#ffb300", 1],
    ],
  );
  assert.equal(new Set(PIXEL_STATUSES.map(({ color }) => color)).size, 10);
  assert.deepEqual(
    [
      share(60, 100),
      share(1, 1000000),
      share(999999, 1000000),
      share(0, 5),
      share(5, 5),
      share(1, 30),
    ],
    ["60 %", "< 0.1 %", "> 99.9 %", "0 %", "100 %", "3.3 %"],
  );
});

test("pictures are recognised by name and numbered", () => {
  assert.deepEqual(["a.PNG", "b.exr", "c.hdr", "d.jpeg", "e.csv"].map(isPicture), [
    true,
    true,
    true,
    true,
    false,
  ]);
  assert.deepEqual(
    [stem("a.b.png"), stem("x"), stem(`${"ä".repeat(300)}.exr`).length],
    ["a.b", "x", 200],
  );
  assert.equal(nameOfView([{ held_out: false }], 0), "the picture");
  assert.equal(nameOfView([{ held_out: false }, { held_out: true }], 1), "picture 2, held out");
});

test("uncertainties of a scene are sent, copied to the next picture and named", () => {
  const roughly = UNCERTAINTIES.find(({ value }) => value === "roughly");
  assert.ok(roughly);
  const first = { ...newPicture(file("a.png"), undefined, false), refine: roughly.refine };
  const both = [first, newPicture(file("b.png"), first, false)];
  const upload = buildUpload(both, null);
  assert.ok("spec" in upload);
  const said = /** @type {Record<string, unknown>[]} */ (upload.spec.views);
  assert.deepEqual(said.map(({ refine }) => refine), [roughly.refine, roughly.refine]);
  assert.equal(uncertaintyOf(roughly.refine), roughly);
  assert.equal(uncertaintyOf(undefined)?.value, "exact");
  assert.equal(uncertaintyOf({ light_deg: 1.5 }), null);
  const exact = buildUpload([newPicture(file("a.png"), undefined, false)], null);
  assert.ok("spec" in exact && !JSON.stringify(exact.spec).includes("refine"));
  assert.equal(correctionInWords("lights/1/up_deg"), "light 2 upwards, degrees");
  assert.equal(correctionInWords("camera/fov"), "camera field of view, factor");
  assert.equal(correctionInWords("gain/red"), "brightness of red, factor");
  const doubtful = (name, value) => isDoubtful({ name, value, stated_deviation: 0.1 });
  assert.ok(doubtful("camera/roll_deg", -0.3) && !doubtful("camera/roll_deg", 0.1));
  assert.ok(doubtful("camera/distance", 0.7) && !doubtful("camera/distance", 1.1));
});
