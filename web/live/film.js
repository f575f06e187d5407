/**
 * Film of live frames in GLSL: tone curve and display transfer, as docs/maths/film.md defines them.
 *
 * The transfer approximates the sRGB curve to 4e-5 (a hundredth of a code) by square roots, which
 * cost a tenth of a power.
 */

/** Tone curves in the order of their numbers in the shader. */
const TONES = ["none", "reinhard", "filmic"];

/** Number of a tone curve in the shader. @param {string|undefined} tone */
export const toneNumber = (tone) => Math.max(0, TONES.indexOf(tone ?? "none"));

/** Declares `tone`, the number of the curve, and the functions `toned` and `srgb`. */
export const FILM = `
uniform int tone;

vec3 toned(vec3 exposed) {
  // 1e6 is white on every curve, and its square does not overflow.
  vec3 x = min(exposed, 1e6);
  vec3 filmic = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  return tone == 0 ? exposed : tone == 1 ? x / (1.0 + x) : filmic;
}

vec3 srgb(vec3 shown) {
  vec3 c = clamp(shown, 0.0, 1.0);
  vec3 second = sqrt(c);
  vec3 fourth = sqrt(second);
  vec3 eighth = sqrt(fourth);
  vec3 curve = 0.65398106 * second + 0.68871894 * fourth - 0.31847788 * eighth - 0.020186652 * c - 0.0040666777;
  return mix(curve, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}
`;

/**
 * Declares `gain` and `marks`, and the function `developed`: the codes of linear display values,
 * burnt-out and black pixels marked.
 */
export const DEVELOPED = `
uniform float gain;
uniform bool marks;

vec3 developed(vec3 shown, float coverage) {
  vec3 code = srgb(shown);
  // Diagonal stripes as in marks.js: two colours, then two transparent ones.
  int stripe = ((int(gl_FragCoord.x) + 8192 - int(gl_FragCoord.y)) & 7) >> 1;
  float strongest = max(shown.r, max(shown.g, shown.b));
  bool marked = marks && coverage == 1.0;
  bool burnt = marked && strongest > 1.0;
  bool black = marked && max(code.r, max(code.g, code.b)) < 0.5 / 255.0;
  code = mix(code, stripe == 0 ? vec3(1.0, 0.0, 0.7) : vec3(0.0), bvec3(burnt && stripe < 2));
  return mix(code, vec3(0.2, 0.55, 1.0), bvec3(black && stripe == 0));
}
`;
