/**
 * First guess of the circle that a ball covers in a picture. Pure functions.
 *
 * Edges are pixels where a channel changes most. Circles through three of them, whose gradients
 * point to or from the centre, are scored by how much of their outline lies on such edges. The
 * best is fitted to its edges, first coarsely, then in finer pictures.
 *
 * @import { Circle } from "./placement.js"
 * @import { Codes } from "./pixels.js"
 */
import { shrunk } from "./pixels.js";

/** Longer side of the picture in which the circle is found, and of that in which it is refined. */
const COARSE_PX = 280;
const FINE_PX = 960;
const TRIALS = 8000;
/** Largest number of edges that circles are scored by. */
const MOST_SCORED = 900;
/** Distance from the outline at which an edge lies on it, in the coarse picture. */
const NEAR_PX = 1.2;
/** Parts of the outline, and the least number that must lie on edges. */
const PARTS = 72;
const LEAST_PARTS = 26;
/** Least radius, relative to the shorter side. */
const LEAST_RADIUS = 0.06;
/** Distance at which the contrast of an edge is measured. */
const BESIDE_PX = 5;
/** Least gradient of an edge relative to that contrast; 4 where it is all within one pixel. */
const SHARP = 1.6;
/** Cosine of the largest angle between a gradient and the radius. */
const RADIAL = 0.9;

/** @typedef {{x: number, y: number, gx: number, gy: number, size: number}} Edge */

/**
 * Gradient of the channel that changes most at each pixel.
 * @param {Codes} of
 * @returns {{gx: Float32Array, gy: Float32Array, size: Float32Array}}
 */
function gradients({ width, height, data }) {
  const gx = new Float32Array(width * height);
  const gy = new Float32Array(width * height);
  const size = new Float32Array(width * height);
  for (let y = 1; y + 1 < height; y += 1) {
    for (let x = 1; x + 1 < width; x += 1) {
      const at = y * width + x;
      for (let channel = 0; channel < 3; channel += 1) {
        /** @param {number} dx @param {number} dy */
        const code = (dx, dy) => data[4 * (at + dy * width + dx) + channel];
        const across =
          code(1, -1) + 2 * code(1, 0) + code(1, 1) - code(-1, -1) - 2 * code(-1, 0) - code(-1, 1);
        const down =
          code(-1, 1) + 2 * code(0, 1) + code(1, 1) - code(-1, -1) - 2 * code(0, -1) - code(1, -1);
        const most = Math.hypot(across, down);
        if (most > size[at]) [gx[at], gy[at], size[at]] = [across / most, down / most, most];
      }
    }
  }
  return { gx, gy, size };
}

/**
 * Difference of the codes on both sides of an edge, in the channel that differs most.
 * @param {Codes} of
 * @param {number} x
 * @param {number} y
 * @param {number} gx
 * @param {number} gy
 */
function contrast({ width, height, data }, x, y, gx, gy) {
  /** @param {number} sign */
  const beside = (sign) => {
    const column = Math.max(0, Math.min(width - 1, Math.round(x + sign * BESIDE_PX * gx)));
    const row = Math.max(0, Math.min(height - 1, Math.round(y + sign * BESIDE_PX * gy)));
    return 4 * (row * width + column);
  };
  const [before, after] = [beside(-1), beside(1)];
  let most = 0;
  for (let channel = 0; channel < 3; channel += 1)
    most = Math.max(most, Math.abs(data[after + channel] - data[before + channel]));
  return most;
}

/**
 * Pixels whose gradient is the largest along it, without the weak ones and without gradual changes,
 * such as that to the dark side of the ball.
 * @param {Codes} of
 * @returns {Edge[]}
 */
function edgesOf(of) {
  const { width, height } = of;
  const { gx, gy, size } = gradients(of);
  const sorted = Float32Array.from(size).sort();
  const strong = Math.max(24, 0.12 * sorted[Math.floor(0.99 * (sorted.length - 1))]);
  const edges = [];
  for (let y = 1; y + 1 < height; y += 1) {
    for (let x = 1; x + 1 < width; x += 1) {
      const at = y * width + x;
      if (size[at] < strong) continue;
      const step = Math.round(gy[at]) * width + Math.round(gx[at]);
      const [before, after] = [size[at - step], size[at + step]];
      if (before > size[at] || after >= size[at]) continue;
      if (size[at] < SHARP * contrast(of, x, y, gx[at], gy[at])) continue;
      // Vertex of the parabola through the three sizes.
      const bend = before - 2 * size[at] + after;
      const shift = bend < 0 ? (0.5 * (before - after)) / bend : 0;
      const length = Math.hypot(Math.round(gx[at]), Math.round(gy[at]));
      edges.push({
        x: x + 0.5 + shift * gx[at] * length,
        y: y + 0.5 + shift * gy[at] * length,
        gx: gx[at],
        gy: gy[at],
        size: size[at],
      });
    }
  }
  return edges;
}

/**
 * Circle through three points; null if they are on a line.
 * @param {Edge} a
 * @param {Edge} b
 * @param {Edge} c
 * @returns {Circle|null}
 */
function through(a, b, c) {
  const [bx, by, cx, cy] = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y];
  const twice = 2 * (bx * cy - by * cx);
  if (Math.abs(twice) < 1e-6) return null;
  const [b2, c2] = [bx * bx + by * by, cx * cx + cy * cy];
  const x = (cy * b2 - by * c2) / twice;
  const y = (bx * c2 - cx * b2) / twice;
  return { x: a.x + x, y: a.y + y, radius: Math.hypot(x, y) };
}

