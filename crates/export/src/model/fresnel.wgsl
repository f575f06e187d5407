Fresnel reflectance. CPU twin: brood-brdf's model/fresnel.rs, in forms that do not subtract nearly
equal values (docs/maths/shading.md).
// @fifth
// m^5; (1 - c)^5 for m = 1 - c.
fn brood_fifth(m: f32) -> f32 {
  let a: f32 = clamp(m, 0.0, 1.0);
  let a2: f32 = a * a;
  return a2 * a2 * a;
}

// @schlick
// Schlick's reflectance, given f0 at normal incidence and off = 1 - c.
fn brood_schlick(f0: vec3f, off: f32) -> vec3f {
  return f0 + (1.0 - f0) * brood_fifth(off);
}

// @dielectric
// Reflectance of a smooth boundary to a medium of refractive index eta >= 1 at the cosine c;
// e = eta^2 - 1.
fn brood_dielectric(e: f32, c: f32) -> f32 {
  let g: f32 = sqrt(e + c * c);
  let p: f32 = c + g;
  let q: f32 = (e + 1.0) * c + g;
  let perpendicular: f32 = e / (p * p);
  let parallel: f32 = e * ((e + 2.0) * (c * c) - 1.0) / (q * q);
  return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

// @transmitted
// Transmittance of that boundary, 1 - brood_dielectric.
fn brood_transmitted(e: f32, c: f32) -> f32 {
  let g: f32 = sqrt(e + c * c);
  let p: f32 = c + g;
  let q: f32 = (e + 1.0) * c + g;
  return 2.0 * c * g * (1.0 / (p * p) + (e + 1.0) / (q * q));
}

// @metal
// Reflectance of a smooth metal of index eta + i k; d = eta^2 - k^2, d_1 = d - 1, b = 4 eta^2 k^2.
fn brood_metal(p: BroodPair, d: f32, d_1: f32, b: f32) -> f32 {
  let cos2: f32 = p.c * p.c;
  let sin2: f32 = p.off_c * (1.0 + p.c);
  // u^2 and v^2 of u + i v = sqrt(eta^2 - k^2 - sin^2 + 2 i eta k), without cancellation.
  let t: f32 = d - sin2;
  let large: f32 = 0.5 * (sqrt(t * t + b) + abs(t));
  let small: f32 = 0.25 * b / large;
  let u: f32 = sqrt(select(small, large, t > 0.0));
  let v2: f32 = select(large, small, t > 0.0);
  var minus: f32 = (d_1 + v2) / (u + p.c);
  var plus: f32 = u + p.c;
  let perpendicular: f32 = (minus * minus + v2) / (plus * plus + v2);
  minus = p.c * u - sin2;
  plus = p.c * u + sin2;
  let parallel: f32 = (minus * minus + cos2 * v2) / (plus * plus + cos2 * v2);
  return 0.5 * perpendicular * (1.0 + parallel);
}

