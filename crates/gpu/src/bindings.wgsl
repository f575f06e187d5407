// Bindings of every entry point. Host side: pipeline.rs (layout), pass.rs (uniform block). A block
// is the samples that one invocation evaluates together, one `V`: 1 or 4. It is not a block of the
// CPU evaluator, which is 256 samples and is called a sum here. A row holds one number per sample.

struct Tile {
    // Always 0, which the compiler cannot know: operand of the barrier that `hold` may be.
    zero: u32,
    // Program of the first row of workgroups.
    first_program: u32,
    // Blocks of this dispatch.
    first_block: u32,
    end_block: u32,
    // Number of blocks in a row of inputs, targets and reflectances.
    stride: u32,
    // Number of samples in a row; the last block may be partly empty.
    samples: u32,
    // Number of sums per program that the pass writes.
    sums: u32,
    // 1 if logarithms are compared: log2(1 + f w).
    logarithmic: u32,
    // Index of the first sum that the pass writes, among those of the rows.
    first_sum: u32,
}

@group(0) @binding(0) var<uniform> tile: Tile;
// Encoded programs, see encode.rs.
@group(0) @binding(1) var<storage, read> words: array<u32>;
// Rows of inputs, one after another.
@group(0) @binding(2) var<storage, read> inputs: array<V>;
