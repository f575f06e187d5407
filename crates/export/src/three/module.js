/**
 * A material bred by brood, for three.js's WebGPURenderer on WebGPU and on WebGL 2:
 *
 *     import * as THREE from "three/webgpu";
 *     import BroodMaterial from "./THIS_FILE.js";
 *
 *     const mesh = new THREE.Mesh(geometry, new BroodMaterial());
 *     mesh.castShadow = mesh.receiveShadow = true;
 *
 * Directional, point and spot lights and their shadows work as with other materials. Light from
 * many directions adds nothing: ambient, hemisphere and rect area lights, light probes,
 * environments and light maps. Its reflection is an integral over all directions, which a BRDF in
 * general has no formula for; a few weak directional lights take its place.
 *
 * Texture positions are the attribute uv. The direction of u is the attribute tangent
 * (`geometry.computeTangents()`) or, without it, comes from the changes of uv between pixels, which
 * shows the triangles of coarse meshes in brushed materials and bumps.
 *
 * The material is @PROPERTIES@.
 * Program @HASH@, @OPERATIONS@ operations.
 * Tested with three @VERSION@.
 */
import { LightingModel, NodeMaterial } from "three/webgpu";
import {
  attribute, code, float, glslFn, normalView, positionView, positionViewDirection, sign,
  tangentView, uniform, uv, vec2, vec3, wgslFn,
} from "three/tsl";

const GLSL = `
// Must be 0: see reflected_with below.
uint brood_zero;

@GLSL@`;

const WGSL = `
// Must be 0: see reflected_with below.
var<private> brood_zero: u32;

@WGSL@`;

// The functions above round every product and sum separately, by brood_hold. Because compilers do
// not know the value of brood_zero, they cannot fuse operations across it. It is a uniform, which
// such code cannot name, so it is handed over in a variable.
const reflectedInGlsl = glslFn(
  `vec3 reflected_with(
    vec3 wi, vec3 wo, vec3 n, vec3 along, float across, vec2 position, uint zero
  ) {
    brood_zero = zero;
    return reflected(wi, wo, n, along, across, position);
  }`,
  [code(GLSL, [], "glsl")],
);

const reflectedInWgsl = wgslFn(
  `fn reflected_with(
    wi: vec3f, wo: vec3f, n: vec3f, along: vec3f, across: f32, position: vec2f, zero: u32
  ) -> vec3f {
    brood_zero = zero;
    return reflected(wi, wo, n, along, across, position);
  }`,
  [code(WGSL, [], "wgsl")],
);

const zero = uniform(0, "uint");

/** Direction in which u grows, and 1, or -1 where the texture is mirrored. */
function directionOfU(geometry) {
  if (geometry.hasAttribute("tangent")) {
    return [tangentView, sign(attribute("tangent", "vec4").w)];
  }
  if (!geometry.hasAttribute("uv")) return [vec3(0), float(1)];
  const [right, down] = [positionView.dFdx(), positionView.dFdy()];
  const [uvRight, uvDown] = [uv().dFdx(), uv().dFdy()];
  const area = uvRight.x.mul(uvDown.y).sub(uvDown.x.mul(uvRight.y));
  const along = right.mul(uvDown.y).sub(down.mul(uvRight.y)).mul(sign(area));
  const upwards = down.mul(uvRight.x).sub(right.mul(uvDown.x)).mul(sign(area));
  return [along, sign(normalView.cross(along).dot(upwards))];
}

class BroodLightingModel extends LightingModel {
  /** Light of one of three's lights: its direction in view space, its irradiance with shadows. */
  direct({ lightDirection, lightColor, reflectedLight }, builder) {
    const reflected = builder.renderer.backend.isWebGPUBackend ? reflectedInWgsl : reflectedInGlsl;
    const position = builder.geometry.hasAttribute("uv") ? uv() : vec2(0);
    const f = reflected(
      lightDirection, positionViewDirection, normalView, ...directionOfU(builder.geometry),
      position, zero,
    );
    reflectedLight.directDiffuse.addAssign(f.mul(lightColor));
  }
}

export default class BroodMaterial extends NodeMaterial {
  /** Different for each material: three keeps compiled shaders by this name. */
  static get type() {
    return "BroodMaterial_@SHORT@";
  }

  constructor(parameters) {
    super();
    this.lights = true;
    this.setValues(parameters);
  }

  setupLightingModel() {
    return new BroodLightingModel();
  }

  /** Environments are not reflected. */
  setupEnvironment() {
    return null;
  }
}
