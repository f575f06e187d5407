Microfacets: distributions of their normals, and their shadowing and masking, which includes the
factor 1 / (4 cos_i cos_o) because that alone would be infinite at grazing angles. CPU twin:
brood-brdf's model/microfacet.rs.
// @ggx
// D of GGX; inverse: 1 / alpha along u and v; height: D along the normal.
fn brood_ggx(p: BroodPair, inverse: vec2f, height: f32) -> f32 {
  let s: vec2f = p.h.xy * inverse;
  let q: f32 = dot(s, s) + p.h.z * p.h.z;
  return height / (q * q);
}

// @ggx_unmasked
// cos(w) / G1(w) of GGX, with Smith's masking G1; alpha2: alpha^2 along u and v.
fn brood_ggx_unmasked(w: vec3f, alpha2: vec2f) -> f32 {
  return 0.5 * (w.z + sqrt(w.z * w.z + dot(alpha2, w.xy * w.xy)));
}

// @slope2
// Squared slope of h, in units of the roughness.
fn brood_slope2(p: BroodPair, inverse: vec2f) -> f32 {
  let s: vec2f = p.h.xy * inverse / p.h.z;
  return dot(s, s);
}

// @gaussian_over_cos4
// exp(-slope^2) / h.z^4 as one exponential, because its factors would overflow and underflow.
fn brood_gaussian_over_cos4(p: BroodPair, inverse: vec2f) -> f32 {
  return brood_exp(-brood_slope2(p, inverse) - 4.0 * brood_ln_cosine(p.h.z, p.off_h));
}

// @gaussian_angle
// Gaussian of the angle between h and the normal, in units of the roughness.
fn brood_gaussian_angle(p: BroodPair, inverse: f32) -> f32 {
  let theta: f32 = inverse * brood_angle(sqrt(p.sin2_h), p.h.z);
  return brood_exp(-theta * theta);
}

// @beckmann_unmasked
// cos(w) / G1(w) of Beckmann, with Smith's masking G1.
fn brood_beckmann_unmasked(w: vec3f, alpha2: vec2f) -> f32 {
  let across: f32 = sqrt(dot(alpha2, w.xy * w.xy));
  let a: f32 = min(w.z / max(across, 1e-30), 6.0);
  let masked: f32 = 0.5 * (w.z * (1.0 + brood_erf(a)) + across * (0.5641896 * brood_exp(-a * a)));
  return select(w.z, masked, a < 6.0);
}

// @smith
// G / (4 cos_i cos_o), with independent masking of both directions; arguments are cos / G1.
fn brood_smith(unmasked_i: f32, unmasked_o: f32) -> f32 {
  return 0.25 / (unmasked_i * unmasked_o);
}

// @smith_correlated
// G / (4 cos_i cos_o), with height-correlated masking; arguments are cos / G1.
fn brood_smith_correlated(p: BroodPair, unmasked_i: f32, unmasked_o: f32) -> f32 {
  let both: f32 = brood_hold(brood_product(p.wo.z, unmasked_i) + brood_product(p.wi.z, unmasked_o));
  return 0.25 / (both - brood_product(p.wi.z, p.wo.z));
}

// @groove
// G / (4 cos_i cos_o) of V-shaped grooves.
fn brood_groove(p: BroodPair) -> f32 {
  return min(0.25 / (p.wi.z * p.wo.z), p.h.z / (2.0 * p.c * max(p.wi.z, p.wo.z)));
}

