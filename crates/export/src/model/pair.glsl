A pair of directions with the quantities that models read, in GLSL. CPU twin: brood-brdf's block.rs;
WGSL twin: pair.wgsl. The text above the first mark is not exported; each mark begins a function
that library.rs includes if it is called.
// @pair
// Two directions in the local frame (z = n, x = u), both above the surface, with their half vector
// h and c = h . wi = h . wo. off_c = 1 - c, off_h = 1 - h.z and sin2_h = sin^2 of h are computed
// separately, because differences of cosines near 1 lose all digits.
struct BroodPair {
  vec3 wi;
  vec3 wo;
  vec3 h;
  float c;
  float off_c;
  float off_h;
  float sin2_h;
};

BroodPair brood_pair(vec3 wi, vec3 wo) {
  vec3 sum = wi + wo;
  vec3 difference = wi - wo;
  float size = sqrt(dot(sum, sum));
  vec3 h = sum / size;
  float c = min(0.5 * size, 1.0);
  float sin2_h = dot(h.xy, h.xy);
  float off_c = 0.25 * dot(difference, difference) / (1.0 + c);
  return BroodPair(wi, wo, h, c, off_c, sin2_h / (1.0 + h.z), sin2_h);
}

