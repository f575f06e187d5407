// The canonical elementary functions. CPU twin: functions.rs of brood-genome; order of operations
// and clamps must match it bit for bit. shader.rs generates the constants from the twin. Error:
// that of the twin; none against it if the start-up probe passes.
//
// `V` is one f32, or several that are evaluated together (`VI`, `VU`: the same number of i32, u32).
// Every result that a compiler could contract or reassociate passes through `hold`: the identity,
// or a barrier against that (see guard.rs). Built-in sin, exp2, mix, pow, sqrt and division are
// never used, because drivers choose their errors.

// Comparisons as in the twin, so that zeros keep their sign.
fn limit_to(x: V, low: f32, high: f32) -> V {
    let y = select(V(low), x, x > V(low));
    return select(V(high), y, y < V(high));
}

fn limit(x: V) -> V {
    return limit_to(x, -RANGE, RANGE);
}

// 1 where x >= 0, else 0.
fn is_positive(x: V) -> V {
    return select(V(0.0), V(1.0), x >= V(0.0));
}

fn product(a: V, b: V) -> V {
    return hold(a * b);
}

// a + b c with two roundings.
fn step(a: f32, b: V, c: V) -> V {
    return hold(V(a) + product(b, c));
}

// sin(x) if `quarter` is 0, cos(x) if it is 1: the quadrant is advanced by a quarter turn.
fn sine(angle: V, quarter: i32) -> V {
    let x = limit_to(angle, -ANGLE_RANGE, ANGLE_RANGE);
    // WGSL rounds halves to even, as adding and subtracting 1.5 * 2^23 does on the CPU.
    let k = round(product(x, V(TWO_OVER_PI)));
    var r = hold(x - product(k, V(HALF_PI_0)));
    r = hold(r - product(k, V(HALF_PI_1)));
    r = hold(r - product(k, V(HALF_PI_2)));
    let z = product(r, r);
    let s_inner = step(SIN_0, z, step(SIN_1, z, V(SIN_2)));
    let s = hold(r + product(product(r, z), s_inner));
    let c_inner = step(COS_0, z, step(COS_1, z, V(COS_2)));
    let c_outer = hold(V(1.0) - product(V(0.5), z));
    let c = hold(c_outer + product(product(z, z), c_inner));
    let quadrant = VI(k) + VI(quarter);
    let value = select(c, s, (quadrant & VI(1)) == VI(0));
    return bitcast<V>(bitcast<VU>(value) ^ ((bitcast<VU>(quadrant) & VU(2u)) << VU(30u)));
}

fn ex2(exponent: V) -> V {
    let x = limit_to(exponent, EX2_LOW, EX2_HIGH);
    let k = round(x);
    let f = hold(x - k);
    let high = step(EX2_3, f, step(EX2_4, f, V(EX2_5)));
    let low = step(EX2_0, f, step(EX2_1, f, step(EX2_2, f, high)));
    let p = step(1.0, f, low);
    let scale = bitcast<V>(bitcast<VU>(VI(k) + VI(127)) << VU(23u));
    // 2^16 is beyond the range of the machine, so the result is clamped like every other.
    return limit(product(p, scale));
}

// log2 of a positive normal number.
fn log2_of(t: V) -> V {
    let bits = bitcast<VU>(t);
    let offset = (bits - VU(SQRT_HALF_BITS)) & VU(0xff800000u);
    let exponent = V(bitcast<VI>(offset) >> VU(23u));
    let f = hold(bitcast<V>(bits - offset) - V(1.0));
    var p = step(LG2_7, f, step(LG2_8, f, V(LG2_9)));
    p = step(LG2_4, f, step(LG2_5, f, step(LG2_6, f, p)));
    p = step(LG2_1, f, step(LG2_2, f, step(LG2_3, f, p)));
    p = product(f, step(LG2_0, f, p));
    return hold(exponent + p);
}

// x^2 + 2^-24.
fn softened_square(x: V) -> V {
    return hold(product(x, x) + V(EPSILON));
}

// 1 / sqrt(x^2 + 2^-24).
fn rsq(x: V) -> V {
    let t = softened_square(x);
    let half = product(V(0.5), t);
    var y = bitcast<V>(VU(RSQ_SEED) - (bitcast<VU>(t) >> VU(1u)));
    y = product(y, hold(V(1.5) - product(product(half, y), y)));
    y = product(y, hold(V(1.5) - product(product(half, y), y)));
    y = product(y, hold(V(1.5) - product(product(half, y), y)));
    y = product(y, hold(V(1.5) - product(product(half, y), y)));
    return y;
}

// x / (x^2 + 2^-24), clamped.
fn rcp(x: V) -> V {
    let t = softened_square(x);
    var y = bitcast<V>(VU(RCP_SEED) - bitcast<VU>(t));
    y = product(y, hold(V(2.0) - product(t, y)));
    y = product(y, hold(V(2.0) - product(t, y)));
    y = product(y, hold(V(2.0) - product(t, y)));
    y = product(y, hold(V(2.0) - product(t, y)));
    return limit(product(x, y));
}

// log2(x^2 + 2^-24).
fn lg2(x: V) -> V {
    return log2_of(softened_square(x));
}

// log2(1 + 2^x), clamped.
fn spl(x: V) -> V {
    let logarithm = log2_of(hold(V(1.0) + ex2(-abs(x))));
    let positive = select(V(0.0), x, x > V(0.0));
    return limit(hold(positive + logarithm));
}
