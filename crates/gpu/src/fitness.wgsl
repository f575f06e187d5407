// Entry point that writes sums of errors: one row of workgroups per program, one workgroup per 256
// samples. CPU twin: fitness.rs of brood-eval, which defines the order of additions: sums 0 to 15
// take every sixteenth error in turn, then they are added pairwise. Nothing is clamped here.

@group(0) @binding(3) var<storage, read_write> outputs: array<f32>;
// Rows of red, green and blue: values to reach, then weights of reflectances.
@group(0) @binding(4) var<storage, read> targets: array<V>;

var<workgroup> errors: array<f32, SUM_SAMPLES>;
var<workgroup> partial_sums: array<f32, PARTIAL_SUMS>;

// Weighted f, or log2(1 + weighted f), minus the value to reach.
fn deviation(f: V, channel: u32, block: u32) -> V {
    let wanted = targets[channel * tile.stride + block];
    let weighted = product(f, targets[(3u + channel) * tile.stride + block]);
    if tile.logarithmic == 1u {
        return hold(log2_of(hold(V(1.0) + weighted)) - wanted);
    }
    return hold(weighted - wanted);
}

@compute @workgroup_size(WORKGROUP)
fn evaluate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let program = tile.first_program + group.y;
    let wanted = tile.first_block + group.x * WORKGROUP + local;
    // All invocations must reach the barriers. Those beyond the end evaluate the last block again,
    // and their errors count as 0.
    let block = min(wanted, tile.stride - 1u);
    let f = reflectance(program, Place(block, local));
    let red = deviation(f[0], 0u, block);
    let green = deviation(f[1], 1u, block);
    let blue = deviation(f[2], 2u, block);
    let red_green = hold(product(red, red) + product(green, green));
    let error = hold(red_green + product(blue, blue));
    for (var at = 0u; at < LANES; at += 1u) {
        let is_sample = wanted * LANES + at < tile.samples;
        errors[local * LANES + at] = select(0.0, lane(error, at), is_sample);
    }
    workgroupBarrier();
    if local < PARTIAL_SUMS {
        var sum = errors[local];
        for (var at = local + PARTIAL_SUMS; at < SUM_SAMPLES; at += PARTIAL_SUMS) {
            sum = hold_one(sum + errors[at]);
        }
        partial_sums[local] = sum;
    }
    workgroupBarrier();
    if local == 0u {
        var sums = partial_sums;
        for (var half = PARTIAL_SUMS / 2u; half > 0u; half /= 2u) {
            for (var at = 0u; at < half; at += 1u) {
                sums[at] = hold_one(sums[at] + sums[at + half]);
            }
        }
        let sum = tile.first_block / WORKGROUP + group.x - tile.first_sum;
        outputs[program * tile.sums + sum] = sums[0];
    }
}
