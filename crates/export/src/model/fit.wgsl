Models for fits of measured materials. CPU twin: brood-brdf's model/fit.rs.
// @abc
// Highlight of ABC; b and c as in the source, e = eta^2 - 1.
fn brood_abc(p: BroodPair, b: f32, c: f32, e: f32) -> f32 {
  let d: f32 = brood_exp(-c * brood_ln(1.0 + b * p.off_h));
  return brood_dielectric(e, p.c) * d * (4.0 * brood_groove(p));
}

// @sgd
// A channel of the shifted gamma distribution, named as in the source, except: diffuse and weight
// are divided by their powers of pi, ln_k is ln K, ln_c is ln c, shade is lambda.
struct BroodSgd {
  diffuse: f32,
  weight: f32,
  alpha: f32,
  p: f32,
  f0: f32,
  f1: f32,
  ln_k: f32,
  shade: f32,
  ln_c: f32,
  k: f32,
  theta0: f32,
}

fn brood_sgd_shadow(w: vec3f, s: BroodSgd) -> f32 {
  let past: f32 = brood_angle(sqrt(dot(w.xy, w.xy)), w.z) - s.theta0;
  // c past^k, which is c if k is 0.
  var x: f32 = brood_exp(min(s.ln_c + s.k * brood_ln(max(past, 1e-37)), 4.0));
  x = select(0.0, x, (past > 0.0) || (s.k == 0.0));
  return clamp(1.0 - s.shade * brood_expm1(x), 0.0, 1.0);
}

fn brood_sgd(p: BroodPair, s: BroodSgd) -> f32 {
  let fresnel: f32 = s.f0 - p.c * s.f1 + brood_fifth(p.off_c) * (1.0 - s.f0);
  let a: f32 = s.alpha + p.sin2_h / (p.h.z * p.h.z) / s.alpha;
  let seen: f32 = brood_product(brood_sgd_shadow(p.wi, s), brood_sgd_shadow(p.wo, s));
  let weight: f32 = s.weight * fresnel * seen / brood_product(p.wi.z, p.wo.z);
  // D is applied as two equal factors, each within the range of f32.
  let root: f32 = brood_exp(0.5 * clamp(s.ln_k - a - s.p * brood_ln(a) - 4.0 * brood_ln_cosine(p.h.z, p.off_h), -170.0, 50.0));
  return max(s.diffuse + clamp(weight * root, -1e20, 1e20) * root, 0.0);
}

