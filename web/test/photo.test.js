/** Photographs of balls: placement, light, and the first guesses of both. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { guessCircle } from "../photo/circle_guess.js";
import { readExif } from "../photo/exif.js";
import { angleBetween, lightFrom, spotOf } from "../photo/highlight.js";
import { greyOf, shrunk } from "../photo/pixels.js";
import {
  cameraOf, circleOf, dot, fovOfCrop, fovOfLens, project, surfaceAt, unit,
} from "../photo/placement.js";
import { guessSpot } from "../photo/spot_guess.js";

/** @typedef {import("../model.js").Vec3} Vec3 */

const BALL = { centre: /** @type {Vec3} */ ([0, 0, 0]), radius: 1 };
const OTHER = { centre: /** @type {Vec3} */ ([0.4, -2, 7]), radius: 2.5 };

/** Deterministic numbers from 0 to 1. */
function numbers() {
  let state = 7;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** Random circles within random crops. */
function* settings() {
  const next = numbers();
  for (let k = 0; k < 300; k += 1) {
    const crop = {
      x: Math.floor(400 * next()),
      y: Math.floor(300 * next()),
      width: 200 + Math.floor(500 * next()),
      height: 200 + Math.floor(500 * next()),
    };
    const radius = 20 + 0.3 * next() * Math.min(crop.width, crop.height);
    const circle = {
      x: crop.x + crop.width * (0.1 + 0.8 * next()),
      y: crop.y + crop.height * (0.1 + 0.8 * next()),
      radius,
    };
    yield { crop, circle, fov: 1 + 60 * next(), extent: k % 2 ? BALL : OTHER, next };
  }
}

/** @param {() => number} next @returns {Vec3} */
const direction = (next) => unit([2 * next() - 1, 2 * next() - 1, 2 * next() - 1]);

test("the camera of a circle sees the object in that circle", () => {
  for (const { crop, circle, fov, extent } of settings()) {
    const camera = cameraOf(circle, crop, fov, extent);
    const back = circleOf(camera, crop, extent);
    const off = Math.hypot(back.x - circle.x, back.y - circle.y, back.radius - circle.radius);
    assert.ok(off < 1e-6, `${off} px off: ${JSON.stringify({ crop, circle, fov })}`);
  }
});

test("the outline that the camera sees has the area and the middle of the circle", () => {
  for (const { crop, circle, fov, extent } of settings()) {
    const camera = cameraOf(circle, crop, fov, extent);
    const { centre, radius } = extent;
    // Outline of the sphere: the circle of points at a right angle to the direction to the eye.
    const to = unit(/** @type {Vec3} */ (camera.eye.map((part, at) => part - centre[at])));
    const distance = Math.hypot(...camera.eye.map((part, at) => part - centre[at]));
    const sine = radius / distance;
    const across = unit([to[2], 0, -to[0]]);
    const above = [
      to[1] * across[2] - to[2] * across[1],
      to[2] * across[0] - to[0] * across[2],
      to[0] * across[1] - to[1] * across[0],
    ];
    let [area, x, y] = [0, 0, 0];
    const points = Array.from({ length: 720 }, (_, k) => {
      const turn = (2 * Math.PI * k) / 720;
      const ring = Math.sqrt(1 - sine * sine);
      const world = to.map(
        (part, at) =>
          centre[at] +
          radius *
            (sine * part + ring * (Math.cos(turn) * across[at] + Math.sin(turn) * above[at])),
      );
      const seen = project(/** @type {Vec3} */ (world), camera, crop);
      assert.ok(seen);
      return seen;
    });
    points.forEach((a, k) => {
      const b = points[(k + 1) % points.length];
      const twice = a.x * b.y - b.x * a.y;
      [area, x, y] = [area + twice / 2, x + (a.x + b.x) * twice, y + (a.y + b.y) * twice];
    });
    const middle = [x / (6 * area), y / (6 * area)];
    assert.ok(Math.hypot(middle[0] - circle.x, middle[1] - circle.y) < 1e-3);
    const radiusOf = Math.sqrt(Math.abs(area) / Math.PI);
    assert.ok(Math.abs(radiusOf / circle.radius - 1) < 1e-4, `${radiusOf} ${circle.radius}`);
  }
});

test("a point of the ball is projected to the pixel whose normal it has", () => {
  for (const { crop, circle, fov, extent, next } of settings()) {
    const camera = cameraOf(circle, crop, fov, extent);
    const at = {
      x: circle.x + 0.6 * circle.radius * (2 * next() - 1),
      y: circle.y + 0.6 * circle.radius * (2 * next() - 1),
    };
    const surface = surfaceAt(at, camera, crop, extent);
    assert.ok(surface && dot(surface.normal, surface.eye) > 0);
    const world = surface.normal.map((part, k) => extent.centre[k] + extent.radius * part);
    const seen = project(/** @type {Vec3} */ (world), camera, crop);
    assert.ok(seen && Math.hypot(seen.x - at.x, seen.y - at.y) < 1e-6);
  }
  const whole = { x: 0, y: 0, width: 100, height: 80 };
  const camera = cameraOf({ x: 30, y: 40, radius: 20 }, whole, 30, BALL);
  assert.equal(surfaceAt({ x: 80, y: 40 }, camera, whole, BALL), null);
  assert.equal(project([0, 0, 100], camera, whole), null);
});

test("light and spot are inverse, on glossy and on matt balls", () => {
  let seen = 0;
  for (const { crop, circle, fov, extent, next } of settings()) {
    const camera = cameraOf(circle, crop, fov, extent);
    const light = direction(next);
    for (const surface of /** @type {const} */ (["glossy", "matt"])) {
      const spot = spotOf(light, surface, camera, crop, extent);
      if (!spot) continue;
      seen += 1;
      const back = lightFrom(surfaceAt(spot, camera, crop, extent), surface);
      assert.ok(back && angleBetween(light, back) < 1e-4, `${back} for ${light}`);
    }
  }
  assert.ok(seen > 400, `${seen}`);
});

test("the field of view follows from the lens, and that of a crop from its height", () => {
  // 26 mm: 69.4 degrees along 36 mm and 49.6 degrees along 24 mm.
  assert.ok(Math.abs(fovOfLens({ width: 3000, height: 2000 }, 26) - 49.6) < 0.1);
  assert.ok(Math.abs(fovOfLens({ width: 2000, height: 3000 }, 26) - 69.4) < 0.1);
  const half = fovOfCrop(60, 100, { x: 0, y: 25, width: 80, height: 50 });
  assert.ok(Math.abs(Math.tan((half * Math.PI) / 360) * 2 - Math.tan(Math.PI / 6)) < 1e-12);
});

const encode = (/** @type {number} */ v) =>
  Math.round(255 * Math.min(1, v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));

/**
 * Draws a ball under a light, antialiased by four rays a pixel.
 * @param {{width: number, height: number, circle: import("../photo/placement.js").Circle, fov:
 *   number, light: Vec3, gloss: number, body: number, behind: (x: number, y: number) => number,
 *   noise?: number}} of
 */
function drawn({ width, height, circle, fov, light, gloss, body, behind, noise = 0 }) {
  const whole = { x: 0, y: 0, width, height };
  const camera = cameraOf(circle, whole, fov, BALL);
  const next = numbers();
  const data = new Uint8ClampedArray(4 * width * height);
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      let sum = 0;
      for (const [dx, dy] of [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]]) {
        const surface = surfaceAt({ x: x + dx, y: y + dy }, camera, whole, BALL);
        if (!surface) {
          sum += behind(x, y);
          continue;
        }
        const { normal, eye } = surface;
        const cosine = Math.max(0, dot(normal, light));
        const twice = 2 * dot(normal, eye);
        const mirrored = dot(
          /** @type {Vec3} */ (normal.map((part, k) => twice * part - eye[k])),
          light,
        );
        sum += body * cosine + (cosine > 0 ? gloss * Math.max(0, mirrored) ** 60 : 0);
      }
      const code = encode(sum / 4 + noise * (next() - 0.5));
      data.set([code, code, code, 255], 4 * (y * width + x));
    }
  }
  return { codes: { width, height, data }, camera, whole };
}

