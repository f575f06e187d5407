Elementary functions of models in f32, accurate to a few units in the last place, which built-in
functions need not be. CPU twin: brood-brdf's elementary.rs.
Range reductions and polynomials of exp and the angle are those of Cephes (Moshier 1989, expf.c and
asinf.c).
// @exp
// e^x, clamped to e^80; 0 for x below -87.
fn brood_exp(x: f32) -> f32 {
  let t: f32 = clamp(x, -87.0, 80.0);
  let k: f32 = floor(1.442695 * t + 0.5);
  let r: f32 = brood_hold(t - brood_product(k, 0.693359375)) + k * 2.1219444e-4;
  var p: f32 = 0.16666666 + r * (0.041665796 + r * (0.008333452 + r * (0.0013981999 + r * 1.987569e-4)));
  p = 1.0 + (r + r * r * (0.5 + r * p));
  return select(p * bitcast<f32>(u32(i32(k) + 127) << 23u), 0.0, x < -87.0);
}

// @expm1
// e^x - 1 for x in [0, 80].
fn brood_expm1(x: f32) -> f32 {
  let p: f32 = 0.041666668 + x * (0.008333334 + x * (0.0013888889 + x * (1.984127e-4 + x * 2.4801588e-5)));
  let low: f32 = x * (1.0 + x * (0.5 + x * (0.16666667 + x * p)));
  return select(brood_exp(x) - 1.0, low, x < 0.5);
}

// @ln
// Natural logarithm of a positive normal number.
fn brood_ln(x: f32) -> f32 {
  return 0.6931472 * brood_log2(x);
}

// @ln_cosine
// ln c for a cosine c; off = 1 - c, more accurate than c for c near 1.
fn brood_ln_cosine(c: f32, off: f32) -> f32 {
  let s: f32 = off / (2.0 - off);
  let z: f32 = s * s;
  let high: f32 = -2.0 * s * (1.0 + z * (0.33333334 + z * (0.2 + z * (0.14285715 + z * 0.11111111))));
  return select(brood_ln(max(c, 1e-37)), high, off < 0.3);
}

// @power
// c^n for a cosine c; off = 1 - c, more accurate than c for c near 1. 0 unless c is above 0.
fn brood_power(c: f32, off: f32, n: f32) -> f32 {
  return select(0.0, brood_exp(n * brood_ln_cosine(c, off)), c > 0.0);
}

// @angle
// Angle in the first quadrant with this sine and cosine.
fn brood_angle(sine: f32, cosine: f32) -> f32 {
  let a: f32 = min(sine, cosine);
  let is_far: bool = a > 0.5;
  let z: f32 = select(a * a, 0.5 * (1.0 - a), is_far);
  let s: f32 = select(a, sqrt(z), is_far);
  var p: f32 = 0.1666675242 + z * (0.07495300269 + z * (0.045470026 + z * (0.02418131105 + z * 0.0421632)));
  p = s + s * z * p;
  let low: f32 = select(p, 1.5707964 - 2.0 * p, is_far);
  return select(1.5707964 - low, low, sine < cosine);
}

// @erf
// Error function for x in [0, 6]: 1 - exp(-x^2) times a polynomial in (2 x - 3) / (x + 3).
fn brood_erf(x: f32) -> f32 {
  let t: f32 = (2.0 * x - 3.0) / (x + 3.0);
  var p: f32 = 6.8506366e-5 + t * (1.2672804e-4 + t * (-1.3260819e-5 + t * -4.017663e-6));
  p = -0.08162686 + t * (0.0233088335 + t * (-0.003955998 + t * p));
  p = 0.32158542 + t * (-0.368151565 + t * (0.20143879 + t * p));
  return 1.0 - brood_exp(-x * x) * p;
}

