// Entry point that writes reflectances: one row of workgroups per program, one invocation per block
// of samples. CPU twin: canonical.rs of brood-eval.

@group(0) @binding(3) var<storage, read_write> outputs: array<V>;

@compute @workgroup_size(WORKGROUP)
fn evaluate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let block = tile.first_block + group.x * WORKGROUP + local;
    if block >= tile.end_block {
        return;
    }
    let program = tile.first_program + group.y;
    let f = reflectance(program, Place(block, local));
    for (var channel = 0u; channel < 3u; channel += 1u) {
        outputs[(program * 3u + channel) * tile.stride + block] = f[channel];
    }
}
