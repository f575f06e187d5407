// Tests exported pages: node three_page.mjs FILES PACKAGES (see three_shared.mjs)
//
// Each page is opened in Chromium, with three.js from npm under the addresses that the page names,
// so its hashes are checked too. Three comparisons, each by readback of 32-bit floats:
//
// - value_error: the material's functions at all pairs, against the values of the reference;
// - drawn_error: the page's own material on a small plane under its own light, against f cos of the
//   reference, one pixel a pair;
// - sphere_error: the sphere in the page's own view, against f cos at the places where rays meet a
//   true sphere: the mesh, its normals, tangents and texture positions. Most of it is the mesh.
//
// Then the picture on the screen is compared with the sRGB code of the floats. With the first page,
// controls, keys and accessibility are checked too.

import { strict as assert } from "node:assert";

import {
  AXE, ORIGIN, boundOf, drawnPairs, errorOf, errorOfPixels, openPage, readCases, run, start,
  version,
} from "./three_shared.mjs";

/** Bounds of the functions, and with the page's arithmetic of a light. */
const VALUE_BOUND = { error: 1e-5, ratio: 2 };
const DRAWN_BOUND = { error: 1e-5, ratio: 16 };
/** Largest median of the relative error of pixels of the sphere, most of it of the mesh. */
const SPHERE_MEDIAN = 0.04;
/**
 * Largest median of the difference of codes on the screen. Fine patterns differ more, because the
 * screen is the mean of samples at the edges of triangles.
 */
const SCREEN_CODES = 1;

/** Runs in the page: what the functions below share. */
function prepare() {
  const { THREE, renderer } = globalThis.view;
  const target = (width, height) =>
    new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType });
  const read = (from) => {
    const pixels = new Float32Array(4 * from.width * from.height);
    renderer.readRenderTargetPixels(from, 0, 0, from.width, from.height, pixels);
    return pixels;
  };
  const withoutAlpha = (pixels) => Array.from(pixels).filter((_, k) => k % 4 !== 3);

  /** f at pairs, each wi, wo, u, v, by the script "evolved" of the page. */
  let evaluator;
  const f = (pairs) => {
    const count = pairs.length / 8;
    const given = new THREE.DataTexture(
      new Float32Array(pairs), 2, count, THREE.RGBAFormat, THREE.FloatType);
    given.needsUpdate = true;
    evaluator ??= new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3, depthTest: false,
      vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: document.getElementById("evolved").textContent + `
        uniform highp sampler2D given;
        out vec4 color;
        void main() {
          vec4 a = texelFetch(given, ivec2(0, gl_FragCoord.y), 0);
          vec4 b = texelFetch(given, ivec2(1, gl_FragCoord.y), 0);
          vec3 n = vec3(0.0, 0.0, 1.0), x = vec3(1.0, 0.0, 0.0), y = vec3(0.0, 1.0, 0.0);
          color = vec4(evolved(a.xyz, vec3(a.w, b.xy), n, x, y, b.zw), 1.0);
        }`,
      uniforms: { brood_zero: { value: 0 }, given: { value: null } },
    });
    evaluator.uniforms.given.value = given;
    const quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), evaluator);
    quad.frustumCulled = false;
    const values = target(1, count);
    renderer.setRenderTarget(values);
    renderer.render(quad, new THREE.Camera());
    const found = withoutAlpha(read(values));
    renderer.setRenderTarget(null);
    given.dispose();
    values.dispose();
    return found;
  };
  return { target, read, withoutAlpha, f };
}

