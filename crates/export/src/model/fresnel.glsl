Fresnel reflectance, in GLSL. CPU twin: brood-brdf's model/fresnel.rs, in forms that do not subtract
nearly equal values (docs/maths/shading.md); WGSL twin: fresnel.wgsl.
// @fifth
// m^5; (1 - c)^5 for m = 1 - c.
float brood_fifth(float m) {
  float a = clamp(m, 0.0, 1.0);
  float a2 = a * a;
  return a2 * a2 * a;
}

// @schlick
// Schlick's reflectance, given f0 at normal incidence and off = 1 - c.
vec3 brood_schlick(vec3 f0, float off) {
  return f0 + (1.0 - f0) * brood_fifth(off);
}

// @dielectric
// Reflectance of a smooth boundary to a medium of refractive index eta >= 1 at the cosine c;
// e = eta^2 - 1.
float brood_dielectric(float e, float c) {
  float g = sqrt(e + c * c);
  float p = c + g;
  float q = (e + 1.0) * c + g;
  float perpendicular = e / (p * p);
  float parallel = e * ((e + 2.0) * (c * c) - 1.0) / (q * q);
  return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

// @transmitted
// Transmittance of that boundary, 1 - brood_dielectric.
float brood_transmitted(float e, float c) {
  float g = sqrt(e + c * c);
  float p = c + g;
  float q = (e + 1.0) * c + g;
  return 2.0 * c * g * (1.0 / (p * p) + (e + 1.0) / (q * q));
}

// @metal
// Reflectance of a smooth metal of index eta + i k; d = eta^2 - k^2, d_1 = d - 1, b = 4 eta^2 k^2.
float brood_metal(BroodPair p, float d, float d_1, float b) {
  float cos2 = p.c * p.c;
  float sin2 = p.off_c * (1.0 + p.c);
  // u^2 and v^2 of u + i v = sqrt(eta^2 - k^2 - sin^2 + 2 i eta k), without cancellation.
  float t = d - sin2;
  float large = 0.5 * (sqrt(t * t + b) + abs(t));
  float small = 0.25 * b / large;
  float u = sqrt(t > 0.0 ? large : small);
  float v2 = t > 0.0 ? small : large;
  float minus = (d_1 + v2) / (u + p.c);
  float plus = u + p.c;
  float perpendicular = (minus * minus + v2) / (plus * plus + v2);
  minus = p.c * u - sin2;
  plus = p.c * u + sin2;
  float parallel = (minus * minus + cos2 * v2) / (plus * plus + cos2 * v2);
  return 0.5 * perpendicular * (1.0 + parallel);
}

