// Bindings of every entry point. Host side: pipeline.rs (layout), pass.rs (uniform block).

struct Tile {
    // Always 0, unknown to the compiler.
    zero: u32,
    first_program: u32,
    // Blocks: samples that are evaluated together, one vector each.
    first_block: u32,
    end_block: u32,
    // Number of blocks in a row of inputs, targets and reflectances.
    stride: u32,
    // Number of samples in a row; the last block may be partly empty.
    samples: u32,
    // Number of sums in a row of sums.
    sums: u32,
    // 1 if the error compares logarithms.
    logarithmic: u32,
    // First sum of the rows.
    first_sum: u32,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage, read> words: array<u32>;
@group(0) @binding(2) var<storage, read> inputs: array<V>;
