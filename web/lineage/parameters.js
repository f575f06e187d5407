/**
 * Values of the parameters of models as the controls set them: positions of sliders, typed numbers,
 * colours, and the genome's text with other values. Pure functions.
 *
 * @import { Layer, ParameterInfo } from "../model.js"
 */
import { colorCode, linearOf } from "../page/srgb.js";
import { genomeIn, isColor, isOfLayer, plainName } from "./layers.js";

/** Significant digits of values set by a control. */
const DIGITS = 3;
/** A linear range is wide if its end is more than this many times the default. */
const WIDE = 100;

/**
 * Value from which the positions of a slider become logarithmic; null if they are linear. Ranges
 * far wider than their default would otherwise leave all usual values on one pixel.
 * @param {ParameterInfo} of
 */
function kneeOf({ range: [low, high], default: [usual] }) {
  return low >= 0 && usual > 0 && high > WIDE * usual ? usual / 10 : null;
}

/**
 * Position of a value on its slider: 0 at the least value, 1 at the largest.
 * @param {ParameterInfo} of
 * @param {number} value
 */
export function positionOf(of, value) {
  const [low, high] = of.range;
  if (of.scale === "logarithmic") return Math.log(value / low) / Math.log(high / low);
  const knee = kneeOf(of);
  if (knee === null) return (value - low) / (high - low);
  return Math.log1p((value - low) / knee) / Math.log1p((high - low) / knee);
}

/**
 * Value at a position of the slider, with few digits; the inverse of `positionOf`.
 * @param {ParameterInfo} of
 * @param {number} position 0 to 1
 */
export function valueAt(of, position) {
  const [low, high] = of.range;
  if (position <= 0) return low;
  if (position >= 1) return high;
  return Math.min(high, Math.max(low, Number(digitsAt(of, position))));
}

/**
 * Value at a position between the ends of the slider.
 * @param {ParameterInfo} of
 * @param {number} position
 */
function digitsAt(of, position) {
  const [low, high] = of.range;
  const width = high - low;
  if (of.scale === "logarithmic") return (low * (high / low) ** position).toPrecision(DIGITS);
  const knee = kneeOf(of);
  if (knee === null) return (low + width * position).toFixed(decimalsOf(width));
  return (low + knee * Math.expm1(position * Math.log1p(width / knee))).toPrecision(DIGITS);
}

/** Decimals that divide a range into about a thousand steps. @param {number} width */
const decimalsOf = (width) => Math.max(0, DIGITS - Math.floor(Math.log10(width)));

/** A value with four digits, for its field. @param {number} value */
export const shownValue = (value) => String(Number(value.toPrecision(4)));

/** A channel of a colour with three decimals, or two digits. @param {number} value */
export const shownChannel = (value) => String(Number(value.toPrecision(value < 0.1 ? 2 : 3)));

/** A typed text in a message. @param {string} text */
const cut = (text) => (text.length > 24 ? `${text.slice(0, 23)}…` : text);

const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

/**
 * Reads a typed value.
 * @param {ParameterInfo} of
 * @param {string} text
 * @param {string} [name] name in the message
 * @returns {{value: number, wrong: ""}|{value: null, wrong: string}} `wrong`: reason in words
 */
export function readValue(of, text, name = plainName(of.name)) {
  const [low, high] = of.range;
  // Some keyboards have a comma only.
  const plain = text.trim().replace(/^([^,.]*),([^,.]*)$/, "$1.$2");
  const bounds = `between ${low} and ${high}`;
  if (plain === "") return { value: null, wrong: `${name} must be ${bounds}, and is empty` };
  if (!NUMBER.test(plain))
    return { value: null, wrong: `${name} must be a number ${bounds}, got “${cut(text.trim())}”` };
  const value = Number(plain);
  if (!(value >= low && value <= high))
    return { value: null, wrong: `${name} must be ${bounds}, got ${cut(plain)}` };
  return { value, wrong: "" };
}

/** True if a colour picker can set a parameter. @param {ParameterInfo} of */
export const isPicked = ({ kind, name, range: [low, high] }) =>
  kind === "color" && isColor(name) && low <= 0 && high >= 1;

/** The colour that the picker shows: the nearest of the screen's. @param {number[]} channels */
export const pickerColor = (channels) =>
  colorCode(channels.map((x) => Math.min(1, Math.max(0, x))));

/** Linear channels of a picked colour, with four digits. @param {string} color */
export const pickedChannels = (color) =>
  linearOf(color).map((channel) => Number(channel.toPrecision(4)));

/**
 * A genome's text with other values of its models' parameters.
 * @param {string} text as the server writes it
 * @param {Layer[]} layers
 */
export function withParameters(text, layers) {
  let at = -1;
  let isOfEffect = false;
  const lines = text.split("\n").map((line) => {
    // Lines of effects follow those of models.
    isOfEffect ||= line.startsWith(".effect");
    if (isOfEffect || !isOfLayer(line)) return line;
    if (line.startsWith(".")) {
      at += 1;
      return line;
    }
    const name = line.split(/\s/, 1)[0];
    const now = layers[at]?.parameters.find((one) => one.name === name);
    if (!now) return line;
    return `${name} ${typeof now.value === "string" ? now.value : now.value.join(" ")}`;
  });
  return lines.join("\n");
}

/**
 * Layers with another value of one parameter.
 * @param {Layer[]} layers
 * @param {number} layer
 * @param {string} name
 * @param {number[]|string} value
 * @returns {Layer[]}
 */
export const withValue = (layers, layer, name, value) =>
  layers.map((one, at) =>
    at === layer
      ? {
          ...one,
          parameters: one.parameters.map((it) => (it.name === name ? { ...it, value } : it)),
        }
      : one,
  );

/** True if a text has the values of these layers. @param {string} text @param {Layer[]} layers */
export const hasValues = (text, layers) =>
  JSON.stringify(genomeIn(text).layers) === JSON.stringify(layers);
