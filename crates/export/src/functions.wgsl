Canonical functions. CPU twin: brood-genome's functions.rs, with the same order of operations and
clamps, bit for bit. library.rs generates the constants from the CPU twin, language.rs the
declaration of brood_zero and the GLSL form. `brood_hold` prevents compilers from contracting or
reassociating. Built-in sin, exp2, mix, pow, sqrt and division are not used because drivers choose
their errors. The text above the first mark is not exported; each mark begins a function that
library.rs picks by name.
// @base
fn brood_hold(a: f32) -> f32 {
  return bitcast<f32>(bitcast<u32>(a) ^ brood_zero);
}

fn brood_product(a: f32, b: f32) -> f32 {
  return brood_hold(a * b);
}

fn brood_limit(a: f32) -> f32 {
  return clamp(a, -BROOD_RANGE, BROOD_RANGE);
}

// a + b c, rounded twice.
fn brood_step(a: f32, b: f32, c: f32) -> f32 {
  return brood_hold(a + brood_product(b, c));
}

// @sine
// sin(t) if quarter is 0, cos(t) if it is 1; t in [-1024, 1024].
fn brood_sine(t: f32, quarter: i32) -> f32 {
  // Adding 1.5 2^23 rounds to the nearest integer, ties to even, and leaves it in the low bits.
  let m: f32 = brood_hold(brood_product(t, BROOD_TWO_OVER_PI) + BROOD_ROUNDING);
  let k: f32 = brood_hold(m - BROOD_ROUNDING);
  var r: f32 = brood_hold(t - brood_product(k, BROOD_HALF_PI_0));
  r = brood_hold(r - brood_product(k, BROOD_HALF_PI_1));
  r = brood_hold(r - brood_product(k, BROOD_HALF_PI_2));
  let z: f32 = brood_product(r, r);
  var s: f32 = brood_step(BROOD_SIN_0, z, brood_step(BROOD_SIN_1, z, BROOD_SIN_2));
  s = brood_hold(r + brood_product(brood_product(r, z), s));
  var c: f32 = brood_step(BROOD_COS_0, z, brood_step(BROOD_COS_1, z, BROOD_COS_2));
  c = brood_hold(brood_hold(1.0 - brood_product(0.5, z)) + brood_product(brood_product(z, z), c));
  let quadrant: u32 = bitcast<u32>(m) + bitcast<u32>(quarter);
  let value: f32 = select(c, s, (quadrant & 1u) == 0u);
  return bitcast<f32>(bitcast<u32>(value) ^ ((quadrant & 2u) << 30u));
}

// @ex2
// 2^t for t in [-24, 16].
fn brood_ex2(t: f32) -> f32 {
  // As in the sine: rounds to the nearest integer and leaves it in the low bits.
  let m: f32 = brood_hold(t + BROOD_ROUNDING);
  let f: f32 = brood_hold(t - brood_hold(m - BROOD_ROUNDING));
  var p: f32 = brood_step(BROOD_EX2_3, f, brood_step(BROOD_EX2_4, f, BROOD_EX2_5));
  p = brood_step(BROOD_EX2_0, f, brood_step(BROOD_EX2_1, f, brood_step(BROOD_EX2_2, f, p)));
  p = brood_step(1.0, f, p);
  return p * bitcast<f32>((bitcast<u32>(m) << 23u) + 0x3f800000u);
}

// @log2
// log2 of a positive normal number.
fn brood_log2(t: f32) -> f32 {
  let bits: u32 = bitcast<u32>(t);
  let offset: u32 = (bits - BROOD_SQRT_HALF_BITS) & 0xff800000u;
  let exponent: f32 = f32(bitcast<i32>(offset) >> 23u);
  let f: f32 = brood_hold(bitcast<f32>(bits - offset) - 1.0);
  var p: f32 = brood_step(BROOD_LG2_7, f, brood_step(BROOD_LG2_8, f, BROOD_LG2_9));
  p = brood_step(BROOD_LG2_4, f, brood_step(BROOD_LG2_5, f, brood_step(BROOD_LG2_6, f, p)));
  p = brood_step(BROOD_LG2_1, f, brood_step(BROOD_LG2_2, f, brood_step(BROOD_LG2_3, f, p)));
  p = brood_product(f, brood_step(BROOD_LG2_0, f, p));
  return brood_hold(exponent + p);
}

// @square
// a^2 + 2^-24.
fn brood_square(a: f32) -> f32 {
  return brood_hold(brood_product(a, a) + BROOD_EPSILON);
}

// @lg2
// log2(a^2 + 2^-24).
fn brood_lg2(a: f32) -> f32 {
  return brood_log2(brood_square(a));
}

// @rcp
// a / (a^2 + 2^-24).
fn brood_rcp(a: f32) -> f32 {
  let t: f32 = brood_square(a);
  var y: f32 = bitcast<f32>(BROOD_RCP_SEED - bitcast<u32>(t));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  return brood_limit(a * y);
}

// @rsq
// 1 / sqrt(a^2 + 2^-24).
fn brood_rsq(a: f32) -> f32 {
  let t: f32 = brood_square(a);
  let h: f32 = brood_product(0.5, t);
  var y: f32 = bitcast<f32>(BROOD_RSQ_SEED - (bitcast<u32>(t) >> 1u));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  return y;
}

// @spl
// log2(1 + 2^a).
fn brood_spl(a: f32) -> f32 {
  let rest: f32 = brood_log2(brood_hold(1.0 + brood_ex2(max(-abs(a), BROOD_EX2_LOW))));
  return brood_limit(select(0.0, a, a > 0.0) + rest);
}

