/** Live drawing without a GPU: cameras, lights, exposure, outline, resolution, geometry. */
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  directionSeen, lightsOf, normalizedLights, rotationOf, strengthOf, viewOf,
} from "../live/camera.js";
import { meshPath, readGeometry } from "../live/geometry.js";
import { METER_GAIN, autoGain } from "../live/material.js";
import { SIDES, outline, triangles } from "../live/outline.js";
import { AdaptiveResolution, displayInterval } from "../live/resolution.js";
import { restingEnvironment, turnOf, turningEnvironment } from "../live/spheres.js";

const extent = { centre: /** @type {[number, number, number]} */ ([0, 0, 0]), radius: 1 };
const still = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], scale: 1 };

/** @param {number[]} found @param {number[]} wanted */
function near(found, wanted) {
  assert.equal(found.length, wanted.length);
  found.forEach((value, k) =>
    assert.ok(Math.abs(value - wanted[k]) < 1e-6, `${found} is not ${wanted}`),
  );
}

test("a framing camera sees the whole bounding sphere with a small margin", () => {
  const view = viewOf({ orbit_deg: [30, 20], fov_y_deg: 30 }, extent, still);
  const distance = Math.hypot(...view.eye);
  const edge = Math.tan(Math.asin(1 / distance)) / view.half;
  assert.ok(edge > 0.9 && edge < 1, `${edge}`);
  near(
    [view.forward[0] * distance, view.forward[1] * distance, view.forward[2] * distance],
    view.eye.map((part) => -part),
  );
});

test("rotating the object rotates eye and light the other way", () => {
  const pose = {
    rotation: rotationOf({
      rotation_deg: [0, 90, 0],
      mesh: "",
      scale: 1,
      camera: {},
      film: { exposure: "auto", tone: "none" },
    }),
    scale: 2,
  };
  const view = viewOf(
    { eye: [0, 0, 10], target: [0, 0, 0], up: [0, 1, 0], fov_y_deg: 30 },
    extent,
    pose,
  );
  near(view.eye, [-5, 0, 0]);
  const lights = lightsOf(
    { lights: [{ position: [0, 0, 4], intensity: [8, 4, 0] }] },
    extent,
    pose,
    0,
  );
  near(lights[0].place, [-2, 0, 0]);
  near(lights[0].intensity, [2, 1, 0]);
  near(directionSeen(lights[0], view), [0, 0, 1]);
});

test("the light circle is about the vertical, and the default light gives irradiance pi", () => {
  const [light] = lightsOf({ lights: [{ position: [0, 0, 4] }] }, extent, still, 90);
  near(light.place, [4, 0, 0]);
  near(light.intensity, [16 * Math.PI, 16 * Math.PI, 16 * Math.PI]);
});

test("directional lights are far away and give their irradiance", () => {
  const lights = lightsOf(
    {
      lights: [
        { kind: "directional", direction: [0, 0, -2], irradiance_w_m2: [3, 2, 1] },
        { kind: "directional" },
        {},
      ],
    },
    { ...extent, radius: 7 },
    { ...still, scale: 3 },
    90,
  );
  const [sun, plain, lamp] = lights;
  const far = Math.hypot(...sun.place);
  assert.ok(far > 1e7);
  near(sun.place.map((part) => part / far), [1, 0, 0]);
  near(sun.intensity.map((part) => part / far ** 2), [3, 2, 1]);
  // By default from where a point light is, with its irradiance at the centre.
  const away = Math.hypot(...lamp.place);
  near(plain.place.map((part) => part / far), lamp.place.map((part) => part / away));
  near(plain.intensity.map((part) => part / far ** 2), lamp.intensity.map((part) => part / away ** 2));
  assert.equal(strengthOf([sun]), 3 / Math.PI);
});

test("spot lights shine along their axis or towards the centre", () => {
  const lights = lightsOf(
    {
      lights: [
        { kind: "spot", position: [0, 0, 4], hotspot_deg: 0, falloff_deg: 60 },
        { kind: "spot", position: [0, 3, 0], axis: [0, 0, 5], falloff_deg: 90, hotspot_deg: 90 },
      ],
    },
    extent,
    still,
    90,
  );
  near(lights[0].cone.axis, [-1, 0, 0]);
  near([lights[0].cone.outer, lights[0].cone.slope], [0.5, 2]);
  near(lights[1].cone.axis, [1, 0, 0]);
  assert.ok(lights[1].cone.slope > 1e5);
  // A light in the centre shines down and decides no strength.
  const [inside, beside] = lightsOf(
    { lights: [{ kind: "spot", position: [0, 0, 0], intensity: 5 }, {}] },
    extent,
    still,
    0,
  );
  near(inside.cone.axis, [0, -1, 0]);
  assert.equal(strengthOf([inside, beside]), strengthOf([beside]));
});

