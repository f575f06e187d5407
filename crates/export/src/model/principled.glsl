Burley's principled model, in GLSL: the parts that it does not share with microfacets. CPU twin:
brood-brdf's model/principled.rs; WGSL twin: principled.wgsl.
// @body
// Body, times pi: darker at grazing angles where smooth, brighter there where rough.
float brood_body(BroodPair p, float roughness) {
  float fi = brood_fifth(1.0 - p.wi.z);
  float fo = brood_fifth(1.0 - p.wo.z);
  float retro = 2.0 * roughness * p.c * p.c;
  float even = brood_product(1.0 - 0.5 * fi, 1.0 - 0.5 * fo);
  float both = brood_hold(fi + fo) + brood_product(fi, fo) * (retro - 1.0);
  return even + retro * both;
}

// @clear_coat
// F D G / (cos_i cos_o) of the clear coat; height and alpha2 of its distribution D, shadow: alpha^2
// of its shadowing.
float brood_clear_coat(BroodPair p, float height, float alpha2, float f0, float shadow) {
  float d = height / (p.sin2_h + alpha2 * p.h.z * p.h.z);
  float unmasked = brood_product(brood_ggx_unmasked(p.wi, vec2(shadow)), brood_ggx_unmasked(p.wo, vec2(shadow)));
  return (f0 + (1.0 - f0) * brood_fifth(p.off_c)) * d / unmasked;
}

