// Tests exported modules: node three_tsl.mjs FILES PACKAGES (see three_shared.mjs)
//
// Each module is imported in Chromium with three.js from npm, and its material is drawn by
// WebGPURenderer on WebGPU and on WebGL 2 under three's own directional and point lights: a small
// plane, one pixel a pair, read back as 32-bit floats and compared with f cos of the reference.
//
// - value_error: with tangents as an attribute;
// - derived_error: fewer pairs without them, with the direction of u from changes between pixels;
// - shadow: 0 if three's shadow of a box covers the plane.
//
// All materials share a renderer for each of the two, so one that gets the shader of another fails.
// The figures are the worse of the two.

import {
  ORIGIN, boundOf, drawnPairs, errorOfPixels, openPage, readCases, run, start, version,
} from "./three_shared.mjs";

/** Bound with three's arithmetic of lights, which is in the space of the eye. */
const BOUND = { error: 2e-5, ratio: 32 };
/** Bound without tangents: changes between pixels are rounded more. */
const DERIVED_BOUND = { error: 2e-3, ratio: 3000, most: 0.2 };
/** Pairs without tangents. */
const DERIVED = { count: 32, cosine: 0.3 };

/** Runs in the page. */
async function prepare(forceWebGL) {
  const THREE = await import("three/webgpu");
  const renderer = new THREE.WebGPURenderer({ forceWebGL, antialias: false });
  renderer.setSize(8, 8);
  renderer.shadowMap.enabled = true;
  await renderer.init();
  const [FOV_DEG, SIZE] = [0.001, 0.0004];
  const camera = new THREE.PerspectiveCamera(FOV_DEG, 1, 1, 100);
  const sun = new THREE.DirectionalLight();
  const lamp = new THREE.PointLight();
  const targetOf = (width) => new THREE.RenderTarget(width, 1, { type: THREE.FloatType });

  const read = async (values) => {
    const pixels = await renderer.readRenderTargetPixelsAsync(values, 0, 0, values.width, 1);
    return Array.from(pixels).slice(0, 4 * values.width).filter((_, k) => k % 4 !== 3);
  };

  const placeEye = (eye, distance) => {
    camera.position.set(...eye).multiplyScalar(distance);
    camera.up.set(0, 0, 1);
    camera.lookAt(0, 0, 0);
  };

  /** Pixels of a material at pairs, each wi, wo, u, v; the light is a sun and a lamp in turn. */
  const draw = async (material, pairs, hasTangents) => {
    const count = pairs.length / 8;
    const values = targetOf(count);
    const geometry = new THREE.PlaneGeometry(1, 1);
    if (hasTangents) geometry.computeTangents();
    const plane = new THREE.Mesh(geometry, material);
    const scene = new THREE.Scene().add(plane, sun, lamp);
    // Changes between pixels are more exact if pixels are larger.
    const scale = hasTangents ? 1 : 30;
    camera.fov = FOV_DEG * scale;
    camera.updateProjectionMatrix();
    renderer.autoClear = false;
    for (let k = 0; k < count; k++) {
      const [ix, iy, iz, ox, oy, oz, u, v] = pairs.slice(8 * k, 8 * k + 8);
      for (const light of [sun, lamp]) light.position.set(ix, iy, iz);
      sun.intensity = k % 2;
      lamp.intensity = 1 - sun.intensity;
      placeEye([ox, oy, oz], 10);
      // Not much more than the pixel: places within it are more exact.
      plane.scale.setScalar(SIZE * scale / oz);
      const uvs = geometry.getAttribute("uv");
      for (let corner = 0; corner < 4; corner++) {
        // Without tangents u and v must change along the plane.
        const [right, up] = hasTangents ? [0, 0] : [corner % 2 - 0.5, 0.5 - Math.floor(corner / 2)];
        uvs.setXY(corner, u + 0.01 * right, v + 0.01 * up);
      }
      uvs.needsUpdate = true;
      values.viewport.set(k, 0, 1, 1);
      renderer.setRenderTarget(values);
      renderer.render(scene, camera);
    }
    const found = await read(values);
    renderer.setRenderTarget(null);
    values.dispose();
    geometry.dispose();
    return found;
  };

  /** Brightest pixels of a plane in the sun, and in the shadow of a box. */
  const shade = async (material) => {
    const plane = new THREE.Mesh(new THREE.PlaneGeometry(4, 4), material);
    plane.receiveShadow = true;
    const box = new THREE.Mesh(new THREE.BoxGeometry(1, 1, 0.2));
    box.position.set(0, 0, 2);
    box.castShadow = true;
    const light = new THREE.DirectionalLight("white", 1);
    light.position.set(0, 0, 5);
    light.castShadow = true;
    const scene = new THREE.Scene().add(plane, box, light);
    placeEye([0.8, 0, 0.6], 10);
    const values = targetOf(1);
    const brightest = [];
    for (const isCovered of [false, true]) {
      box.visible = isCovered;
      renderer.setRenderTarget(values);
      renderer.render(scene, camera);
      brightest.push(Math.max(...await read(values)));
    }
    renderer.setRenderTarget(null);
    values.dispose();
    light.dispose();
    return brightest;
  };

  globalThis.tools = { draw, shade };
  return renderer.backend.isWebGPUBackend === true;
}

