//! Straight-line shader of one program, without an interpreter, for a program that is evaluated
//! repeatedly.
//!
//! The text is generated only from opcodes, indices and bit patterns. The words of the batch map
//! inputs to rows, so that one pipeline serves every set.

use std::fmt::Write;

use brood_brdf::InputMask;
use brood_genome::Output;
use brood_program::{Operand, Program};

use crate::operation::call;
use crate::shader::{Kernel, Style, head};

/// Largest number of steps that code is generated for. Compile time grows faster than the code.
pub(crate) const MAX_STEPS: usize = 2048;

/// Returns the shader of one program, with the entry point of the interpreter.
pub(crate) fn source(program: &Program, style: Style) -> String {
    let mut text = head(style, Kernel::Reflectance);
    text += "struct Place { block: u32, column: u32 }\n";
    text += "fn reflectance(program: u32, place: Place) -> array<V, 3> {\n";
    write_body(&mut text, program).expect("writing to a string does not fail");
    text + "}\n" + include_str!("reflectance.wgsl")
}

/// Returns the words of its batch: for each input that the program reads, in order, its row among
/// those of `resident`.
pub(crate) fn words(program: &Program, resident: InputMask) -> Vec<u32> {
    let row = |input| {
        let below = resident.iter().take_while(|other| *other != input).count();
        u32::try_from(below).expect("there are 32 inputs at most")
    };
    let mut words: Vec<u32> = program.inputs().iter().map(row).collect();
    if words.is_empty() {
        // A binding must not be empty.
        words.push(0);
    }
    words
}

/// Writes the body of `reflectance`: one statement per input, constant and step.
fn write_body(text: &mut String, program: &Program) -> std::fmt::Result {
    for (position, input) in program.inputs().iter().enumerate() {
        let index = input.index();
        writeln!(text, "let i{index} = inputs[words[{position}u] * tile.stride + place.block];")?;
    }
    for (index, constant) in program.constants().iter().enumerate() {
        writeln!(text, "let c{index} = {};", number(constant.canonical))?;
    }
    for (index, step) in program.steps().iter().enumerate() {
        let call = call(step.operation, &name(step.a), &name(step.b));
        writeln!(text, "let s{index} = {call};")?;
    }
    if program.is_color() {
        let [red, green, blue] = program.results().map(name);
        return writeln!(text, "return array<V, 3>({red}, {green}, {blue});");
    }
    for (channel, result) in program.results().iter().enumerate() {
        let g = name(*result);
        writeln!(text, "let q{channel} = product({g}, {g});")?;
    }
    let output = program.output();
    if *output == Output::IDENTITY {
        // The identity changes no bit: values are not negative.
        return writeln!(text, "return array<V, 3>(q0, q1, q2);");
    }
    for (channel, row) in output.matrix().iter().enumerate() {
        let [red, green, blue] = row.map(number);
        let scale = number(output.scale()[channel]);
        let offset = number(output.offset()[channel]);
        writeln!(text, "let m{channel} = hold(product(q1, {green}) + product(q0, {red}));")?;
        writeln!(text, "let n{channel} = hold(product(q2, {blue}) + m{channel});")?;
        writeln!(text, "let f{channel} = hold(product(n{channel}, {scale}) + {offset});")?;
    }
    writeln!(text, "return array<V, 3>(f0, f1, f2);")
}

/// Writes a number by its bits, which no formatting or parsing can change.
fn number(value: f32) -> String {
    format!("V(bitcast<f32>({:#010x}u))", value.to_bits())
}

/// Returns the variable that holds an operand.
fn name(operand: Operand) -> String {
    match operand {
        Operand::Step(index) => format!("s{index}"),
        Operand::Input(input) => format!("i{}", input.index()),
        Operand::Constant(index) => format!("c{index}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guard::Guard;
    use crate::interpreter_layout::InterpreterLayout;
    use brood_eval::conformance;

    #[test]
    fn generated_code_is_valid_wgsl_for_every_program() {
        for program in conformance::programs(2) {
            for guard in Guard::ALL {
                let style = Style { guard, shape: InterpreterLayout::default(), contracts: false };
                let text = source(&program, style);
                let parsed = wgpu::naga::front::wgsl::parse_str(&text);
                assert!(parsed.is_ok(), "{}\n{text}", parsed.unwrap_err().emit_to_string(&text));
            }
        }
    }

    #[test]
    fn words_map_inputs_to_rows_of_the_resident_set() {
        let genome: brood_genome::Genome =
            "brood 1\n.dialect paper smooth registers 7\nADD R0.xyz, R1.z, R1.w\n".parse().unwrap();
        let program = Program::lower(&genome);
        let all: InputMask = brood_brdf::Input::ALL.into_iter().collect();
        let rows: Vec<u32> = program.inputs().iter().map(|input| input.index() as u32).collect();
        assert_eq!(words(&program, all), rows);
        assert_eq!(words(&program, program.inputs()), [0, 1]);
    }
}
