Microfacets, in GLSL: distributions of their normals, and their shadowing and masking, which
includes the factor 1 / (4 cos_i cos_o) because that alone would be infinite at grazing angles. CPU
twin: brood-brdf's model/microfacet.rs; WGSL twin: facet.wgsl.
// @ggx
// D of GGX; inverse: 1 / alpha along u and v; height: D along the normal.
float brood_ggx(BroodPair p, vec2 inverse, float height) {
  vec2 s = p.h.xy * inverse;
  float q = dot(s, s) + p.h.z * p.h.z;
  return height / (q * q);
}

// @ggx_unmasked
// cos(w) / G1(w) of GGX, with Smith's masking G1; alpha2: alpha^2 along u and v.
float brood_ggx_unmasked(vec3 w, vec2 alpha2) {
  return 0.5 * (w.z + sqrt(w.z * w.z + dot(alpha2, w.xy * w.xy)));
}

// @slope2
// Squared slope of h, in units of the roughness.
float brood_slope2(BroodPair p, vec2 inverse) {
  vec2 s = p.h.xy * inverse / p.h.z;
  return dot(s, s);
}

// @gaussian_over_cos4
// exp(-slope^2) / h.z^4 as one exponential, because its factors would overflow and underflow.
float brood_gaussian_over_cos4(BroodPair p, vec2 inverse) {
  return brood_exp(-brood_slope2(p, inverse) - 4.0 * brood_ln_cosine(p.h.z, p.off_h));
}

// @gaussian_angle
// Gaussian of the angle between h and the normal, in units of the roughness.
float brood_gaussian_angle(BroodPair p, float inverse) {
  float theta = inverse * brood_angle(sqrt(p.sin2_h), p.h.z);
  return brood_exp(-theta * theta);
}

// @beckmann_unmasked
// cos(w) / G1(w) of Beckmann, with Smith's masking G1.
float brood_beckmann_unmasked(vec3 w, vec2 alpha2) {
  float across = sqrt(dot(alpha2, w.xy * w.xy));
  float a = min(w.z / max(across, 1e-30), 6.0);
  float masked = 0.5 * (w.z * (1.0 + brood_erf(a)) + across * (0.5641896 * brood_exp(-a * a)));
  return a < 6.0 ? masked : w.z;
}

// @smith
// G / (4 cos_i cos_o), with independent masking of both directions; arguments are cos / G1.
float brood_smith(float unmasked_i, float unmasked_o) {
  return 0.25 / (unmasked_i * unmasked_o);
}

// @smith_correlated
// G / (4 cos_i cos_o), with height-correlated masking; arguments are cos / G1.
float brood_smith_correlated(BroodPair p, float unmasked_i, float unmasked_o) {
  float both = brood_hold(brood_product(p.wo.z, unmasked_i) + brood_product(p.wi.z, unmasked_o));
  return 0.25 / (both - brood_product(p.wi.z, p.wo.z));
}

// @groove
// G / (4 cos_i cos_o) of V-shaped grooves.
float brood_groove(BroodPair p) {
  return min(0.25 / (p.wi.z * p.wo.z), p.h.z / (2.0 * p.c * max(p.wi.z, p.wo.z)));
}

