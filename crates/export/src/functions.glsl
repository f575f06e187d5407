Canonical functions in GLSL. CPU twin: brood-genome's functions.rs, with the same constants, order
of operations and clamps, bit for bit; WGSL twin: functions.wgsl. `brood_hold` prevents compilers
from contracting or reassociating. Built-in sin, exp2, mix, pow, sqrt and division are not used
because drivers choose their errors. The text above the first mark is not exported; each mark begins
a function that library.rs picks by name.
// @base
// Every product and sum must be rounded separately. brood_zero must be set to 0: because compilers
// do not know its value, they cannot fuse operations across brood_hold.
uniform highp uint brood_zero;

float brood_hold(float a) {
  return uintBitsToFloat(floatBitsToUint(a) ^ brood_zero);
}

float brood_product(float a, float b) {
  return brood_hold(a * b);
}

float brood_limit(float a) {
  return clamp(a, -65504.0, 65504.0);
}

// a + b c, rounded twice.
float brood_step(float a, float b, float c) {
  return brood_hold(a + brood_product(b, c));
}

// @sine
// sin(t) if quarter is 0, cos(t) if it is 1; t in [-1024, 1024].
float brood_sine(float t, int quarter) {
  // Adding 1.5 2^23 rounds to the nearest integer, ties to even, and leaves it in the low bits.
  float m = brood_hold(brood_product(t, 0.63661975) + 12582912.0);
  float k = brood_hold(m - 12582912.0);
  float r = brood_hold(t - brood_product(k, 1.570556640625));
  r = brood_hold(r - brood_product(k, 0.0002396702766418457));
  r = brood_hold(r - brood_product(k, 1.5893254712295857e-8));
  float z = brood_product(r, r);
  float s = brood_step(-0.16666655, z, brood_step(0.008332179, z, -0.0001951727));
  s = brood_hold(r + brood_product(brood_product(r, z), s));
  float c = brood_step(0.041666646, z, brood_step(-0.0013887375, z, 2.443912e-5));
  c = brood_hold(brood_hold(1.0 - brood_product(0.5, z)) + brood_product(brood_product(z, z), c));
  uint quadrant = floatBitsToUint(m) + uint(quarter);
  float value = (quadrant & 1u) == 0u ? s : c;
  return uintBitsToFloat(floatBitsToUint(value) ^ ((quadrant & 2u) << 30));
}

// @ex2
// 2^t for t in [-24, 16].
float brood_ex2(float t) {
  // As in the sine: rounds to the nearest integer and leaves it in the low bits.
  float m = brood_hold(t + 12582912.0);
  float f = brood_hold(t - brood_hold(m - 12582912.0));
  float p = brood_step(0.009618006, f, brood_step(0.0013400249, f, 0.00015475875));
  p = brood_step(0.6931472, f, brood_step(0.2402265, f, brood_step(0.05550328, f, p)));
  p = brood_step(1.0, f, p);
  return p * uintBitsToFloat((floatBitsToUint(m) << 23) + 0x3f800000u);
}

// @log2
// log2 of a positive normal number.
float brood_log2(float t) {
  uint bits = floatBitsToUint(t);
  uint offset = (bits - 0x3f3504f3u) & 0xff800000u;
  float exponent = float(int(offset) >> 23);
  float f = brood_hold(uintBitsToFloat(bits - offset) - 1.0);
  float p = brood_step(-0.1906129, f, brood_step(0.1878259, f, -0.112973355));
  p = brood_step(0.28858528, f, brood_step(-0.23963657, f, brood_step(0.20429617, f, p)));
  p = brood_step(-0.72134733, f, brood_step(0.4808979, f, brood_step(-0.36069643, f, p)));
  p = brood_product(f, brood_step(1.442695, f, p));
  return brood_hold(exponent + p);
}

// @square
// a^2 + 2^-24.
float brood_square(float a) {
  return brood_hold(brood_product(a, a) + 5.9604645e-8);
}

// @lg2
// log2(a^2 + 2^-24).
float brood_lg2(float a) {
  return brood_log2(brood_square(a));
}

// @rcp
// a / (a^2 + 2^-24).
float brood_rcp(float a) {
  float t = brood_square(a);
  float y = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(t));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  return brood_limit(a * y);
}

// @rsq
// 1 / sqrt(a^2 + 2^-24).
float brood_rsq(float a) {
  float t = brood_square(a);
  float h = brood_product(0.5, t);
  float y = uintBitsToFloat(0x5f375a86u - (floatBitsToUint(t) >> 1));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  return y;
}

// @spl
// log2(1 + 2^a).
float brood_spl(float a) {
  float rest = brood_log2(brood_hold(1.0 + brood_ex2(max(-abs(a), -24.0))));
  return brood_limit((a > 0.0 ? a : 0.0) + rest);
}