/** Runs in the page: draws the material of a module. */
async function drawModule({ file, drawable, derived }) {
  const { draw, shade } = globalThis.tools;
  const { default: BroodMaterial } = await import(`/${file}`);
  const material = new BroodMaterial();
  const drawn = await draw(material, drawable, true);
  const withoutTangents = await draw(material, derived, false);
  const [lit, shadow] = await shade(material);
  material.dispose();
  return { drawn, withoutTangents, lit, shadow };
}

const listed = await readCases();
const { browser, context } = await start(
  ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"],
  `<!doctype html><link rel="icon" href="data:,"><script type="importmap">{"imports": {
    "three/webgpu": "https://cdn.jsdelivr.net/npm/three@${version}/build/three.webgpu.js",
    "three/tsl": "https://cdn.jsdelivr.net/npm/three@${version}/build/three.tsl.js"
  }}</script>`,
);

async function openBackend(name) {
  const opened = await openPage(context);
  await opened.page.goto(`${ORIGIN}/`);
  const isWebGPU = await opened.page.evaluate(prepare, name === "webgl2");
  if (isWebGPU !== (name === "webgpu")) throw new Error(`${name} is not available`);
  return { name, ...opened };
}

const backends = [await openBackend("webgpu"), await openBackend("webgl2")];

async function measure(material) {
  const given = { pairs: listed.pairs, f: material.f };
  const { drawable, reflected } = drawnPairs(given);
  const derived = drawnPairs({ ...given, ...DERIVED });
  const [bound, derived_bound] = [BOUND, DERIVED_BOUND].map((it) => boundOf(material, it));
  const result = { value_error: 0, bound, derived_error: 0, derived_bound, shadow: 0 };
  for (const { name, page, complaints } of backends) {
    const found = await page.evaluate(drawModule, {
      file: material.file, drawable, derived: derived.drawable,
    });
    if (complaints.length > 0) throw new Error(`${name}: ${complaints.splice(0).join("; ")}`);
    result[name] = errorOfPixels(found.drawn, reflected);
    result.value_error = Math.max(result.value_error, result[name]);
    const derived_error = errorOfPixels(found.withoutTangents, derived.reflected);
    result.derived_error = Math.max(result.derived_error, derived_error);
    result.shadow = Math.max(result.shadow, found.shadow);
    result.lit = found.lit;
  }
  const { value_error, derived_error, shadow } = result;
  const passed = value_error <= bound && derived_error <= derived_bound && shadow === 0;
  return { ...result, passed };
}

await run(`three ${version}, Chromium ${browser.version()}`, listed, measure);
await browser.close();
