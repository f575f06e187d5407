/**
 * Normal maps of the parts of a scene that the page controls. Pure functions.
 *
 * @import { NormalMap, Scene } from "../model.js"
 *
 * @typedef {"subject"|"neighbour"|"ground"} Part `subject`: the object that is bred; `neighbour`:
 *   the first other object
 */

/** Strength and number of repetitions of a map that names none. */
export const PLAIN = { strength: 1, repeat: 1 };

/**
 * Normal map of a part; null if it has none.
 * @param {Scene|null} scene
 * @param {Part} part
 * @returns {NormalMap|null}
 */
export function normalMapOf(scene, part) {
  if (part === "subject") return scene?.normal_map ?? null;
  const of = part === "neighbour" ? scene?.objects?.[0] : scene?.ground;
  return of?.normal_map ?? null;
}

/**
 * Changes of a scene that give a part a normal map; none if the scene lacks the part.
 * @param {Scene} scene
 * @param {Part} part
 * @param {NormalMap|null} map null to remove it
 * @returns {Partial<Scene>}
 */
export function withNormalMap({ objects, ground }, part, map) {
  const normal_map = map ?? undefined;
  if (part === "subject") return { normal_map };
  if (part === "ground") return ground ? { ground: { ...ground, normal_map } } : {};
  const [first, ...others] = objects ?? [];
  return first ? { objects: [{ ...first, normal_map }, ...others] } : {};
}

/** True if any part has a normal map. @param {Scene} scene */
export const hasNormalMaps = ({ normal_map, objects, ground }) =>
  [{ normal_map }, ...(objects ?? []), ground].some((one) => one?.normal_map);

/** A number of a control in words: at most two decimals. @param {number} value */
export const short = (value) => String(Number(value.toFixed(2)));
