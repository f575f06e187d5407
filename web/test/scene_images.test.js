/** Images of scenes: normal maps of parts, and the picture of the backdrop drawn live. */
import assert from "node:assert/strict";
import { afterEach, test } from "node:test";
import { BackdropPicture, coverOf, fitted } from "../live/backdrop_picture.js";
import { isDrawable } from "../live/camera.js";
import { paintLightsOf } from "../live/paint_lights.js";
import { restingEnvironment, turningEnvironment } from "../live/spheres.js";
import { liveStore } from "../live/store.js";
import { hasNormalMaps, normalMapOf, short, withNormalMap } from "../scene/normal_map.js";

/** @import { Scene } from "../model.js" */

const ID = "ab".repeat(32);
const OTHER = "cd".repeat(32);
const MAP = { image: ID, strength: -0.5, repeat: 100 };
const PARTS = /** @type {const} */ (["subject", "neighbour", "ground"]);

/** @returns {Scene} */
const scene = () => ({
  mesh: "knob",
  rotation_deg: [0, 0, 0],
  scale: 1,
  camera: {},
  film: { exposure: "auto", tone: "none" },
  objects: [{ mesh: "ball", material: "gold" }, { mesh: "cube", normal_map: { image: OTHER } }],
  ground: { material: "moon-dust", height: 2 },
});

test("a part gets a normal map, and keeps all else", () => {
  for (const part of PARTS) {
    const before = scene();
    const after = { ...before, ...withNormalMap(before, part, MAP) };
    assert.deepEqual(before, scene(), "the scene itself is not changed");
    for (const one of PARTS)
      assert.deepEqual(normalMapOf(after, one), one === part ? MAP : null, `${part}: ${one}`);
    const removed = { ...after, ...withNormalMap(after, part, null) };
    assert.deepEqual(JSON.parse(JSON.stringify(removed)), scene(), part);
  }
  const { objects, ground } = withNormalMap(scene(), "neighbour", MAP);
  assert.deepEqual(objects, [{ mesh: "ball", material: "gold", normal_map: MAP }, scene().objects?.[1]]);
  assert.equal(ground, undefined);
});

test("a scene without the part stays as it is", () => {
  const alone = { ...scene(), objects: [], ground: null };
  assert.deepEqual(withNormalMap(alone, "neighbour", MAP), {});
  assert.deepEqual(withNormalMap(alone, "ground", MAP), {});
  for (const part of PARTS) assert.equal(normalMapOf(alone, part), null);
  assert.equal(normalMapOf(null, "subject"), null);
});

test("a scene with a normal map is not drawn live", () => {
  const plain = { ...scene(), objects: [{ mesh: "ball" }] };
  assert.ok(isDrawable(plain) && !hasNormalMaps(plain));
  for (const part of PARTS) {
    const mapped = { ...plain, ...withNormalMap(plain, part, MAP) };
    assert.ok(hasNormalMaps(mapped) && !isDrawable(mapped), part);
  }
  assert.ok(!isDrawable(scene()), "the second object has one");
});

test("a picture behind the object changes no light", () => {
  const lights = [{ kind: /** @type {const} */ ("environment"), image: "studio" }, {}];
  const plain = { ...scene(), objects: [], ground: null, lights };
  const backdrop = /** @type {const} */ ({ kind: "image", image: ID });
  const shown = { ...plain, backdrop };
  assert.ok(isDrawable(shown) && isDrawable({ ...scene(), objects: [], backdrop }));
  assert.equal(restingEnvironment(shown).key, restingEnvironment(plain).key);
  assert.equal(turningEnvironment(shown)?.key, turningEnvironment(plain)?.key);
  const extent = { centre: /** @type {[number, number, number]} */ ([0, 0, 0]), radius: 1 };
  const pose = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], scale: 1 };
  const mean = () => ({ radiance: [1, 1, 1], direction: [0, 1, 0] });
  const under = (/** @type {Scene} */ of) => paintLightsOf(of, extent, pose, 0, mean);
  assert.deepEqual(under(shown), under(plain));
});

test("numbers of controls have at most two decimals", () => {
  assert.deepEqual([1, -0.5, 0.1 + 0.2, 999.999].map(short), ["1", "-0.5", "0.3", "1000"]);
});

