"use strict";
// Runs each program three times: on inputs computed by brood, where every bit must agree, once with
// the export for any texture position and once with the shorter export for the positions in use;
// then on the directions themselves, where the inputs are computed in f32 here and in f64 in brood.
// Then runs each model of the suite on directions; its errors are relative, and in units of the
// effect of rounding directions and parameters.
const data = JSON.parse(document.getElementById("data").textContent);
const gl = document.createElement("canvas").getContext("webgl2", { antialias: false, depth: false });

/** NaN bits that no program returns; marks pixels that were not drawn. */
const UNDRAWN = 0x7fffffff;

const bytes = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;

const floats = (base64) => new Float32Array(bytes(base64));

const doubles = (base64) => new Float64Array(bytes(base64));

function compile(fragment) {
  const program = gl.createProgram();
  const sources = [
    [gl.VERTEX_SHADER, "#version 300 es\nvoid main() { gl_Position = vec4(float(gl_VertexID & 1) * 4.0 - 1.0, float(gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }"],
    [gl.FRAGMENT_SHADER, fragment],
  ];
  for (const [kind, source] of sources) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

/** Texture of single floats with `width` values per row. */
function table(values, width) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, width, Math.max(1, values.length / width), 0, gl.RED, gl.FLOAT, values.length ? values : new Float32Array(width));
  return texture;
}

/** Returns the bits of red, green and blue of each sample. */
function run(source, call, values, width) {
  const text = `#version 300 es\n${source}\nprecision highp sampler2D;\nuniform sampler2D values;\nout uvec4 bits;\n` +
    "float at(int column, int row) { return texelFetch(values, ivec2(column, row), 0).r; }\n" +
    `void main() { int k = int(gl_FragCoord.x); bits = uvec4(floatBitsToUint(${call}), 0u); }`;
  const program = compile(text);
  const texture = table(values, width);
  gl.useProgram(program);
  // Cleared, so that stale pixels are not taken for results.
  gl.clearBufferuiv(gl.COLOR, 0, new Uint32Array([UNDRAWN, UNDRAWN, UNDRAWN, UNDRAWN]));
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const pixels = new Uint32Array(4 * data.samples);
  gl.readPixels(0, 0, data.samples, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, pixels);
  gl.deleteProgram(program);
  gl.deleteTexture(texture);
  if (gl.getError() !== gl.NO_ERROR || pixels.includes(UNDRAWN)) throw new Error("the shader drew nothing");
  return pixels;
}

/** Call of a function with the values of each row. */
const callOf = (name, rows) => `${name}(${Array.from({ length: rows }, (_, row) => `at(k, ${row})`).join(", ")})`;

/**
 * Runs a call with a program's inputs; passes the relative error of each value whose bits differ
 * from those of brood.
 */
function compareBits({ source, inputs, f }, call, count) {
  const wanted = floats(f);
  const wantedBits = new Uint32Array(wanted.buffer);
  const bits = new Uint32Array(1);
  const value = new Float32Array(bits.buffer);
  const found = run(source, call, floats(inputs), data.samples);
  for (let k = 0; k < data.samples; k++) {
    for (let channel = 0; channel < 3; channel++) {
      const place = channel * data.samples + k;
      bits[0] = found[4 * k + channel];
      // Some processors flush subnormal numbers to 0.
      if (bits[0] === wantedBits[place] || Math.max(Math.abs(value[0]), Math.abs(wanted[place])) < 2 ** -126) continue;
      count(Math.abs(value[0] - wanted[place]) / (1e-3 + Math.abs(wanted[place])));
    }
  }
}

/** GLSL arguments wi and wo of row k of the values. */
const directionsAt = () => [0, 3].map((first) => `vec3(at(${first}, k), at(${first + 1}, k), at(${first + 2}, k))`).join(", ");

const FRAME = "vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)";

/** Returns the errors of all models of a kind. */
function measureKind({ kind, median, units, cases }, directions) {
  const relative = [];
  let most = 0;
  let strange = 0;
  for (const { source, f, unit } of cases) {
    const found = new Float32Array(run(source, `evolved(${directionsAt()}, ${FRAME}, vec2(0.0))`, directions, 9).buffer);
    const [wanted, scale] = [doubles(f), doubles(unit)];
    for (let place = 0; place < wanted.length; place++) {
      const value = found[4 * Math.floor(place / 3) + (place % 3)];
      if (!(value >= 0 && value < Infinity)) strange += 1;
      const error = Math.abs(value - wanted[place]);
      // Exponentials underflow below the range of f32.
      if (wanted[place] > 1e-20) relative.push(error / wanted[place]);
      most = Math.max(most, error / scale[place]);
    }
  }
  relative.sort((a, b) => a - b);
  const at = (share) => relative[Math.min(relative.length - 1, Math.floor(relative.length * share))];
  const figures = { kind, median: at(0.5), p99: at(0.99), worst: at(1), units: most, strange };
  return { ...figures, kept: strange === 0 && figures.median <= median && most <= units };
}

