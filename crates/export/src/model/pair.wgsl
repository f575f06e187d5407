A pair of directions with the quantities that models read. CPU twin: brood-brdf's block.rs.
// @pair
// Two directions in the local frame (z = n, x = u), both above the surface, with their half vector
// h and c = h . wi = h . wo. off_c = 1 - c, off_h = 1 - h.z and sin2_h = sin^2 of h are computed
// separately, because differences of cosines near 1 lose all digits.
struct BroodPair {
  wi: vec3f,
  wo: vec3f,
  h: vec3f,
  c: f32,
  off_c: f32,
  off_h: f32,
  sin2_h: f32,
}

fn brood_pair(wi: vec3f, wo: vec3f) -> BroodPair {
  let sum: vec3f = wi + wo;
  let difference: vec3f = wi - wo;
  let size: f32 = sqrt(dot(sum, sum));
  let h: vec3f = sum / size;
  let c: f32 = min(0.5 * size, 1.0);
  let sin2_h: f32 = dot(h.xy, h.xy);
  let off_c: f32 = 0.25 * dot(difference, difference) / (1.0 + c);
  return BroodPair(wi, wo, h, c, off_c, sin2_h / (1.0 + h.z), sin2_h);
}

