Canonical functions in WGSL. CPU twin: brood-genome's functions.rs, with the same constants, order
of operations and clamps, bit for bit; GLSL twin: functions.glsl. `brood_hold` prevents compilers
from contracting or reassociating. Built-in sin, exp2, mix, pow, sqrt and division are not used
because drivers choose their errors. The text above the first mark is not exported; each mark begins
a function that library.rs picks by name.
// @base
// Every product and sum must be rounded separately. brood_zero must be set to 0: because compilers
// do not know its value, they cannot fuse operations across brood_hold. Any binding will do.
@group(0) @binding(0) var<uniform> brood_zero: u32;

fn brood_hold(a: f32) -> f32 {
  return bitcast<f32>(bitcast<u32>(a) ^ brood_zero);
}

fn brood_product(a: f32, b: f32) -> f32 {
  return brood_hold(a * b);
}

fn brood_limit(a: f32) -> f32 {
  return clamp(a, -65504.0, 65504.0);
}

// a + b c, rounded twice.
fn brood_step(a: f32, b: f32, c: f32) -> f32 {
  return brood_hold(a + brood_product(b, c));
}

// @sine
// sin(t) if quarter is 0, cos(t) if it is 1; t in [-1024, 1024].
fn brood_sine(t: f32, quarter: i32) -> f32 {
  // Adding 1.5 2^23 rounds to the nearest integer, ties to even, and leaves it in the low bits.
  let m = brood_hold(brood_product(t, 0.63661975) + 12582912.0);
  let k = brood_hold(m - 12582912.0);
  var r = brood_hold(t - brood_product(k, 1.570556640625));
  r = brood_hold(r - brood_product(k, 0.0002396702766418457));
  r = brood_hold(r - brood_product(k, 1.5893254712295857e-8));
  let z = brood_product(r, r);
  var s = brood_step(-0.16666655, z, brood_step(0.008332179, z, -0.0001951727));
  s = brood_hold(r + brood_product(brood_product(r, z), s));
  var c = brood_step(0.041666646, z, brood_step(-0.0013887375, z, 2.443912e-5));
  c = brood_hold(brood_hold(1.0 - brood_product(0.5, z)) + brood_product(brood_product(z, z), c));
  let quadrant = bitcast<u32>(m) + bitcast<u32>(quarter);
  let value = select(c, s, (quadrant & 1u) == 0u);
  return bitcast<f32>(bitcast<u32>(value) ^ ((quadrant & 2u) << 30u));
}

// @ex2
// 2^t for t in [-24, 16].
fn brood_ex2(t: f32) -> f32 {
  // As in the sine: rounds to the nearest integer and leaves it in the low bits.
  let m = brood_hold(t + 12582912.0);
  let f = brood_hold(t - brood_hold(m - 12582912.0));
  var p = brood_step(0.009618006, f, brood_step(0.0013400249, f, 0.00015475875));
  p = brood_step(0.6931472, f, brood_step(0.2402265, f, brood_step(0.05550328, f, p)));
  p = brood_step(1.0, f, p);
  return p * bitcast<f32>((bitcast<u32>(m) << 23u) + 0x3f800000u);
}

// @log2
// log2 of a positive normal number.
fn brood_log2(t: f32) -> f32 {
  let bits = bitcast<u32>(t);
  let offset = (bits - 0x3f3504f3u) & 0xff800000u;
  let exponent = f32(bitcast<i32>(offset) >> 23u);
  let f = brood_hold(bitcast<f32>(bits - offset) - 1.0);
  var p = brood_step(-0.1906129, f, brood_step(0.1878259, f, -0.112973355));
  p = brood_step(0.28858528, f, brood_step(-0.23963657, f, brood_step(0.20429617, f, p)));
  p = brood_step(-0.72134733, f, brood_step(0.4808979, f, brood_step(-0.36069643, f, p)));
  p = brood_product(f, brood_step(1.442695, f, p));
  return brood_hold(exponent + p);
}

// @square
// a^2 + 2^-24.
fn brood_square(a: f32) -> f32 {
  return brood_hold(brood_product(a, a) + 5.9604645e-8);
}

// @lg2
// log2(a^2 + 2^-24).
fn brood_lg2(a: f32) -> f32 {
  return brood_log2(brood_square(a));
}

// @rcp
// a / (a^2 + 2^-24).
fn brood_rcp(a: f32) -> f32 {
  let t = brood_square(a);
  var y = bitcast<f32>(0x7ef311c7u - bitcast<u32>(t));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  y = brood_product(y, brood_hold(2.0 - brood_product(t, y)));
  return brood_limit(a * y);
}

// @rsq
// 1 / sqrt(a^2 + 2^-24).
fn brood_rsq(a: f32) -> f32 {
  let t = brood_square(a);
  let h = brood_product(0.5, t);
  var y = bitcast<f32>(0x5f375a86u - (bitcast<u32>(t) >> 1u));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  y = brood_product(y, brood_hold(1.5 - brood_product(brood_product(h, y), y)));
  return y;
}

// @spl
// log2(1 + 2^a).
fn brood_spl(a: f32) -> f32 {
  let rest = brood_log2(brood_hold(1.0 + brood_ex2(max(-abs(a), -24.0))));
  return brood_limit(select(0.0, a, a > 0.0) + rest);
}

