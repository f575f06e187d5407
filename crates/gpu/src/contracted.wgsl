// For tests only: a + b c rounded as a driver would round it that contracts, by error-free transformations. It stands
// in for such a driver where none is at hand. No CPU twin: it is what the others must not be.

// Drivers undo such transformations where they may reassociate; here they must not.
fn kept(x: V) -> V {
    return bitcast<V>(bitcast<VU>(x) ^ VU(tile.zero));
}

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