/** True if the gradient of an edge is along the radius. @param {Edge} of @param {Circle} circle */
function isRadial({ x, y, gx, gy }, circle) {
  const [dx, dy] = [x - circle.x, y - circle.y];
  return Math.abs(dx * gx + dy * gy) > RADIAL * Math.hypot(dx, dy);
}

/** Edges on a circle. @param {Edge[]} edges @param {Circle} circle @param {number} near */
const edgesOn = (edges, circle, near) =>
  edges.filter(
    (edge) =>
      Math.abs(Math.hypot(edge.x - circle.x, edge.y - circle.y) - circle.radius) < near &&
      isRadial(edge, circle),
  );

/** Number of parts of the outline with an edge. @param {Edge[]} edges @param {Circle} circle */
function partsOf(edges, circle) {
  const parts = new Set();
  for (const { x, y } of edges) {
    const turn = Math.atan2(y - circle.y, x - circle.x) / (2 * Math.PI) + 0.5;
    parts.add(Math.floor(turn * PARTS) % PARTS);
  }
  return parts.size;
}

/**
 * Circle with the least squares of distances to edges, by three steps of Gauss and Newton.
 * @param {Edge[]} edges
 * @param {Circle} start
 * @returns {Circle}
 */
function fitted(edges, start) {
  let { x, y, radius } = start;
  for (let round = 0; round < 3; round += 1) {
    // Normal equations for the three parameters.
    const m = [0, 0, 0, 0, 0, 0];
    const v = [0, 0, 0];
    for (const edge of edges) {
      const [dx, dy] = [edge.x - x, edge.y - y];
      const length = Math.hypot(dx, dy) || 1;
      const [a, b, error] = [dx / length, dy / length, length - radius];
      m[0] += a * a;
      m[1] += a * b;
      m[2] += a;
      m[3] += b * b;
      m[4] += b;
      m[5] += 1;
      v[0] += a * error;
      v[1] += b * error;
      v[2] += error;
    }
    const solved = solve3(m, v);
    if (!solved) break;
    [x, y, radius] = [x + solved[0], y + solved[1], radius + solved[2]];
  }
  return { x, y, radius };
}

/**
 * Solution of three symmetric equations; null if they are singular.
 * @param {number[]} m upper triangle, row by row
 * @param {number[]} v
 */
export function solve3([a, b, c, d, e, f], [p, q, r]) {
  const [i, j, k] = [d * f - e * e, c * e - b * f, b * e - c * d];
  const determinant = a * i + b * j + c * k;
  if (Math.abs(determinant) < 1e-9 * Math.abs(a * d * f) || determinant === 0) return null;
  const [l, m, n] = [a * f - c * c, b * c - a * e, a * d - b * b];
  return [
    (i * p + j * q + k * r) / determinant,
    (j * p + l * q + m * r) / determinant,
    (k * p + m * q + n * r) / determinant,
  ];
}

/** Pseudo-random numbers from 0 to 1, the same each time. */
function randomNumbers() {
  let state = 12345;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/**
 * The circle of a coarse picture with the longest outline on edges; null if there is none.
 * @param {Codes} of
 * @returns {Circle|null}
 */
function found(of) {
  const edges = edgesOf(of);
  if (edges.length < LEAST_PARTS) return null;
  const random = randomNumbers();
  const any = () => edges[Math.floor(random() * edges.length)];
  const some = edges.length > MOST_SCORED ? Array.from({ length: MOST_SCORED }, any) : edges;
  const shorter = Math.min(of.width, of.height);
  const longer = Math.max(of.width, of.height);
  /** @type {Circle|null} */
  let best = null;
  let most = 0;
  for (let trial = 0; trial < TRIALS; trial += 1) {
    const [a, b, c] = [any(), any(), any()];
    const circle = through(a, b, c);
    if (!circle) continue;
    const { x, y, radius } = circle;
    if (radius < LEAST_RADIUS * shorter || radius > 0.7 * longer) continue;
    if (x < 0 || y < 0 || x > of.width || y > of.height) continue;
    if (![a, b, c].every((edge) => isRadial(edge, circle))) continue;
    const parts = partsOf(edgesOn(some, circle, NEAR_PX), circle);
    const score = parts * radius;
    if (parts >= LEAST_PARTS && score > most) [best, most] = [circle, score];
  }
  if (!best) return null;
  for (const near of [2, 1.5, 1]) best = fitted(edgesOn(edges, best, near), best);
  return best;
}

/**
 * Guesses the circle of a ball; null if the picture has no clear one.
 * @param {Codes} of
 * @returns {Circle|null}
 */
export function guessCircle(of) {
  const longer = Math.max(of.width, of.height);
  const coarse = Math.max(1, Math.ceil(longer / COARSE_PX));
  const start = found(shrunk(of, coarse));
  if (!start) return null;
  let circle = scaled(start, coarse);
  for (const px of [COARSE_PX * 2, FINE_PX]) {
    const step = Math.max(1, Math.ceil(longer / px));
    if (step >= coarse) continue;
    const edges = edgesOf(shrunk(of, step));
    let finer = scaled(circle, 1 / step);
    // The coarse circle is off by up to a pixel of its own.
    for (const near of [(0.8 * coarse) / step + 1, 2, 1.2]) {
      const on = edgesOn(edges, finer, near);
      if (partsOf(on, finer) < LEAST_PARTS) break;
      finer = fitted(on, finer);
    }
    circle = scaled(finer, step);
  }
  return circle;
}

/** @param {Circle} of @param {number} factor @returns {Circle} */
const scaled = ({ x, y, radius }, factor) => ({
  x: x * factor,
  y: y * factor,
  radius: radius * factor,
});
