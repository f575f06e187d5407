/**
 * Lights of a scene as painted materials see them: in the scene's order, relative to the strongest
 * channel of all at the centre. An environment is one light from its mean direction.
 *
 * @import { EnvironmentMean as Mean, Scene, Vec3 } from "../model.js"
 * @import { Extent } from "./camera.js"
 * @import { Cone } from "./cone.js"
 */
import { meanOfEnvironment } from "../api/routes.js";
import { about } from "../scene/rotation.js";
import { EVERY_WAY } from "./cone.js";
import { LIGHTS, channels, irradianceAtCentre, lightsOf, rotate, rotateBack } from "./camera.js";
import { rotationAt } from "./spheres.js";

/** Delay before a request is repeated that failed. */
const AGAIN_MS = 5000;

/**
 * @typedef {{place: Vec3, isDirection: boolean, color: Vec3, cone: Cone, index: number, degrees:
 *   number}} PaintLight `place`: of a light, or the direction to it; `color`: relative irradiance
 *   at distance 1; `index`, `degrees`: as of point lights.
 *
 */

/** Stands for a scene without lights. @type {PaintLight} */
const DARK = {
  place: [0, 0, 1], isDirection: true, color: [0, 0, 0], cone: EVERY_WAY, index: 0, degrees: 0,
};

/**
 * Mean lights of environments by the names of their images.
 */
export class MeanLights {
  /** @type {Map<string, Mean|null>} */
  #known = new Map();
  #changed;

  /** @param {() => void} changed is called when one has arrived */
  constructor(changed) {
    this.#changed = changed;
  }

  /** The mean of an image; null until it is there. @param {string} image @returns {Mean|null} */
  of(image) {
    const known = this.#known.get(image);
    if (known !== undefined) return known;
    this.#known.set(image, null);
    void this.#load(image);
    return null;
  }

  /** @param {string} image */
  async #load(image) {
    try {
      this.#known.set(image, await meanOfEnvironment(image));
    } catch {
      // The server's pictures stay visible meanwhile.
      await new Promise((done) => setTimeout(done, AGAIN_MS));
      this.#known.delete(image);
    }
    this.#changed();
  }
}

/**
 * The lights for painted materials; null if they are not known or cannot be drawn.
 * @param {Scene} scene
 * @param {Extent} extent
 * @param {{rotation: number[], scale: number}} pose of the object
 * @param {number} degrees how far the lights have gone round
 * @param {(image: string) => Mean|null} meanOf
 * @returns {PaintLight[]|null}
 */
export function paintLightsOf(scene, extent, pose, degrees, meanOf) {
  const all = scene.lights ?? [];
  // Lit spheres, which painted materials lack, have the environment behind the object.
  if (scene.backdrop?.kind === "environment" || all.length > LIGHTS) return null;
  const points = lightsOf(scene, extent, pose, degrees);
  /** @type {{light: PaintLight, strength: number}[]} */
  const found = [];
  for (const light of all) {
    if (light.kind === "environment") {
      const mean = meanOf(light.image ?? "");
      if (!mean?.direction) return null;
      const [x, y, z] = mean.direction;
      const turned = rotate(about([0, 1, 0], rotationAt(light, degrees)), [x, y, z]);
      const scale = channels(light.scale) ?? [1, 1, 1];
      const [r, g, b] = mean.radiance.map((channel, k) => Math.PI * channel * scale[k]);
      const place = rotateBack(pose.rotation, turned);
      found.push({
        light: { place, isDirection: true, color: [r, g, b], cone: EVERY_WAY, index: 0, degrees },
        strength: Math.max(r, g, b),
      });
      continue;
    }
    const point = points.shift();
    if (!point) return null;
    const { place, intensity: color, cone, index } = point;
    found.push({
      light: { place, isDirection: false, color, cone, index, degrees },
      strength: irradianceAtCentre(point),
    });
  }
  if (found.length === 0) return [DARK];
  const strongest = Math.max(...found.map(({ strength }) => strength));
  const unit = strongest > 0 ? 1 / strongest : 0;
  return found.map(({ light }) => {
    const [r, g, b] = light.color;
    return { ...light, color: [r * unit, g * unit, b * unit] };
  });
}
