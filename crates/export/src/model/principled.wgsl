Burley's principled model: the parts that it does not share with microfacets. CPU twin: brood-brdf's
model/principled.rs.
// @body
// Body, times pi: darker at grazing angles where smooth, brighter there where rough.
fn brood_body(p: BroodPair, roughness: f32) -> f32 {
  let fi: f32 = brood_fifth(1.0 - p.wi.z);
  let fo: f32 = brood_fifth(1.0 - p.wo.z);
  let retro: f32 = 2.0 * roughness * p.c * p.c;
  let even: f32 = brood_product(1.0 - 0.5 * fi, 1.0 - 0.5 * fo);
  let both: f32 = brood_hold(fi + fo) + brood_product(fi, fo) * (retro - 1.0);
  return even + retro * both;
}

// @clear_coat
// F D G / (cos_i cos_o) of the clear coat; height and alpha2 of its distribution D, shadow: alpha^2
// of its shadowing.
fn brood_clear_coat(p: BroodPair, height: f32, alpha2: f32, f0: f32, shadow: f32) -> f32 {
  let d: f32 = height / (p.sin2_h + alpha2 * p.h.z * p.h.z);
  let unmasked: f32 = brood_product(brood_ggx_unmasked(p.wi, vec2f(shadow)), brood_ggx_unmasked(p.wo, vec2f(shadow)));
  return (f0 + (1.0 - f0) * brood_fifth(p.off_c)) * d / unmasked;
}