const SHOTS = [
  { name: "dark background", behind: () => 0, gloss: 0.5, body: 0.25 },
  { name: "bright background", behind: () => 0.7, gloss: 0.6, body: 0.3 },
  {
    name: "table and wall",
    behind: (/** @type {number} */ x, /** @type {number} */ y) => (y > 150 ? 0.25 : 0.5) + x / 4000,
    gloss: 0.8,
    body: 0.1,
    noise: 0.02,
  },
  { name: "matt", behind: () => 0.02, gloss: 0, body: 0.8, noise: 0.01 },
  { name: "clipped highlight", behind: () => 0, gloss: 4, body: 0.3 },
];
/** @type {Vec3[]} */
const LIGHTS = [unit([0.5, 0.6, 0.8]), unit([-0.8, 0.3, 0.5]), unit([0.2, -0.4, 1])];

for (const shot of SHOTS)
  test(`circle and light are guessed: ${shot.name}`, () => {
    for (const light of LIGHTS) {
      const circle = { x: 190, y: 118, radius: 71.5 };
      const { codes, camera, whole } = drawn({
        width: 320,
        height: 240,
        circle,
        fov: 30,
        light,
        ...shot,
      });
      const found = guessCircle(codes);
      assert.ok(found, "no circle");
      const off = Math.hypot(found.x - circle.x, found.y - circle.y);
      assert.ok(off < 1.6 && Math.abs(found.radius - circle.radius) < 1, JSON.stringify(found));
      const guess = guessSpot(greyOf(codes), circle, camera, whole, BALL);
      assert.ok(guess, "no spot");
      assert.equal(guess.surface, shot.gloss ? "glossy" : "matt");
      const back = lightFrom(surfaceAt(guess.spot, camera, whole, BALL), guess.surface);
      assert.ok(back && angleBetween(back, light) < 2.5, `${back} for ${light}`);
    }
  });

