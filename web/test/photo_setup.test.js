/** Photographs in the form: crops, the scene that follows, meshes, and the upload. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { draggedCrop } from "../photo/drag.js";
import { angleBetween, spotOf } from "../photo/highlight.js";
import { meshSurfaceAt, seenMesh } from "../photo/mesh.js";
import { circleOf, surfaceAt } from "../photo/placement.js";
import {
  BALL, BALL_EXTENT, cameraOfPlaced, cropAround, fittingCrop, isWhole, lensOf, lightInWords,
  lightOfPlaced, sceneOfPlaced, wholeOf,
} from "../photo/setup.js";
import { fromDegrees } from "../scene/rotation.js";
import { buildUpload, cropOf, newPicture, picturesFromList, pointedView } from "../search/views.js";

/** @typedef {import("../photo/setup.js").Placed} Placed */

const SIZE = { width: 640, height: 480 };

/** @param {Partial<Placed>} [change] @returns {Placed} */
const placed = (change) => ({
  size: SIZE,
  mesh: BALL,
  extent: BALL_EXTENT,
  circle: { x: 220, y: 200, radius: 90 },
  rotation_deg: [0, 0, 0],
  fov_y_deg: 45,
  surface: "glossy",
  spot: { x: 200, y: 170 },
  light: null,
  spotByHand: false,
  cropByHand: false,
  found: true,
  ...change,
});

/** Bounding sphere of another object. */
const EXTENT = { centre: /** @type {[number, number, number]} */ ([0.4, -2, 7]), radius: 2.5 };

/** Vertices and triangles of a sphere, in radii from its centre. @param {number} rows */
function sphere(rows) {
  const [positions, corners] = [[], []];
  const columns = 2 * rows;
  for (let row = 0; row <= rows; row += 1) {
    for (let column = 0; column <= columns; column += 1) {
      const [theta, phi] = [(Math.PI * row) / rows, (2 * Math.PI * column) / columns];
      positions.push(
        Math.sin(theta) * Math.sin(phi),
        Math.cos(theta),
        Math.sin(theta) * Math.cos(phi),
      );
      if (row === rows || column === columns) continue;
      const [a, b] = [row * (columns + 1) + column, (row + 1) * (columns + 1) + column];
      corners.push(a, b, a + 1, a + 1, b, b + 1);
    }
  }
  return {
    extent: EXTENT,
    positions: Float32Array.from(positions),
    normals: Float32Array.from(positions),
    tangents: new Float32Array(),
    uvs: new Float32Array(),
    corners: Uint32Array.from(corners),
  };
}

test("crops stay within the picture and have a least size", () => {
  assert.deepEqual(fittingCrop({ x: -5.4, y: 3.6, width: 900, height: 20 }, SIZE), {
    x: 0, y: 4, width: 640, height: 20,
  });
  assert.deepEqual(fittingCrop({ x: 639, y: 479, width: 5, height: 0 }, SIZE), {
    x: 632, y: 472, width: 8, height: 8,
  });
  assert.ok(isWhole(fittingCrop(wholeOf(SIZE), SIZE), SIZE));
  const around = cropAround({ x: 220, y: 60, radius: 100 }, SIZE);
  assert.deepEqual(around, { x: 95, y: 0, width: 250, height: 185 });
});

test("a corner moves two sides of the crop, an edge one, and none past the other", () => {
  const crop = { x: 10, y: 20, width: 100, height: 50 };
  assert.deepEqual(draggedCrop(crop, "nw", 5, -5), { x: 15, y: 15, width: 95, height: 55 });
  assert.deepEqual(draggedCrop(crop, "e", 7, 99), { x: 10, y: 20, width: 107, height: 50 });
  assert.deepEqual(draggedCrop(crop, "s", 0, -500), { x: 10, y: 20, width: 100, height: 8 });
  assert.deepEqual(draggedCrop(crop, "w", 500, 0), { x: 102, y: 20, width: 8, height: 50 });
});

test("the scene shows the ball where the circle is, whatever the crop", () => {
  for (const crop of [wholeOf(SIZE), { x: 100, y: 90, width: 300, height: 211 }]) {
    const camera = cameraOfPlaced(placed(), crop);
    const circle = circleOf(camera, crop, BALL_EXTENT);
    assert.ok(Math.hypot(circle.x - 220, circle.y - 200, circle.radius - 90) < 1e-6);
    const light = lightOfPlaced(placed(), crop, null);
    assert.ok(light);
    const scene = sceneOfPlaced(placed(), light, crop);
    assert.equal(scene.mesh, "sphere");
    assert.deepEqual(scene.film, { exposure: "auto", tone: "none" });
    const [{ direction }] = scene.lights;
    const back = /** @type {import("../model.js").Vec3} */ (direction.map((part) => -part));
    assert.ok(angleBetween(back, light) < 1e-3);
    const spot = spotOf(back, "glossy", camera, crop, BALL_EXTENT);
    assert.ok(spot && Math.hypot(spot.x - 200, spot.y - 170) < 1e-2);
    // The camera of the scene is rounded by far less than a pixel.
    const rounded = circleOf(/** @type {any} */ (scene.camera), crop, BALL_EXTENT);
    assert.ok(Math.hypot(rounded.x - 220, rounded.y - 200) < 1e-4);
  }
});