test("automatic exposure cancels the strength and not the colour", () => {
  const lights = lightsOf(
    { lights: [{ position: [0, 0, 4], intensity: [32 * Math.PI, 16 * Math.PI, 0] }, {}] },
    extent,
    still,
    0,
  );
  assert.equal(strengthOf(lights), 2);
  near(normalizedLights(lights, 2)[0].intensity, [16 * Math.PI, 8 * Math.PI, 0]);
  near(normalizedLights(lights, 2)[1].intensity, [8 * Math.PI, 8 * Math.PI, 8 * Math.PI]);
  assert.equal(strengthOf(lightsOf({ lights: [{ intensity: [0, 0, 0] }] }, extent, still, 0)), 1);
});

test("exposure puts all but three in a hundred lit pixels below 0.9", () => {
  const pixels = new Float32Array(4 * 200);
  // As drawn for the meter: multiplied by the coverage, linear, and very faint.
  const faint = 12.92 * METER_GAIN;
  for (let k = 0; k < 100; k += 1) pixels.set([0, 0.5 * faint * (k + 1), 0, 0.5], 4 * k);
  assert.ok(Math.abs(autoGain(pixels) * 97 - 0.9) < 1e-6);
  assert.equal(autoGain(new Float32Array(40)), 1);
});

test("the outline contains the object with a small margin", () => {
  const side = 200;
  const view = viewOf({ orbit_deg: [30, 20], fov_y_deg: 30 }, extent, still);
  const points = [];
  for (let k = 0; k < 4000; k += 1) {
    const z = 1 - (2 * (k + 0.5)) / 4000;
    const r = Math.sqrt(1 - z * z);
    points.push(r * Math.cos(2.4 * k), r * Math.sin(2.4 * k), z);
  }
  const corners = outline(new Float32Array(points), view, side);
  assert.equal(corners.length, 2 * SIDES);
  let area = 0;
  for (let k = 0; k < SIDES; k += 1) {
    const n = (k + 1) % SIDES;
    area += 0.5 * (corners[2 * k] * corners[2 * n + 1] - corners[2 * n] * corners[2 * k + 1]);
  }
  const parts = triangles(corners);
  let covered = 0;
  for (let k = 0; k < parts.length; k += 6) {
    const [ax, ay, bx, by, cx, cy] = parts.subarray(k, k + 6);
    covered += 0.5 * ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay));
  }
  assert.ok(
    parts.length === 6 * (SIDES - 2) && Math.abs(covered - area) < 1e-5,
    `${parts.length} ${covered}`,
  );
  // The sphere is a circle in the picture.
  const reach = Math.max(...corners);
  assert.ok(
    area > 0 && area < 1.03 * Math.PI * reach * reach && area > 0.97 * Math.PI * reach * reach,
    `${area} ${reach}`,
  );
  // From inside, the object may be seen anywhere.
  assert.equal(outline(new Float32Array([0, 0, 0, ...view.eye]), view, side).length, 8);
});

/**
 * A display with a frame every `interval` milliseconds; a drawing that takes longer misses frames.
 * @param {AdaptiveResolution} pace
 * @param {{interval: number, whole_ms: number, fixed_ms?: number, seconds: number}} machine
 *   `whole_ms`: what a whole buffer takes
 * @returns {number} frames a second of the last half
 */
function shown(pace, { interval, whole_ms, fixed_ms = 0, seconds }) {
  const late = [];
  let now = 0;
  let done = 0;
  while (now < 1000 * seconds) {
    pace.step(now);
    done = Math.max(done, now) + fixed_ms + whole_ms * pace.ratio ** 2;
    // The next frame begins at the display's next one, or later if drawing is not finished by then.
    now =
      interval * Math.max(Math.round(now / interval) + 1, Math.ceil((done - interval) / interval));
    if (now > 500 * seconds) late.push(now);
  }
  return (1000 * (late.length - 1)) / (late[late.length - 1] - late[0]);
}

test("the resolution falls on a slow machine and rises on a quick one", () => {
  const pace = new AdaptiveResolution();
  let now = 0;
  const run = (/** @type {number} */ whole_ms) => {
    for (let k = 0; k < 72; k += 1) pace.step((now += whole_ms * pace.ratio ** 2));
  };
  run(100);
  const slow = pace.ratio;
  assert.ok(slow < 0.65 && slow >= 0.3, `${slow}`);
  run(35 / slow ** 2);
  assert.equal(pace.ratio, slow);
  run(10);
  assert.equal(pace.ratio, 1);
});