test("a picture without a ball has no circle, and a dark ball no spot", () => {
  const flat = { width: 100, height: 80, data: new Uint8ClampedArray(4 * 8000).fill(90) };
  assert.equal(guessCircle(flat), null);
  const stripes = flat.data.map((_, at) => (Math.floor(at / 4) % 20 < 10 ? 0 : 200));
  assert.equal(guessCircle({ ...flat, data: stripes }), null);
  const whole = { x: 0, y: 0, width: 100, height: 80 };
  const circle = { x: 50, y: 40, radius: 30 };
  const camera = cameraOf(circle, whole, 30, BALL);
  const black = greyOf({ ...flat, data: new Uint8ClampedArray(4 * 8000) });
  assert.equal(guessSpot(black, circle, camera, whole, BALL), null);
});

test("pictures are shrunk by means", () => {
  const data = [0, 0, 0, 255, 100, 0, 0, 255, 50, 8, 0, 255, 10, 0, 0, 255, 90, 0, 0, 255, 1, 1, 1, 1];
  const small = shrunk({ width: 3, height: 2, data }, 2);
  assert.deepEqual([small.width, small.height, ...small.data], [1, 1, 50, 0, 0, 255]);
});

/** The beginning of a JPEG file with two Exif fields. @param {boolean} little */
function jpeg(little) {
  const bytes = new DataView(new ArrayBuffer(80));
  bytes.setUint16(0, 0xffd8);
  bytes.setUint16(2, 0xffe1);
  bytes.setUint16(4, 70);
  bytes.setUint32(6, 0x45786966);
  const tiff = 12;
  bytes.setUint16(tiff, little ? 0x4949 : 0x4d4d);
  bytes.setUint16(tiff + 2, 42, little);
  bytes.setUint32(tiff + 4, 8, little);
  /** @param {number} at @param {number} tag @param {number} type @param {number} value */
  const field = (at, tag, type, value) => {
    bytes.setUint16(at, tag, little);
    bytes.setUint16(at + 2, type, little);
    bytes.setUint32(at + 4, 1, little);
    if (type === 4) bytes.setUint32(at + 8, value, little);
    else bytes.setUint16(at + 8, value, little);
  };
  bytes.setUint16(tiff + 8, 2, little);
  field(tiff + 10, 0x0112, 3, 6);
  field(tiff + 22, 0x8769, 4, 38);
  bytes.setUint16(tiff + 38, 1, little);
  field(tiff + 40, 0xa405, 3, 26);
  return bytes.buffer;
}

test("orientation and focal length are read from photographs", () => {
  for (const little of [true, false])
    assert.deepEqual(readExif(jpeg(little)), { orientation: 6, focal_mm: 26 });
  const none = { orientation: 1, focal_mm: null };
  for (let bytes = 0; bytes < 60; bytes += 1)
    assert.ok(readExif(jpeg(true).slice(0, bytes)).focal_mm === null);
  assert.deepEqual(readExif(new ArrayBuffer(0)), none);
  assert.deepEqual(readExif(new TextEncoder().encode("\x89PNG, and more").buffer), none);
});
