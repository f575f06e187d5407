Burley's principled model, in WGSL: the parts that it does not share with microfacets. CPU twin:
brood-brdf's model/principled.rs; GLSL twin: principled.glsl.
// @body
// Body, times pi: darker at grazing angles where smooth, brighter there where rough.
fn brood_body(p: BroodPair, roughness: f32) -> f32 {
  let fi = brood_fifth(1.0 - p.wi.z);
  let fo = brood_fifth(1.0 - p.wo.z);
  let retro = 2.0 * roughness * p.c * p.c;
  let even = brood_product(1.0 - 0.5 * fi, 1.0 - 0.5 * fo);
  let both = brood_hold(fi + fo) + brood_product(fi, fo) * (retro - 1.0);
  return even + retro * both;
}

// @clear_coat
// F D G / (cos_i cos_o) of the clear coat; height and alpha2 of its distribution D, shadow: alpha^2
// of its shadowing.
fn brood_clear_coat(p: BroodPair, height: f32, alpha2: f32, f0: f32, shadow: f32) -> f32 {
  let d = height / (p.sin2_h + alpha2 * p.h.z * p.h.z);
  let unmasked = brood_product(brood_ggx_unmasked(p.wi, vec2f(shadow)), brood_ggx_unmasked(p.wo, vec2f(shadow)));
  return (f0 + (1.0 - f0) * brood_fifth(p.off_c)) * d / unmasked;
}

