Models for fits of measured materials, in GLSL. CPU twin: brood-brdf's model/fit.rs; WGSL twin:
fit.wgsl.
// @abc
// Highlight of ABC; b and c as in the source, e = eta^2 - 1.
float brood_abc(BroodPair p, float b, float c, float e) {
  float d = brood_exp(-c * brood_ln(1.0 + b * p.off_h));
  return brood_dielectric(e, p.c) * d * (4.0 * brood_groove(p));
}

// @sgd
// A channel of the shifted gamma distribution, named as in the source, except: diffuse and weight
// are divided by their powers of pi, ln_k is ln K, ln_c is ln c.
struct BroodSgd {
  float diffuse;
  float weight;
  float alpha;
  float p;
  float f0;
  float f1;
  float ln_k;
  float lambda;
  float ln_c;
  float k;
  float theta0;
};

float brood_sgd_shadow(vec3 w, BroodSgd s) {
  float past = brood_angle(sqrt(dot(w.xy, w.xy)), w.z) - s.theta0;
  // c past^k, which is c if k is 0.
  float x = brood_exp(min(s.ln_c + s.k * brood_ln(max(past, 1e-37)), 4.0));
  x = past > 0.0 || s.k == 0.0 ? x : 0.0;
  return clamp(1.0 - s.lambda * brood_expm1(x), 0.0, 1.0);
}

float brood_sgd(BroodPair p, BroodSgd s) {
  float fresnel = s.f0 - p.c * s.f1 + brood_fifth(p.off_c) * (1.0 - s.f0);
  float a = s.alpha + p.sin2_h / (p.h.z * p.h.z) / s.alpha;
  float seen = brood_product(brood_sgd_shadow(p.wi, s), brood_sgd_shadow(p.wo, s));
  float weight = s.weight * fresnel * seen / brood_product(p.wi.z, p.wo.z);
  // D is applied as two equal factors, each within the range of f32.
  float root = brood_exp(0.5 * clamp(s.ln_k - a - s.p * brood_ln(a) - 4.0 * brood_ln_cosine(p.h.z, p.off_h), -170.0, 50.0));
  return max(s.diffuse + clamp(weight * root, -1e20, 1e20) * root, 0.0);
}

