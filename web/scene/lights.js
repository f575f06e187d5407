/**
 * The two lights of a scene that the page controls: the lamp, which is the first light of all but
 * environments, and the environment, the first of these. Others stay as the scene has them.
 *
 * @import { Light, Scene } from "../model.js"
 */

/**
 * Samples of light from all around, for materials that need them: fewer than the server's default,
 * so that a brood is rendered in seconds.
 */
export const SKY_SAMPLES = 16;

/** An environment that stays while the lamp circles. @param {string} image @returns {Light} */
export const environment = (image) => ({
  kind: "environment",
  image,
  samples: SKY_SAMPLES,
  fixed: true,
});

/** @param {Light} light */
const isEnvironment = ({ kind }) => kind === "environment";

/** @param {Light} light */
const isLamp = (light) => !isEnvironment(light);

/** @param {Pick<Scene, "lights">|null} scene */
export const lampOf = (scene) => scene?.lights?.find(isLamp);

/** @param {Pick<Scene, "lights">|null} scene */
export const environmentOf = (scene) => scene?.lights?.find(isEnvironment);

/** Number of lights that the page does not control. @param {Pick<Scene, "lights">|null} scene */
export const othersOf = (scene) =>
  (scene?.lights ?? []).filter((one) => one !== lampOf(scene) && one !== environmentOf(scene))
    .length;

/**
 * Replaces one of the two, or adds or removes it: lamps come before environments.
 * @param {Light[]} lights
 * @param {Light|undefined} before
 * @param {Light|null} after
 */
function replaced(lights, before, after) {
  const at = before ? lights.indexOf(before) : -1;
  const [first, rest] = at < 0 ? [[], lights] : [lights.slice(0, at), lights.slice(at + 1)];
  if (after === null) return [...first, ...rest];
  return at < 0 && isEnvironment(after) ? [...lights, after] : [...first, after, ...rest];
}

/** @param {Pick<Scene, "lights">} scene @param {Light|null} lamp null to remove it */
export const withLamp = (scene, lamp) => ({
  lights: replaced(scene.lights ?? [], lampOf(scene), lamp),
});

/** @param {Pick<Scene, "lights">} scene @param {Light|null} environment null to remove it */
export const withEnvironment = (scene, environment) => ({
  lights: replaced(scene.lights ?? [], environmentOf(scene), environment),
});
