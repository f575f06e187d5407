Elementary functions of models in f32, in GLSL, accurate to a few units in the last place, which
built-in functions need not be. CPU twin: brood-brdf's elementary.rs; WGSL twin: elementary.wgsl.
Range reductions and polynomials of exp and the angle are those of Cephes (Moshier 1989, expf.c and
asinf.c).
// @exp
// e^x, clamped to e^80; 0 for x below -87.
float brood_exp(float x) {
  float t = clamp(x, -87.0, 80.0);
  float k = floor(1.442695 * t + 0.5);
  float r = brood_hold(t - brood_product(k, 0.693359375)) + k * 2.1219444e-4;
  float p = 0.16666666 + r * (0.041665796 + r * (0.008333452 + r * (0.0013981999 + r * 1.987569e-4)));
  p = 1.0 + (r + r * r * (0.5 + r * p));
  return x < -87.0 ? 0.0 : p * uintBitsToFloat(uint(int(k) + 127) << 23);
}

// @expm1
// e^x - 1 for x in [0, 80].
float brood_expm1(float x) {
  float p = 0.041666668 + x * (0.008333334 + x * (0.0013888889 + x * (1.984127e-4 + x * 2.4801588e-5)));
  float low = x * (1.0 + x * (0.5 + x * (0.16666667 + x * p)));
  return x < 0.5 ? low : brood_exp(x) - 1.0;
}

// @ln
// Natural logarithm of a positive normal number.
float brood_ln(float x) {
  return 0.6931472 * brood_log2(x);
}

// @ln_cosine
// ln c for a cosine c; off = 1 - c, more accurate than c for c near 1.
float brood_ln_cosine(float c, float off) {
  float s = off / (2.0 - off);
  float z = s * s;
  float high = -2.0 * s * (1.0 + z * (0.33333334 + z * (0.2 + z * (0.14285715 + z * 0.11111111))));
  return off < 0.3 ? high : brood_ln(max(c, 1e-37));
}

// @power
// c^n for a cosine c; off = 1 - c, more accurate than c for c near 1. 0 unless c is above 0.
float brood_power(float c, float off, float n) {
  return c > 0.0 ? brood_exp(n * brood_ln_cosine(c, off)) : 0.0;
}

// @angle
// Angle in the first quadrant with this sine and cosine.
float brood_angle(float sine, float cosine) {
  float a = min(sine, cosine);
  bool is_far = a > 0.5;
  float z = is_far ? 0.5 * (1.0 - a) : a * a;
  float s = is_far ? sqrt(z) : a;
  float p = 0.1666675242 + z * (0.07495300269 + z * (0.045470026 + z * (0.02418131105 + z * 0.0421632)));
  p = s + s * z * p;
  float low = is_far ? 1.5707964 - 2.0 * p : p;
  return sine < cosine ? low : 1.5707964 - low;
}

// @erf
// Error function for x in [0, 6]: 1 - exp(-x^2) times a polynomial in (2 x - 3) / (x + 3).
float brood_erf(float x) {
  float t = (2.0 * x - 3.0) / (x + 3.0);
  float p = 6.8506366e-5 + t * (1.2672804e-4 + t * (-1.3260819e-5 + t * -4.017663e-6));
  p = -0.08162686 + t * (0.0233088335 + t * (-0.003955998 + t * p));
  p = 0.32158542 + t * (-0.368151565 + t * (0.20143879 + t * p));
  return 1.0 - brood_exp(-x * x) * p;
}

