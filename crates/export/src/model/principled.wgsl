Burley's principled model, in WGSL: what it does not share with microfacets. CPU twin: brood-brdf's model/principled.rs; WGSL
twin: principled.wgsl.
// @body
// The body, times pi: darker at grazing light where it is smooth, brighter where it is rough.
fn brood_body(p: BroodPair, roughness: f32) -> f32 {
  let fi = brood_fifth(1.0 - p.wi.z);
  let fo = brood_fifth(1.0 - p.wo.z);
  let retro = 2.0 * roughness * p.c * p.c;
  let even = brood_product(1.0 - 0.5 * fi, 1.0 - 0.5 * fo);
  let both = brood_hold(fi + fo) + brood_product(fi, fo) * (retro - 1.0);
  return even + retro * both;
}

// @clear_coat
// The clear coat over 1 / (cos_i cos_o), of height and alpha^2; shadow is alpha^2 of its shadowing.
fn brood_clear_coat(p: BroodPair, height: f32, alpha2: f32, f0: f32, shadow: f32) -> f32 {
  let d = height / (p.sin2_h + alpha2 * p.h.z * p.h.z);
  let unmasked = brood_product(brood_ggx_unmasked(p.wi, vec2f(shadow)), brood_ggx_unmasked(p.wo, vec2f(shadow)));
  return (f0 + (1.0 - f0) * brood_fifth(p.off_c)) * d / unmasked;
}

