//! Text of the shaders: the WGSL files after a generated head of the constants that Rust and WGSL
//! share.
//!
//! Operation numbers come from [`Operation`], layouts from `encode`, constants of the elementary
//! functions from [`Functions`]. Text from outside never enters a shader.

use std::fmt::Write;

use brood_genome::Functions;
use brood_program::Operation;

use crate::encode::{ENTRY_WORDS, INDEX_BITS, OperandKind};
use crate::guard::Guard;
use crate::interpreter_layout::{InterpreterLayout, RegisterFile};

/// Sizes of the register file that pipelines are compiled for; a batch uses the smallest that holds
/// its programs.
///
/// Random genomes of 100 instructions need 10 registers in the median and 25 at most, those of 1024
/// instructions and 16 registers 63 at most. On llvmpipe the compile time grows with the square of
/// the size (0.5 s, 1.5 s, 5 s, over 20 s for 32, 64, 128, 256), so there is no larger one.
pub(crate) const REGISTER_FILES: [u32; 4] = [16, 32, 64, 128];

/// Name of the entry point.
pub(crate) const ENTRY_POINT: &str = "evaluate";

/// Number of samples per sum: a block of the CPU evaluator. The order of additions is part of the
/// definition of fitness; see fitness.wgsl.
pub(crate) const SUM_SAMPLES: u32 = 256;
/// Number of partial sums of one sum, and of invocations that add them.
const PARTIAL_SUMS: u32 = 16;
/// Number of invocations in a workgroup that writes reflectances.
const WORKGROUP: u32 = 64;

/// Output of a shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kernel {
    /// f of each program, channel and sample.
    Reflectance,
    /// A sum of errors of each program and each [`SUM_SAMPLES`] samples.
    Fitness,
}

impl Kernel {
    /// Returns the number of invocations in a workgroup.
    pub(crate) fn workgroup(self, lanes: u32) -> u32 {
        match self {
            Self::Reflectance => WORKGROUP,
            Self::Fitness => SUM_SAMPLES / lanes,
        }
    }

    /// Returns the number of bytes of workgroup memory besides registers.
    fn workgroup_bytes(self) -> u32 {
        match self {
            Self::Reflectance => 0,
            Self::Fitness => 4 * (SUM_SAMPLES + PARTIAL_SUMS),
        }
    }
}

/// Style of the code, independent of what it computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Style {
    /// Guard against contraction.
    pub guard: Guard,
    /// Layout of the interpreter.
    pub shape: InterpreterLayout,
    /// For tests: contracts as a driver might. Sums of a constant and a product round once.
    pub contracts: bool,
}

/// Parameters that a pipeline of the interpreter is specialised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    pub kernel: Kernel,
    pub style: Style,
    /// Length of the register file.
    pub registers: u32,
}

impl Variant {
    /// Creates a variant whose layout fits into the workgroup memory of the device.
    pub(crate) fn new(kernel: Kernel, style: Style, registers: u32, workgroup_bytes: u32) -> Self {
        let samples = kernel.workgroup(style.shape.lanes()) * style.shape.lanes();
        let left = workgroup_bytes.saturating_sub(kernel.workgroup_bytes());
        let shape = style.shape.fitting(registers, samples, left);
        Self { kernel, style: Style { shape, ..style }, registers }
    }
}

/// Returns the whole shader of the interpreter.
pub(crate) fn source(variant: Variant) -> String {
    let Variant { kernel, style, registers } = variant;
    let lanes = style.shape.lanes();
    let workgroup = kernel.workgroup(lanes);
    let mut text = head(style, kernel);
    let numbers = [
        ("ENTRY_WORDS", ENTRY_WORDS),
        ("INDEX_BITS", INDEX_BITS),
        ("INDEX_MASK", (1 << INDEX_BITS) - 1),
        ("KIND_REGISTER", OperandKind::Register as u32),
        ("KIND_INPUT", OperandKind::Input as u32),
        ("SUM_SAMPLES", SUM_SAMPLES),
        ("PARTIAL_SUMS", PARTIAL_SUMS),
    ];
    for (name, number) in numbers {
        line(&mut text, format_args!("const {name}: u32 = {number}u;"));
    }
    for operation in Operation::ALL {
        let (name, number) = (constant_name(operation), operation.number());
        line(&mut text, format_args!("const {name}: u32 = {number}u;"));
    }
    let (space, length, at) = match style.shape.file() {
        RegisterFile::Private => ("private", registers, "index".to_owned()),
        RegisterFile::Workgroup => {
            ("workgroup", registers * workgroup, format!("index * {workgroup}u + column"))
        }
    };
    line(&mut text, format_args!("var<{space}> registers: array<V, {length}>;"));
    let parameters = "index: u32, column: u32";
    line(&mut text, format_args!("fn load({parameters}) -> V {{ return registers[{at}]; }}"));
    line(
        &mut text,
        format_args!("fn store({parameters}, value: V) {{ registers[{at}] = value; }}"),
    );
    text += include_str!("interpreter.wgsl");
    text + match kernel {
        Kernel::Reflectance => include_str!("reflectance.wgsl"),
        Kernel::Fitness => include_str!("fitness.wgsl"),
    }
}