/** Runs in the page: draws the page's material at pairs, with irradiance 1 at normal incidence. */
function drawPairs(pairs) {
  const { THREE, renderer, material } = globalThis.view;
  const { target, read, withoutAlpha } = globalThis.tools;
  const count = pairs.length / 8;
  const values = target(count, 1);
  const geometry = new THREE.PlaneGeometry(1, 1);
  geometry.computeTangents();
  const plane = new THREE.Mesh(geometry, material);
  const camera = new THREE.PerspectiveCamera(0.001, 1, 1, 100);
  const { lightPlaces, lightIntensities, exposure } = material.uniforms;
  exposure.value = 1;
  lightIntensities.value = lightIntensities.value.map((_, k) => (k === 0 ? 4 : 0));
  renderer.autoClear = false;
  for (let k = 0; k < count; k++) {
    const [ix, iy, iz, ox, oy, oz, u, v] = pairs.slice(8 * k, 8 * k + 8);
    lightPlaces.value[0].set(2 * ix, 2 * iy, 2 * iz);
    camera.position.set(10 * ox, 10 * oy, 10 * oz);
    camera.up.set(0, 0, 1);
    camera.lookAt(0, 0, 0);
    // Not much more than the pixel: places within it are more exact.
    plane.scale.setScalar(0.0004 / oz);
    const uvs = geometry.getAttribute("uv");
    for (let corner = 0; corner < 4; corner++) uvs.setXY(corner, u, v);
    uvs.needsUpdate = true;
    values.viewport.set(k, 0, 1, 1);
    renderer.setRenderTarget(values);
    renderer.render(plane, camera);
  }
  const found = withoutAlpha(read(values));
  renderer.setRenderTarget(null);
  renderer.autoClear = true;
  values.dispose();
  return found;
}

/**
 * Runs in the page: its own picture as floats and as codes on the screen, and what a true sphere
 * would show.
 */
function drawView() {
  const { THREE, renderer, scene, camera, material, applyControls } = globalThis.view;
  const { target, read, f } = globalThis.tools;
  document.getElementById("tone").value = "NoToneMapping";
  applyControls();
  const { width, height } = renderer.domElement;
  const picture = target(width, height);
  renderer.setRenderTarget(picture);
  renderer.render(scene, camera);
  const floats = read(picture);
  picture.dispose();
  renderer.setRenderTarget(null);
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const codes = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, codes);

  const { lightPlaces, lightIntensities, exposure } = material.uniforms;
  const [pairs, weights, pixels, screen] = [[], [], [], []];
  const sphere = new THREE.Sphere(new THREE.Vector3(), 1);
  const ray = new THREE.Raycaster();
  const srgb = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
  for (let row = 0; row < height; row += 3) {
    for (let column = 0; column < width; column += 3) {
      const place = new THREE.Vector2(2 * (column + 0.5) / width - 1, 2 * (row + 0.5) / height - 1);
      ray.setFromCamera(place, camera);
      const n = ray.ray.intersectSphere(sphere, new THREE.Vector3());
      const wo = ray.ray.direction.clone().negate();
      // Not the rim, which the polygon cuts off, nor the poles, where the tangent has no limit.
      if (!n || n.dot(wo) < 0.1 || Math.abs(n.y) > 0.98) continue;
      const at = 4 * (row * width + column);
      const drawn = [0, 1, 2].map((channel) => floats[at + channel]);
      screen.push(...drawn.map((value, channel) =>
        Math.abs(codes[at + channel] - 255 * srgb(Math.min(value, 1)))));
      const azimuth = Math.atan2(n.z, -n.x);
      const x = new THREE.Vector3(Math.sin(azimuth), 0, Math.cos(azimuth));
      const y = n.clone().cross(x);
      const u = azimuth / (2 * Math.PI) + (azimuth < 0 ? 1 : 0);
      const local = (w) => [w.dot(x), w.dot(y), w.dot(n)];
      for (let k = 0; k < lightPlaces.value.length; k++) {
        const path = lightPlaces.value[k].clone().sub(n);
        const irradiance = lightIntensities.value[k] / path.lengthSq();
        const wi = local(path.normalize());
        pairs.push(...wi, ...local(wo), u, 1 - Math.acos(n.y) / Math.PI);
        weights.push(exposure.value * irradiance * Math.max(0, wi[2]));
      }
      pixels.push(drawn);
    }
  }
  const values = f(pairs);
  const lights = lightPlaces.value.length;
  const errors = [];
  for (const [place, drawn] of pixels.entries()) {
    for (let channel = 0; channel < 3; channel++) {
      let wanted = 0;
      for (let k = place * lights; k < (place + 1) * lights; k++) {
        wanted += weights[k] * values[3 * k + channel];
      }
      if (wanted > 1e-3) errors.push(Math.abs(drawn[channel] - wanted) / wanted);
    }
  }
  const sorted = (numbers) => numbers.sort((a, b) => a - b);
  const share = (numbers, part) => sorted(numbers)[Math.floor(part * (numbers.length - 1))] ?? null;
  return {
    sphere_error: share(errors, 0.5), sphere_pixels: pixels.length, lit: errors.length,
    screen_codes: share(screen, 0.5),
  };
}

