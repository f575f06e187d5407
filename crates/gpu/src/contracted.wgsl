// For tests only: a + b c rounded about once, as a driver that contracts would round it. The errors
// of product and sum are computed (Dekker's product, Knuth's two-sum) and added. Replaces such a
// driver on machines that have none. No CPU twin: the result is deliberately not canonical.

// Prevents drivers that reassociate from undoing the transformations.
fn kept(x: V) -> V {
    return bitcast<V>(bitcast<VU>(x) ^ VU(tile.zero));
}

// x with the lower 12 bits of its significand cleared: products of two halves are exact.
fn high_half(x: V) -> V {
    return bitcast<V>(bitcast<VU>(x) & VU(0xfffff000u));
}

fn contracted(a: V, b: V, c: V) -> V {
    let p = kept(b * c);
    let b_high = high_half(b);
    let c_high = high_half(c);
    let b_low = kept(b - b_high);
    let c_low = kept(c - c_high);
    let inner = kept(kept(b_high * c_low) + kept(b_low * c_high));
    let p_error = kept(kept(kept(kept(b_high * c_high) - p) + inner) + kept(b_low * c_low));
    let sum = kept(a + p);
    let shift = kept(sum - a);
    let sum_error = kept(kept(a - kept(sum - shift)) + kept(p - shift));
    return kept(sum + kept(sum_error + p_error));
}
