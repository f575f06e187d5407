//! Scalar code of a program, one assignment per line, because long expressions overflow compilers.

use brood_genome::Output;
use brood_program::{Bumps, Operand, Operation, Program, Range, StepRange, step_ranges};

use crate::input;
use crate::source::{let_line, number};

/// Lines that read the inputs by their names, and `models` if there are layers, and return f, or
/// the colours of a painted program. Valid for texture coordinates in [-`uv`, `uv`].
pub(crate) fn lines(program: &Program, uv: f32) -> String {
    let value = |operand| value(program, operand);
    let mut text = steps(program, uv);
    if program.is_color() {
        let [red, green, blue] = program.results().map(value);
        return text + &format!("  return vec3f({red}, {green}, {blue});\n");
    }
    for (channel, result) in program.results().iter().enumerate() {
        let f = square(program, *result, &value(*result), channel);
        text += &let_line("f32", &format!("f{channel}"), &f);
    }
    if *program.output() == Output::IDENTITY {
        return text + "  return vec3f(f0, f1, f2);\n";
    }
    text += &output(program.output());
    text + "  return vec3f(o0, o1, o2);\n"
}

/// Lines that read u and v and return the slopes of bumps along them.
pub(crate) fn slopes(bumps: &Bumps, uv: f32) -> String {
    let code = bumps.code();
    let slope = |along: usize| {
        let value = value(code, code.results()[along]);
        if bumps.is_negative()[along] { format!("-{value}") } else { value }
    };
    steps(code, uv) + &format!("  return vec2f({}, {});\n", slope(0), slope(1))
}

/// Lines of the steps of a program.
fn steps(program: &Program, uv: f32) -> String {
    let ranges = step_ranges(program, |input| {
        let bound = input::bound(input, uv);
        Range { low: -bound, high: bound }
    });
    let value = |operand| value(program, operand);
    let mut text = String::new();
    for (index, (step, range)) in program.steps().iter().zip(&ranges).enumerate() {
        let call = call(step.operation, &value(step.a), &value(step.b), range);
        text += &let_line("f32", &format!("s{index}"), &call);
    }
    text
}

/// Square of a result plus the reflectance of the models.
fn square(program: &Program, result: Operand, g: &str, channel: usize) -> String {
    if program.layers().is_empty() {
        return format!("{g} * {g}");
    }
    let models = format!("models.{}", ["x", "y", "z"][channel]);
    match constant(program, result) {
        Some(0.0) => models,
        _ => format!("brood_hold(brood_product({g}, {g}) + {models})"),
    }
}

/// Value of a constant; `None` for other operands.
fn constant(program: &Program, operand: Operand) -> Option<f32> {
    match operand {
        Operand::Constant(index) => Some(program.constants()[usize::from(index)].canonical),
        Operand::Step(_) | Operand::Input(_) => None,
    }
}

/// Colour matrix, scale and offset of f0, f1, f2, in the operation order of the canonical
/// evaluators.
fn output(output: &Output) -> String {
    let mut text = String::new();
    let mut line = |name: String, value: String| text += &let_line("f32", &name, &value);
    for (channel, row) in output.matrix().iter().enumerate() {
        let [red, green, blue] = row.map(number);
        let scale = number(output.scale()[channel]);
        let offset = number(output.offset()[channel]);
        let two = format!("brood_hold(brood_product(f1, {green}) + brood_product(f0, {red}))");
        line(format!("m{channel}"), two);
        let three = format!("brood_hold(brood_product(f2, {blue}) + m{channel})");
        line(format!("n{channel}"), three);
        let scaled = format!("brood_hold(brood_product(n{channel}, {scale}) + {offset})");
        line(format!("o{channel}"), scaled);
    }
    text
}

/// Expression of an operand: variable of a step, name of an input, or literal.
fn value(program: &Program, operand: Operand) -> String {
    match operand {
        Operand::Step(index) => format!("s{index}"),
        Operand::Input(input) => input::name(input),
        Operand::Constant(index) => number(program.constants()[usize::from(index)].canonical),
    }
}

/// Expression of an operation. Both a clamp (`brood_limit`) and the barrier `brood_hold` prevent
/// compilers from fusing operations. A result gets the barrier where the clamp cannot act. Clamps
/// of arguments that cannot act are left out.
fn call(operation: Operation, a: &str, b: &str, range: &StepRange) -> String {
    let rounded = if range.clamps { "brood_limit" } else { "brood_hold" };
    let within = |argument: String, bounds: &str| {
        if range.clamps_argument { format!("clamp({argument}, {bounds})") } else { argument }
    };
    let angle = |a: &str| within(a.to_owned(), "-BROOD_ANGLE_RANGE, BROOD_ANGLE_RANGE");
    let power = |argument: String| {
        let value = format!("brood_ex2({})", within(argument, "BROOD_EX2_LOW, BROOD_EX2_HIGH"));
        // 2^16 is above the largest number; all smaller integer powers are not.
        if range.clamps { format!("brood_limit({value})") } else { value }
    };
    match operation {
        Operation::Add => format!("{rounded}({a} + {b})"),
        Operation::Sub => format!("{rounded}({a} - {b})"),
        Operation::Mul => format!("{rounded}({a} * {b})"),
        Operation::Sin => format!("brood_sine({}, 0)", angle(a)),
        Operation::Cos => format!("brood_sine({}, 1)", angle(a)),
        Operation::Ex2 => power(a.to_owned()),
        Operation::Ex2Neg => power(format!("-{a}")),
        Operation::Lg2 => format!("brood_lg2({a})"),
        Operation::Rcp => format!("brood_rcp({a})"),
        Operation::Rsq => format!("brood_rsq({a})"),
        Operation::Spl => format!("brood_spl({a})"),
        Operation::SplNeg => format!("brood_spl(-{a})"),
        Operation::Saturate => format!("clamp({a}, 0.0, 1.0)"),
        Operation::SaturateNeg => format!("clamp(-{a}, 0.0, 1.0)"),
        Operation::Step => format!("step(0.0, {a})"),
        Operation::StepNeg => format!("step(0.0, -{a})"),
    }
}