test("lights have names as the user sees them", () => {
  assert.equal(lightInWords([0, 0, 1]), "from the eye");
  assert.equal(lightInWords([Math.SQRT1_2, Math.SQRT1_2, 0]), "from the upper right, 90° from the eye");
  assert.equal(lightInWords([0, -0.5, Math.sqrt(0.75)]), "from below, 30° from the eye");
  assert.equal(lightInWords([-1, 0, 0]), "from the left, 90° from the eye");
});

test("a mesh of a sphere is hit where the sphere is, and has its outline", () => {
  const arrays = sphere(60);
  const of = placed({ extent: EXTENT });
  const crop = wholeOf(SIZE);
  const camera = cameraOfPlaced(of, crop);
  const rotation = fromDegrees([20, -50, 70]);
  for (const at of [{ x: 220, y: 200 }, { x: 170, y: 250 }, { x: 280, y: 180 }]) {
    const [mesh, ball] = [
      meshSurfaceAt(at, camera, crop, arrays, rotation),
      surfaceAt(at, camera, crop, EXTENT),
    ];
    assert.ok(mesh && ball && angleBetween(mesh.normal, ball.normal) < 1);
  }
  assert.equal(meshSurfaceAt({ x: 400, y: 200 }, camera, crop, arrays, rotation), null);
  const { outline, front } = seenMesh(camera, crop, arrays, rotation);
  assert.ok(front.length / 6 > 0.35 * (arrays.corners.length / 3), "triangles face the eye");
  assert.ok(outline.length / 4 > 60);
  for (let at = 0; at < outline.length; at += 2) {
    const radius = Math.hypot(outline[at] - 220, outline[at + 1] - 200);
    assert.ok(Math.abs(radius - 90) < 3, `${radius}`);
  }
});

test("placed objects make the scene and the crop of the upload", () => {
  const file = new File(["x"], "ball.jpg");
  const crop = { x: 100, y: 90, width: 300, height: 211 };
  const light = lightOfPlaced(placed(), crop, null);
  const view = { ...newPicture(file, undefined, true), from: /** @type {const} */ ("placed") };
  const wrong = buildUpload([view], null);
  assert.ok("wrong" in wrong && wrong.field === "scene");
  const dark = buildUpload([{ ...view, placed: placed() }], null);
  assert.ok("wrong" in dark && dark.field === "spot");
  const made = buildUpload([{ ...view, crop, placed: placed({ light }) }], null);
  assert.ok("spec" in made);
  const [said] = /** @type {any[]} */ (made.spec.views);
  assert.deepEqual(said.crop, [100, 90, 300, 211]);
  assert.equal(said.gain, true);
  assert.equal(said.scene.mesh, "sphere");
  assert.deepEqual(Object.keys(said.scene.camera), ["eye", "target", "up", "fov_y_deg"]);
  // A guessed crop is not that of another scene, one made by hand is.
  const other = { ...view, crop, from: /** @type {const} */ ("default") };
  assert.equal(cropOf({ ...other, placed: placed() }), null);
  assert.deepEqual(cropOf({ ...other, placed: placed({ cropByHand: true }) }), crop);
  const all = { ...other, crop: wholeOf(SIZE), placed: placed({ cropByHand: true }) };
  assert.equal(cropOf(all), null);
  assert.deepEqual(pointedView("/views/1/crop/2"), { view: 1, field: "crop" });
});

test("a list of pictures keeps its crops", async () => {
  const list = JSON.stringify({ views: [{ picture: "a.exr", scene: {}, crop: [1, 2, 30, 40] }] });
  const views = await picturesFromList(list, [new File(["x"], "a.exr")]);
  assert.ok(Array.isArray(views));
  assert.deepEqual(cropOf(views[0]), { x: 1, y: 2, width: 30, height: 40 });
});

test("the lens is recognised by the field of view", () => {
  assert.equal(lensOf(placed()), "");
  const { width, height } = SIZE;
  const fov = (2 * Math.atan((0.5 * height) / ((26 / 43.27) * Math.hypot(width, height))) * 180) / Math.PI;
  assert.equal(lensOf(placed({ fov_y_deg: fov })), "phone");
});