test("the resolution falls on hardware until every frame is drawn", () => {
  for (const rate of [60, 120, 144]) {
    const interval = 1000 / rate;
    for (const load of [0.1, 0.9, 1.3, 2.5, 5]) {
      const pace = new AdaptiveResolution();
      pace.aimAt(interval);
      const found = shown(pace, { interval, whole_ms: load * interval, seconds: 20 });
      assert.ok(found > 0.91 * rate, `${found} of ${rate} frames a second at ${load}`);
      const most = Math.min(1, 1 / Math.sqrt(load));
      assert.ok(pace.ratio > 0.75 * most, `${pace.ratio} of ${most} at ${load}`);
    }
  }
});

test("the resolution stays when drawing is not the bottleneck", () => {
  const pace = new AdaptiveResolution();
  pace.aimAt(1000 / 120);
  // The window was moved to a display of half the rate.
  assert.ok(shown(pace, { interval: 1000 / 60, whole_ms: 2, seconds: 20 }) > 59);
  assert.equal(pace.ratio, 1);
});

test("a faster display becomes the aim", () => {
  const pace = new AdaptiveResolution();
  pace.aimAt(1000 / 60);
  const interval = 1000 / 144;
  shown(pace, { interval, whole_ms: 2, seconds: 5 });
  assert.equal(pace.ratio, 1);
  pace.pause();
  const found = shown(pace, { interval, whole_ms: 9, seconds: 20 });
  assert.ok(found > 0.91 * 144 && pace.ratio < 1, `${found} at ${pace.ratio}`);
});

test("one delayed frame does not lower the resolution", () => {
  const pace = new AdaptiveResolution();
  pace.aimAt(16);
  for (let now = 0, k = 0; k < 600; k += 1) pace.step((now += k % 12 === 5 ? 90 : 16));
  assert.equal(pace.ratio, 1);
});

test("displayInterval ignores late frames", async () => {
  let now = 0;
  let count = 0;
  const nextFrame = (/** @type {(now: number) => void} */ tick) =>
    setImmediate(() => tick((now += count++ % 3 === 0 ? 31 : 8)));
  assert.equal(await displayInterval(nextFrame), 8);
});

test("geometry of another version is refused", () => {
  const bytes = new ArrayBuffer(56);
  assert.throws(() => readGeometry(bytes), /another version/);
});

test("the mesh is requested with the pole of its texture", () => {
  assert.equal(meshPath({ mesh: "knob" }, "geometry"), "/v1/meshes/knob/geometry");
  assert.equal(
    meshPath({ mesh: "sphere", sphere_pole: "y" }, "geometry"),
    "/v1/meshes/sphere/geometry",
  );
  assert.equal(
    meshPath({ mesh: "sphere", sphere_pole: "z" }, "mesh.glb"),
    "/v1/meshes/sphere/mesh.glb?sphere_pole=z",
  );
});

test("environments in any rotation as a whole have one key while they turn", () => {
  /** @param {object[]} lights @param {object} [more] */
  const scene = (lights, more) =>
    /** @type {import("../model.js").Scene} */ ({
      mesh: "",
      rotation_deg: [0, 0, 0],
      scale: 1,
      camera: { orbit_deg: [30, 20], fov_y_deg: 30 },
      film: { exposure: "auto", tone: "none" },
      light_deg: 20,
      lights,
      ...more,
    });
  /** @param {number} rotation_deg @param {boolean} fixed */
  const studio = (rotation_deg, fixed) => ({ kind: "environment", image: "studio", rotation_deg, fixed });
  const one = scene([{}, studio(70, true)]);
  const other = scene([studio(300, false)]);
  assert.deepEqual([turnOf(one, 20), turnOf(other, 20)], [70, 320]);
  assert.deepEqual(turningEnvironment(one), turningEnvironment(other));
  assert.notEqual(restingEnvironment(one).key, restingEnvironment(other).key);
  assert.deepEqual(
    restingEnvironment(one),
    restingEnvironment(scene([studio(50, false)])),
    "the light angle counts as rotation",
  );
  const apart = [studio(10, true), studio(90, true)];
  assert.notEqual(
    turningEnvironment(scene(apart))?.key,
    turningEnvironment(scene([apart[0], studio(91, true)]))?.key,
  );
  assert.equal(restingEnvironment(scene([{}])).key, "");
  assert.equal(turningEnvironment(scene([{}])), null);
  const backdrop = { backdrop: { kind: "environment", blur_deg: 0 } };
  assert.equal(turningEnvironment(scene(apart, backdrop)), null, "the backdrop would stay");
  const above = { camera: { orbit_deg: [0, 85], fov_y_deg: 30 } };
  assert.equal(turningEnvironment(scene(apart, above)), null, "rows of eyes pass the pole");
});