/** Keys and controls of a page, also of a narrow one. */
async function checkControls(page) {
  const circle = page.locator("#circle");
  const turn = () => page.locator("#azimuth").inputValue();
  const eye = () => page.evaluate(() => globalThis.view.camera.position.toArray());
  const before = await turn();
  await page.keyboard.press("Space");
  await page.waitForFunction((it) => document.getElementById("azimuth").value !== it, before);
  assert.equal(await circle.textContent(), "Stop light");
  await circle.press("Space");
  await page.waitForFunction(() => document.getElementById("circle").textContent === "Start light");
  const first = await eye();
  await page.locator("#canvas").press("ArrowRight");
  const turned = await eye();
  assert.notDeepEqual(turned, first);
  await page.locator("#canvas").press("+");
  assert.ok(Math.hypot(...await eye()) < Math.hypot(...turned));
  await page.locator("#canvas").press("-");
  await page.locator("#canvas").press("ArrowLeft");
  for (const mesh of ["knot", "ring", "capsule", "sphere"]) {
    await page.locator("#mesh").selectOption(mesh);
    const hasTangents = await page.evaluate(() =>
      globalThis.view.mesh.geometry.getAttribute("tangent").array.every(Number.isFinite));
    assert.ok(hasTangents, mesh);
  }
  const size = page.viewportSize();
  await page.setViewportSize({ width: 320, height: 640 });
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 320);
  await page.setViewportSize(size);
  await page.addScriptTag({ path: AXE });
  const { violations } = await page.evaluate(() => globalThis.axe.run());
  assert.deepEqual(violations.map((it) => `${it.id}: ${it.nodes[0].html}`), []);
}

const listed = await readCases();
const { browser, context } = await start();

async function measure(material) {
  const { page, complaints } = await openPage(context);
  try {
    await page.goto(`${ORIGIN}/${material.file}`);
    await page.waitForFunction(() => globalThis.view || !document.getElementById("message").hidden);
    const message = await page.locator("#message").textContent();
    if (message) throw new Error(`${message} ${complaints.join("; ")}`);
    if (material === listed.cases[0]) await checkControls(page);
    await page.evaluate(`globalThis.tools = (${prepare})()`);
    const values = await page.evaluate((pairs) => globalThis.tools.f(pairs), listed.pairs);
    const shown = await page.evaluate(drawView);
    const { drawable, reflected } = drawnPairs({ pairs: listed.pairs, f: material.f });
    const drawn = await page.evaluate(drawPairs, drawable);
    if (complaints.length > 0) throw new Error(complaints.join("; "));
    const value_error = errorOf(values, material.f, listed.pairs);
    const drawn_error = errorOfPixels(drawn, reflected);
    const [bound, drawn_bound] = [VALUE_BOUND, DRAWN_BOUND].map((it) => boundOf(material, it));
    const passed = value_error <= bound && drawn_error <= drawn_bound &&
      shown.screen_codes <= SCREEN_CODES && (shown.sphere_error ?? 0) <= SPHERE_MEDIAN;
    return { value_error, bound, drawn_error, drawn_bound, ...shown, passed };
  } finally {
    await page.close();
  }
}

await run(`three ${version}, Chromium ${browser.version()}`, listed, measure);
await browser.close();