/// Returns the head of every shader: widths, guards, bindings and functions.
pub(crate) fn head(style: Style, kernel: Kernel) -> String {
    let lanes = style.shape.lanes();
    let mut text = String::new();
    for (alias, scalar) in [("V", "f32"), ("VI", "i32"), ("VU", "u32")] {
        match lanes {
            1 => line(&mut text, format_args!("alias {alias} = {scalar};")),
            _ => line(&mut text, format_args!("alias {alias} = vec{lanes}<{scalar}>;")),
        }
    }
    let workgroup = kernel.workgroup(lanes);
    for (name, value) in Functions::constants() {
        // Shortest digits that read back to the same bits.
        line(&mut text, format_args!("const {name}: f32 = {value:?};"));
    }
    for (name, bits) in Functions::BIT_CONSTANTS {
        line(&mut text, format_args!("const {name}: u32 = {bits:#010x}u;"));
    }
    line(&mut text, format_args!("const LANES: u32 = {lanes}u;"));
    line(&mut text, format_args!("const WORKGROUP: u32 = {workgroup}u;"));
    let component = if lanes == 1 { "x" } else { "x[at]" };
    line(&mut text, format_args!("fn lane(x: V, at: u32) -> f32 {{ return {component}; }}"));
    let (hold, hold_one) = match style.guard {
        Guard::Plain | Guard::NoContraction => ("x", "x"),
        Guard::Barrier => (
            "bitcast<V>(bitcast<VU>(x) ^ VU(tile.zero))",
            "bitcast<f32>(bitcast<u32>(x) ^ tile.zero)",
        ),
    };
    line(&mut text, format_args!("fn hold(x: V) -> V {{ return {hold}; }}"));
    line(&mut text, format_args!("fn hold_one(x: f32) -> f32 {{ return {hold_one}; }}"));
    text += include_str!("bindings.wgsl");
    text + &functions(style.contracts)
}

/// Returns the functions, deliberately contracted if a test requests it.
fn functions(contracts: bool) -> String {
    const PLAIN: &str = "return hold(V(a) + product(b, c));";
    const CONTRACTED: &str = "return contracted(V(a), b, c);";
    let functions = include_str!("functions.wgsl");
    if contracts {
        include_str!("contracted.wgsl").to_owned() + &functions.replace(PLAIN, CONTRACTED)
    } else {
        functions.to_owned()
    }
}

fn line(text: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(text, "{line}").expect("writing to a string does not fail");
}

/// Returns the name that interpreter.wgsl uses; it has an arm for each of them.
fn constant_name(operation: Operation) -> String {
    format!("OP_{}", operation.name().to_uppercase())
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

    #[test]
    fn constants_have_the_bits_of_the_twin_to_the_compiler() {
        use wgpu::naga;

        let style =
            Style { guard: Guard::Plain, shape: InterpreterLayout::default(), contracts: false };
        let text = source(Variant { kernel: Kernel::Reflectance, style, registers: 16 });
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        let found = |name: &str| {
            let (_, constant) =
                module.constants.iter().find(|(_, it)| it.name.as_deref() == Some(name)).unwrap();
            match module.global_expressions[constant.init] {
                naga::Expression::Literal(naga::Literal::F32(value)) => value.to_bits(),
                naga::Expression::Literal(naga::Literal::U32(bits)) => bits,
                ref other => panic!("{name}: {other:?}"),
            }
        };
        for (name, value) in Functions::constants() {
            assert_eq!(found(&name), value.to_bits(), "{name}");
        }
        for (name, bits) in Functions::BIT_CONSTANTS {
            assert_eq!(found(name), bits, "{name}");
        }
    }

    #[test]
    fn hand_written_functions_contain_no_coefficient() {
        const STRUCTURAL: &str = "0 0.0 0.5 1 1u 1.0 1.5 2u 2.0 23u 30u 127 0xff800000u";
        let text = include_str!("functions.wgsl");
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let is_part = |c: char| c.is_alphanumeric() || c == '.' || c == '_';
        for word in code.flat_map(|line| line.split(|c: char| !is_part(c))) {
            let is_literal = word.starts_with(|c: char| c.is_ascii_digit());
            assert!(!is_literal || STRUCTURAL.split(' ').any(|it| it == word), "{word}");
        }
    }

    #[test]
    fn contracted_functions_differ_from_plain_ones() {
        assert_eq!(functions(false), include_str!("functions.wgsl"));
        assert!(functions(true).contains("return contracted(V(a), b, c);"));
    }

    #[test]
    fn sums_are_wide_enough_for_the_invocations_that_add_them() {
        for shape in InterpreterLayout::ALL {
            assert!(Kernel::Fitness.workgroup(shape.lanes()) >= PARTIAL_SUMS);
        }
    }
}
