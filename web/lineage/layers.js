/**
 * Models of reflectance that a genome has besides its program: parsed from the genome's text, and
 * in words. Pure functions, independent of the single models.
 *
 * @import { Genome, Individual, Lineage, Locks, Parameter } from "../model.js"
 */
import { colorCode } from "../page/srgb.js";
import { imageInLine, imageName } from "./images.js";

/** @param {string} line "roughness 0.2", "f0 1 0.7 0.3", "distribution ggx" @returns {Parameter} */
function parameterIn(line) {
  const [name, ...words] = line.trim().split(/\s+/);
  const numbers = words.map(Number);
  return { name, value: numbers.every(Number.isFinite) ? numbers : words.join(" ") };
}

/**
 * True if a line of a genome's text belongs to a model: its name or a parameter. Instructions are
 * in capitals.
 * @param {string} line
 */
export const isOfLayer = (line) => /^(\.model\s|[a-z_])/.test(line) && !/^brood\s/.test(line);

/** @param {string} text a genome as the server writes it @returns {Genome} */
export function genomeIn(text) {
  /** @type {Genome} */
  const found = {
    instructions: 0,
    machine: /^\.dialect (.*)$/m.exec(text)?.[1] ?? "",
    constants: [],
    layers: [],
    effects: [],
  };
  const constants = new Set();
  for (const line of text.split("\n")) {
    const [, part, name] = /^\.(model|effect)\s+(\S+)/.exec(line) ?? [];
    if (part === "model") found.layers.push({ model: name, parameters: [] });
    else if (part === "effect") found.effects.push({ effect: name, parameters: [], images: [] });
    else if (isOfLayer(line)) {
      const image = found.effects.length > 0 ? imageInLine(line) : null;
      if (image) found.effects.at(-1)?.images.push(image);
      else (found.effects.at(-1) ?? found.layers.at(-1))?.parameters.push(parameterIn(line));
    } else if (/^[A-Z]/.test(line)) {
      found.instructions += 1;
      for (const [, number] of line.matchAll(/\bC(\d+)\b/g)) constants.add(Number(number));
    }
  }
  found.constants = [...constants];
  return found;
}

/**
 * Kind of a lineage without programs, in a word; empty for others.
 * @param {Pick<Lineage, "start"|"dialect">} of
 */
export const kindInWords = ({ start, dialect }) =>
  start === "painted" ? "painted" : dialect.length === 0 ? "models" : "";

/** Names of an individual's models, lowest first. @param {Individual} of @returns {string[]} */
export const modelsOf = (of) => of.layers ?? [];

/** True if an individual has models. @param {Individual|null} of */
export const isLayered = (of) => of !== null && modelsOf(of).length > 0;

/** Names of models, each once: "lambert, 2 ward". @param {string[]} models */
export function modelsInWords(models) {
  const counts = new Map();
  for (const model of models) counts.set(model, (counts.get(model) ?? 0) + 1);
  return [...counts].map(([model, count]) => (count > 1 ? `${count} ${model}` : model)).join(", ");
}

/**
 * Content of an individual in words: its live instructions, its models, or both.
 * @param {Individual} of
 */
export function makeupInWords(of) {
  const live = of.live_instructions;
  const parts = live > 0 || !isLayered(of) ? [`${live} live instructions`] : [];
  if (isLayered(of)) parts.push(modelsInWords(modelsOf(of)));
  return parts.join(", ");
}

/** Parameters that are colours; others have three numbers too, such as an index of refraction. */
const COLORS = new Set(["albedo", "base_color", "diffuse", "f0", "rho_d", "rho_s", "specular"]);

/** True if a parameter of this name and three numbers is a colour. @param {string} name */
export const isColor = (name) => COLORS.has(name);

/**
 * The colour of a parameter for the screen; null if it is not a colour, or one outside of sRGB.
 * @param {Parameter} of
 */
export function colorOf({ name, value }) {
  if (typeof value === "string" || value.length !== 3 || !isColor(name)) return null;
  if (value.some((part) => part < 0 || part > 1)) return null;
  return colorCode(value);
}

/** Colour codes of a painted genome's parameter; none if it has none. @param {Parameter} of */
export const codesOf = ({ value }) =>
  typeof value === "string" ? (value.match(/#[0-9a-f]{6}/g) ?? []) : [];

/** True if a genome is a painted material. @param {Genome|null|undefined} of */
export const isPainted = (of) => (of?.effects.length ?? 0) > 0;

/**
 * True if a genome is a painted material that paints what its BRDF reflects.
 * @param {Pick<Genome, "effects">|null|undefined} of
 */
export const isByBrdf = (of) =>
  of?.effects[0]?.parameters.some(({ name, value }) => name === "by" && value === "brdf") ?? false;

/** A parameter's name with spaces. @param {string} name */
export const plainName = (name) => name.replaceAll("_", " ");

/**
 * Splits locks into those that name something in a genome, and the names of the others.
 * @param {Locks} locks
 * @param {Genome} of
 * @returns {{kept: Locks, gone: string[]}}
 */
export function locksFor(locks, { instructions, layers, effects }) {
  /** @type {string[]} */
  const gone = [];
  /**
   * @template T
   * @param {T[]} list
   * @param {(one: T) => boolean} has
   * @param {(one: T) => string} words
   */
  const sift = (list, has, words) => list.filter((one) => has(one) || !gone.push(words(one)));
  const kept = {
    ...locks,
    instructions: sift(
      locks.instructions,
      (at) => at < instructions,
      (at) => `instruction ${at}`,
    ),
    constants: sift(
      locks.constants,
      () => instructions > 0,
      (at) => `constant ${at}`,
    ),
    layers: sift(
      locks.layers,
      (at) => at < layers.length,
      (at) => `model ${at + 1}`,
    ),
    parameters: sift(
      locks.parameters,
      ({ layer, name }) => layers[layer]?.parameters.some((one) => one.name === name) ?? false,
      ({ layer, name }) => `${plainName(name)} of model ${layer + 1}`,
    ),
    effects: sift(
      locks.effects,
      (kind) => effects.some((one) => one.effect === kind),
      (kind) => kind,
    ),
    effect_parameters: sift(
      locks.effect_parameters,
      ({ effect, name }) => {
        const of = effects.find((one) => one.effect === effect);
        return of !== undefined && [...of.parameters, ...of.images].some((one) => one.name === name);
      },
      ({ effect, name }) => `${imageName(plainName(name))} of ${effect}`,
    ),
    channels: sift(
      locks.channels,
      () => effects.length === 0 || isByBrdf({ effects }),
      (channel) => `channel ${channel}`,
    ),
  };
  return { kept, gone };
}

/**
 * Text for the lock that keeps a parameter besides its own: that of its whole model, or those of
 * channels. A channel keeps only its own part of a colour.
 * @param {Locks} locks
 * @param {number} layer
 * @param {Parameter} of
 */
export function parameterKeptBy(locks, layer, { value }) {
  if (locks.layers.includes(layer)) return "its model is locked";
  const color = typeof value !== "string" && value.length === 3;
  return locks.channels.length > (color ? 2 : 0) ? "by the locked channels" : "";
}
