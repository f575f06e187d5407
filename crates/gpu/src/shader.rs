//! The text of the shader: the two WGSL files behind a generated head with the numbers that Rust and WGSL share.
//!
//! Numbers of operations come from [`Operation`], layouts from `encode`; nothing is copied by hand. No text from outside
//! ever gets here.

use std::fmt::Write;

use brood_genome::RANGE;
use brood_program::Operation;

use crate::encode::{ENTRY_WORDS, INDEX_BITS, Kind, LANES, WORKGROUP};

/// Register files that pipelines are built for; a batch runs in the smallest that holds its programs.
///
/// Random genomes of 100 instructions need 10 registers in the median and 25 at most, those of 1024 instructions and 16
/// registers 63 at most. On llvmpipe the time to compile grows with the square of the file (0.5 s, 1.5 s, 5 s, over
/// 20 s for 32, 64, 128, 256), which is why there is no larger one.
pub(crate) const REGISTER_FILES: [u32; 4] = [16, 32, 64, 128];

/// Name of the entry point.
pub(crate) const ENTRY_POINT: &str = "evaluate";

/// What a pipeline is specialised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    /// Length of the register file.
    pub registers: u32,
    /// Whether values pass through an exclusive or with a zero that the compiler does not know, which stops it from
    /// contracting or reassociating what stands on either side.
    pub barrier: bool,
}

/// The whole shader.
pub(crate) fn source(variant: Variant) -> String {
    let mut text = String::new();
    let mut line = |line: String| writeln!(text, "{line}").expect("a string takes everything");
    for (alias, scalar) in [("V", "f32"), ("VI", "i32"), ("VU", "u32")] {
        line(match LANES {
            1 => format!("alias {alias} = {scalar};"),
            lanes => format!("alias {alias} = vec{lanes}<{scalar}>;"),
        });
    }
    line(format!("const RANGE: f32 = {RANGE:?};"));
    let numbers = [
        ("REGISTERS", variant.registers),
        ("WORKGROUP", WORKGROUP),
        ("ENTRY_WORDS", ENTRY_WORDS),
        ("INDEX_BITS", INDEX_BITS),
        ("INDEX_MASK", (1 << INDEX_BITS) - 1),
        ("KIND_REGISTER", Kind::Register as u32),
        ("KIND_INPUT", Kind::Input as u32),
    ];
    for (name, number) in numbers {
        line(format!("const {name}: u32 = {number}u;"));
    }
    for operation in Operation::ALL {
        line(format!("const {}: u32 = {}u;", constant_name(operation), operation.number()));
    }
    let hold = if variant.barrier { "bitcast<V>(bitcast<VU>(x) ^ VU(tile.zero))" } else { "x" };
    line(format!("fn hold(x: V) -> V {{ return {hold}; }}"));
    text + include_str!("functions.wgsl") + include_str!("interpreter.wgsl")
}

/// The name that interpreter.wgsl uses; it has an arm for each of them.
fn constant_name(operation: Operation) -> &'static str {
    match operation {
        Operation::Add => "OP_ADD",
        Operation::Sub => "OP_SUB",
        Operation::Mul => "OP_MUL",
        Operation::Sin => "OP_SIN",
        Operation::Cos => "OP_COS",
        Operation::Ex2 => "OP_EX2",
        Operation::Ex2Neg => "OP_EX2_NEG",
        Operation::Lg2 => "OP_LG2",
        Operation::Rcp => "OP_RCP",
        Operation::Rsq => "OP_RSQ",
        Operation::Spl => "OP_SPL",
        Operation::SplNeg => "OP_SPL_NEG",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpreter_has_one_case_for_every_operation() {
        let text = include_str!("interpreter.wgsl");
        let cases: Vec<&str> = text
            .lines()
            .filter_map(|line| line.trim().strip_prefix("case ")?.strip_suffix(": {"))
            .flat_map(|names| names.split(", "))
            .collect();
        for operation in Operation::ALL {
            let name = constant_name(operation);
            assert_eq!(cases.iter().filter(|case| **case == name).count(), 1, "{name}");
        }
    }
}
