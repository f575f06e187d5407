// What every entry point is given. Host side: pipeline.rs (bindings), pass.rs (the uniform block).

struct Tile {
    // Always 0; the compiler must not know.
    zero: u32,
    first_program: u32,
    // Blocks: as many samples as are evaluated together, one vector each.
    first_block: u32,
    end_block: u32,
    // Blocks in a row of inputs, of targets and of reflectances.
    stride: u32,
    // Samples in a row; the last block may have fewer than the others.
    samples: u32,
    // Sums in a row of sums.
    sums: u32,
    // 1 where the error is one of logarithms.
    logarithmic: u32,
    // The first sum of the rows.
    first_sum: u32,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage, read> words: array<u32>;
@group(0) @binding(2) var<storage, read> inputs: array<V>;
