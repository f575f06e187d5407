/**
 * Control images of a painted material: the places of its effects that can have one, in words, and
 * its genome with an image set or removed. Pure functions.
 *
 * @import { Effect, EffectImage, GenomeJson, ImagePlace } from "../model.js"
 */

/** Places of an effect that adds one colour. */
const OVERLAY = { image: "colour", map: "strength" };

/** Words of the places by effect and name. @type {Record<string, Record<string, string>>} */
const WORDS = {
  light: { dark: "dark colour", bright: "bright colour", map: "brush" },
  silhouette: OVERLAY,
  highlight: OVERLAY,
  distance: OVERLAY,
  glass: { map: "strength" },
};

/** Brush of a light that gets a map and has none: at 0 the map would not show. */
const BRUSH = 0.5;

/** Key of a place in lists. @param {ImagePlace} place */
export const placeKey = ({ effect, name }) => `${effect}.${name}`;

/**
 * Places of effects that can have an image, in order.
 * @param {Pick<Effect, "effect">[]} effects
 * @returns {ImagePlace[]}
 */
export const placesOf = (effects) =>
  effects.flatMap(({ effect }) =>
    Object.keys(WORDS[effect] ?? {}).map((name) => ({ effect, name })),
  );

/** A place in words: "bright colour of the light". @param {ImagePlace} place */
export const placeInWords = ({ effect, name }) =>
  `${WORDS[effect]?.[name] ?? name} of the ${effect}`;

/** Name of an image in the table of its effect: "bright image", "map". @param {string} name */
export const imageName = (name) => (name === "dark" || name === "bright" ? `${name} image` : name);

/** A share in words. @param {number} share 0 to 1 */
export const percent = (share) => `${Math.round(100 * share)} %`;

/**
 * The image in a place; null if it has none.
 * @param {Effect[]} effects
 * @param {ImagePlace} place
 */
export const imageIn = (effects, { effect, name }) =>
  effects.find((one) => one.effect === effect)?.images.find((one) => one.name === name) ?? null;

const HASH = /^[0-9a-f]{64}$/;

/**
 * Reads a line of an effect in a genome's text that sets an image; null for other lines.
 * @param {string} line "bright <id> 0.8"
 * @returns {EffectImage|null}
 */
export function imageInLine(line) {
  const [name, image = "", share = "1"] = line.trim().split(/\s+/);
  return HASH.test(image) ? { name, image, share: Number(share) } : null;
}

/**
 * A genome with other parameters of one effect.
 * @param {GenomeJson} genome
 * @param {string} effect
 * @param {(parameters: Record<string, unknown>) => Record<string, unknown>} change
 * @returns {GenomeJson}
 */
const withParameters = (genome, effect, change) => ({
  ...genome,
  effects: genome.effects?.map((one) =>
    one.kind === effect ? { ...one, parameters: change(one.parameters) } : one,
  ),
});

/**
 * A genome with an image in a place.
 * @param {GenomeJson} genome
 * @param {ImagePlace} place
 * @param {{image: string, share: number}} of
 */
export const withImage = (genome, { effect, name }, { image, share }) =>
  withParameters(genome, effect, (parameters) => ({
    ...parameters,
    ...(effect === "light" && name === "map" && !parameters.brush ? { brush: BRUSH } : {}),
    [name]: { image, share },
  }));

/**
 * A genome without an image in a place.
 * @param {GenomeJson} genome
 * @param {ImagePlace} place
 */
export const withoutImage = (genome, { effect, name }) =>
  withParameters(genome, effect, ({ [name]: _, ...others }) => others);