async function measureModels(progress) {
  const directions = floats(data.models.directions);
  const found = [];
  for (const kind of data.models.kinds) {
    progress(kind.kind);
    await new Promise((resolve) => setTimeout(resolve));
    try {
      found.push(measureKind(kind, directions));
    } catch (error) {
      found.push({ kind: kind.kind, kept: false, error: String(error.message).slice(0, 500) });
    }
  }
  return found;
}

async function measure(progress) {
  const target = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32UI, data.samples, 1);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.viewport(0, 0, data.samples, 1);
  const directions = floats(data.directions);
  const bits = new Uint32Array(1);
  const value = new Float32Array(bits.buffer);
  const result = { programs: 0, exact: 0, values: 0, differing: 0, worst_relative: 0, within_exact: 0, within_differing: 0, styles: 0, styles_exact: 0, styles_differing: 0, directions_median: 0, directions_p99: 0, failures: [] };
  const errors = [];
  for (const [number, test] of data.tests.entries()) {
    progress(number);
    // Yields to the event loop between programs.
    await new Promise((resolve) => setTimeout(resolve));
    const wanted = floats(test.f);
    let differing = 0;
    let worst = 0;
    let within = 0;
    try {
      const call = callOf("evolved_program", test.rows);
      compareBits(test, call, (by) => ((differing += 1), (worst = Math.max(worst, by))));
      compareBits({ ...test, source: test.within }, call, () => (within += 1));
      result.values += 3 * data.samples;
      const free = run(test.source, `evolved(${directionsAt()}, ${FRAME}, vec2(at(6, k), at(7, k)))`, directions, 8);
      for (let k = 0; k < data.samples; k++) {
        for (let channel = 0; channel < 3; channel++) {
          bits[0] = free[4 * k + channel];
          const exact = wanted[channel * data.samples + k];
          errors.push(Math.abs(value[0] - exact) / (1e-3 + Math.abs(exact)));
        }
      }
    } catch (error) {
      result.failures.push({ program: number, error: String(error.message).slice(0, 500) });
      continue;
    }
    result.programs += 1;
    result.exact += differing === 0 ? 1 : 0;
    result.differing += differing;
    result.within_exact += within === 0 ? 1 : 0;
    result.within_differing += within;
    result.worst_relative = Math.max(result.worst_relative, worst);
  }
  for (const [number, style] of data.styles.entries()) {
    progress(`style ${number}`);
    await new Promise((resolve) => setTimeout(resolve));
    let differing = 0;
    try {
      for (const call of style.calls) {
        compareBits({ source: style.source, ...call }, call.code, () => (differing += 1));
      }
    } catch (error) {
      result.failures.push({ style: number, error: String(error.message).slice(0, 500) });
      continue;
    }
    result.styles += 1;
    result.styles_exact += differing === 0 ? 1 : 0;
    result.styles_differing += differing;
  }
  errors.sort((a, b) => a - b);
  result.directions_median = errors[Math.floor(errors.length / 2)];
  result.directions_p99 = errors[Math.floor(errors.length * 0.99)];
  return result;
}

async function show() {
  const output = document.getElementById("result");
  if (!gl) {
    output.textContent = JSON.stringify({ error: "this browser has no WebGL 2" });
    return;
  }
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const renderer = gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  const started = performance.now();
  const result = { renderer, ...(await measure((number) => (output.textContent = `running ${number} of ${data.tests.length}`))) };
  result.models = await measureModels((kind) => (output.textContent = `running ${kind}`));
  result.ms = Math.round(performance.now() - started);
  const kept = result.models.filter(({ kept }) => kept).length;
  const rows = [
    ["Graphics processor", renderer],
    ["Programs with the same bits", `${result.exact} of ${result.programs}`],
    ["Values that differ", `${result.differing} of ${result.values}, largest relative error ${result.worst_relative.toExponential(1)}`],
    ["Same bits in the shorter export", `${result.within_exact} of ${result.programs}, ${result.within_differing} values differ`],
    ["Painted materials with the same bits", `${result.styles_exact} of ${result.styles}, ${result.styles_differing} values differ`],
    ["Error from directions in f32", `${result.directions_median.toExponential(1)} in the median, ${result.directions_p99.toExponential(1)} at the 99th percentile`],
    ["Programs refused by the compiler", String(result.failures.length)],
    ["Kinds of model within their bounds", `${kept} of ${result.models.length}`],
    ...result.models.map(({ kind, median, worst, units, error }) => [kind, error ?? `relative error ${median.toExponential(1)} in the median, ${worst.toExponential(1)} at most, ${units.toFixed(1)} units`]),
  ];
  const body = document.getElementById("rows");
  for (const [name, text] of rows) {
    const row = body.insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = text;
  }
  output.textContent = JSON.stringify(result);
}

addEventListener("load", () => void show());