test("a picture just covers a square, in its middle", () => {
  assert.deepEqual(coverOf({ width: 300, height: 150 }), [0.5, 1]);
  assert.deepEqual(coverOf({ width: 90, height: 120 }), [1, 0.75]);
  assert.deepEqual(fitted({ width: 4096, height: 1024 }, 2048), { width: 2048, height: 512 });
  assert.deepEqual(fitted({ width: 4096, height: 1 }, 2048), { width: 2048, height: 1 });
  assert.deepEqual(fitted({ width: 20, height: 30 }, 2048), { width: 20, height: 30 });
});

const before = { fetch: globalThis.fetch, createImageBitmap: globalThis.createImageBitmap };
afterEach(() => {
  Object.assign(globalThis, before);
  liveStore.refusedImages.value = new Set();
});

/**
 * A server whose images all have these bytes, and a browser that decodes them to 40 x 20 pixels.
 * @param {BodyInit} bytes
 * @param {number} [status]
 */
function serve(bytes, status = 200) {
  /** @type {string[]} */
  const asked = [];
  globalThis.fetch = async (path) => {
    asked.push(String(path));
    return new Response(bytes, { status });
  };
  globalThis.createImageBitmap = /** @type {any} */ (async () => ({
    width: 40, height: 20, close() {},
  }));
  return asked;
}

/** A context that counts its textures. */
function countingContext() {
  const textures = new Set();
  const gl = /** @type {any} */ ({
    isContextLost: () => false,
    getParameter: () => 4096,
    createTexture() {
      const made = {};
      textures.add(made);
      return made;
    },
    deleteTexture: (/** @type {object} */ made) => textures.delete(made),
  });
  for (const name of ["bindTexture", "texStorage2D", "texSubImage2D", "generateMipmap", "texParameteri"])
    gl[name] = () => {};
  return { gl, textures };
}

/** Waits until a picture reports a change. */
function waiting() {
  let tell = () => {};
  const picture = new BackdropPicture(() => tell());
  const changed = () => new Promise((resolve) => (tell = () => resolve(null)));
  return { picture, changed };
}

/** @param {string} image */
const backdropOf = (image) => /** @type {const} */ ({ kind: "image", image });

test("one picture is loaded once, and dropped when it is no longer shown", async () => {
  const asked = serve("image");
  const { gl, textures } = countingContext();
  const { picture, changed } = waiting();
  assert.ok(picture.prepare(gl, null) && picture.prepare(gl, { kind: "color", color: [1, 1, 1] }));
  let loaded = changed();
  for (const _ of [1, 2]) assert.equal(picture.prepare(gl, backdropOf(ID)), false);
  await loaded;
  for (const _ of [1, 2]) assert.ok(picture.prepare(gl, backdropOf(ID)));
  assert.deepEqual(asked, [`/v1/images/${ID}`]);
  assert.deepEqual(picture.held?.cover, [0.5, 1]);
  loaded = changed();
  assert.equal(picture.prepare(gl, backdropOf(OTHER)), false);
  await loaded;
  assert.ok(picture.prepare(gl, backdropOf(OTHER)));
  assert.equal(textures.size, 1);
  assert.ok(picture.prepare(gl, null));
  assert.deepEqual([textures.size, picture.held], [0, null]);
});

test("a picture is loaded again after the context was lost", async () => {
  const asked = serve("image");
  const { gl } = countingContext();
  const { picture, changed } = waiting();
  for (const _ of [1, 2]) {
    const loaded = changed();
    assert.equal(picture.prepare(gl, backdropOf(ID)), false);
    await loaded;
    assert.ok(picture.prepare(gl, backdropOf(ID)));
    picture.lose();
  }
  assert.equal(asked.length, 2);
});

test("the scene is the server's where the browser would draw another picture", async () => {
  // A JPEG file whose Exif fields say: turned by 90 degrees.
  const head = [0xff, 0xd8, 0xff, 0xe1, 0, 34, 0x45, 0x78, 0x69, 0x66, 0, 0];
  const tiff = [0x4d, 0x4d, 0, 42, 0, 0, 0, 8, 0, 1, 1, 0x12, 0, 3, 0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 0];
  for (const [bytes, status] of /** @type {[BodyInit, number][]} */ ([
    [new Uint8Array([...head, ...tiff]), 200],
    ['{"title": "Not found", "status": 404}', 404],
  ])) {
    serve(bytes, status);
    const { picture, changed } = waiting();
    const loaded = changed();
    picture.prepare(countingContext().gl, backdropOf(ID));
    await loaded;
    assert.equal(picture.held, null);
    assert.deepEqual([...liveStore.refusedImages.value], [ID]);
    liveStore.refusedImages.value = new Set();
  }
});
