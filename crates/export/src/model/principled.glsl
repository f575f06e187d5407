Burley's principled model, in GLSL: what it does not share with microfacets. CPU twin: brood-brdf's model/principled.rs; WGSL
twin: principled.wgsl.
// @body
// The body, times pi: darker at grazing light where it is smooth, brighter where it is rough.
float brood_body(BroodPair p, float roughness) {
  float fi = brood_fifth(1.0 - p.wi.z);
  float fo = brood_fifth(1.0 - p.wo.z);
  float retro = 2.0 * roughness * p.c * p.c;
  float even = brood_product(1.0 - 0.5 * fi, 1.0 - 0.5 * fo);
  float both = brood_hold(fi + fo) + brood_product(fi, fo) * (retro - 1.0);
  return even + retro * both;
}

// @clear_coat
// The clear coat over 1 / (cos_i cos_o), of height and alpha^2; shadow is alpha^2 of its shadowing.
float brood_clear_coat(BroodPair p, float height, float alpha2, float f0, float shadow) {
  float d = height / (p.sin2_h + alpha2 * p.h.z * p.h.z);
  float unmasked = brood_product(brood_ggx_unmasked(p.wi, vec2(shadow)), brood_ggx_unmasked(p.wo, vec2(shadow)));
  return (f0 + (1.0 - f0) * brood_fifth(p.off_c)) * d / unmasked;
}

