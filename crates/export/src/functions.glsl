Canonical functions in GLSL. CPU twin: brood-genome's functions.rs, with the same order of
operations and clamps, bit for bit; WGSL twin: functions.wgsl. library.rs generates the constants
from the CPU twin. `brood_hold` prevents compilers from contracting or reassociating. Built-in sin,
exp2, mix, pow, sqrt and division are not used because drivers choose their errors. The text above
the first mark is not exported; each mark begins a function that library.rs picks by name.
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
  return clamp(a, -BROOD_RANGE, BROOD_RANGE);
}

// a + b c, rounded twice.
float brood_step(float a, float b, float c) {
  return brood_hold(a + brood_product(b, c));
}

// @sine
// sin(t) if quarter is 0, cos(t) if it is 1; t in [-1024, 1024].
float brood_sine(float t, int quarter) {
  // Adding 1.5 2^23 rounds to the nearest integer, ties to even, and leaves it in the low bits.
  float m = brood_hold(brood_product(t, BROOD_TWO_OVER_PI) + BROOD_ROUNDING);
  float k = brood_hold(m - BROOD_ROUNDING);
  float r = brood_hold(t - brood_product(k, BROOD_HALF_PI_0));
  r = brood_hold(r - brood_product(k, BROOD_HALF_PI_1));
  r = brood_hold(r - brood_product(k, BROOD_HALF_PI_2));
  float z = brood_product(r, r);
  float s = brood_step(BROOD_SIN_0, z, brood_step(BROOD_SIN_1, z, BROOD_SIN_2));
  s = brood_hold(r + brood_product(brood_product(r, z), s));
  float c = brood_step(BROOD_COS_0, z, brood_step(BROOD_COS_1, z, BROOD_COS_2));
  c = brood_hold(brood_hold(1.0 - brood_product(0.5, z)) + brood_product(brood_product(z, z), c));
  uint quadrant = floatBitsToUint(m) + uint(quarter);
  float value = (quadrant & 1u) == 0u ? s : c;
  return uintBitsToFloat(floatBitsToUint(value) ^ ((quadrant & 2u) << 30));
}

// @ex2
// 2^t for t in [-24, 16].
float brood_ex2(float t) {
  // As in the sine: rounds to the nearest integer and leaves it in the low bits.
  float m = brood_hold(t + BROOD_ROUNDING);
  float f = brood_hold(t - brood_hold(m - BROOD_ROUNDING));
  float p = brood_step(BROOD_EX2_3, f, brood_step(BROOD_EX2_4, f, BROOD_EX2_5));
  p = brood_step(BROOD_EX2_0, f, brood_step(BROOD_EX2_1, f, brood_step(BROOD_EX2_2, f, p)));
  p = brood_step(1.0, f, p);
  return p * uintBitsToFloat((floatBitsToUint(m) << 23) + 0x3f800000u);
}

// @log2
// log2 of a positive normal number.
float brood_log2(float t) {
  uint bits = floatBitsToUint(t);
  uint offset = (bits - BROOD_SQRT_HALF_BITS) & 0xff800000u;
  float exponent = float(int(offset) >> 23);
  float f = brood_hold(uintBitsToFloat(bits - offset) - 1.0);
  float p = brood_step(BROOD_LG2_7, f, brood_step(BROOD_LG2_8, f, BROOD_LG2_9));
  p = brood_step(BROOD_LG2_4, f, brood_step(BROOD_LG2_5, f, brood_step(BROOD_LG2_6, f, p)));
  p = brood_step(BROOD_LG2_1, f, brood_step(BROOD_LG2_2, f, brood_step(BROOD_LG2_3, f, p)));
  p = brood_product(f, brood_step(BROOD_LG2_0, f, p));
  return brood_hold(exponent + p);
}

// @square
// a^2 + 2^-24.
float brood_square(float a) {
  return brood_hold(brood_product(a, a) + BROOD_EPSILON);
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
  float y = uintBitsToFloat(BROOD_RCP_SEED - floatBitsToUint(t));
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
  float y = uintBitsToFloat(BROOD_RSQ_SEED - (floatBitsToUint(t) >> 1));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  return y;
}

// @spl
// log2(1 + 2^a).
float brood_spl(float a) {
  float rest = brood_log2(brood_hold(1.0 + brood_ex2(max(-abs(a), BROOD_EX2_LOW))));
  return brood_limit((a > 0.0 ? a : 0.0) + rest);
}

