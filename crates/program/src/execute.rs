//! Execution of a program for one sample, in either arithmetic: the definition of a program's
//! result.

use brood_genome::{Arithmetic, Input};

use crate::{Constant, Meaning, Operand, Program};

/// Runs a program for one sample and returns the reflectance of the three channels, without layers;
/// or the results themselves, if they are colours or slopes.
///
/// # Shapes
/// `inputs` returns the value of an input, `constant` the value of a constant in this arithmetic;
/// the result is (red, green, blue).
///
/// # Error
/// None against [`brood_genome::interpret`] (`lowering_preserves_every_bit`).
pub fn execute<T: Arithmetic>(
    program: &Program,
    inputs: impl Fn(Input) -> T,
    constant: impl Fn(&Constant) -> T,
) -> [T; 3] {
    execute_layered(program, inputs, constant, |squares| squares)
}

/// Runs a program as [`execute`] does, and applies `layers` to the squares of the results before
/// the output stage. The caller adds the reflectance of the layers there.
pub fn execute_layered<T: Arithmetic>(
    program: &Program,
    inputs: impl Fn(Input) -> T,
    constant: impl Fn(&Constant) -> T,
    layers: impl FnOnce([T; 3]) -> [T; 3],
) -> [T; 3] {
    let results = execute_into(program, inputs, constant, &mut Vec::new());
    if matches!(program.meaning(), Meaning::Color | Meaning::Slopes) {
        return results;
    }
    let squares = results.map(Arithmetic::square);
    program.output().apply(layers(squares))
}

/// Runs a program for one sample and returns its results up to sign: g, colours or slopes. `values`
/// is memory for the results of the steps.
pub(crate) fn execute_into<T: Arithmetic>(
    program: &Program,
    inputs: impl Fn(Input) -> T,
    constant: impl Fn(&Constant) -> T,
    values: &mut Vec<T>,
) -> [T; 3] {
    values.clear();
    values.reserve(program.steps().len());
    let read = |values: &[T], operand| match operand {
        Operand::Step(index) => values[usize::from(index)],
        Operand::Input(input) => inputs(input),
        Operand::Constant(index) => constant(&program.constants()[usize::from(index)]),
    };
    for step in program.steps() {
        let (a, b) = (read(values, step.a), read(values, step.b));
        values.push(step.operation.apply(a, b));
    }
    program.results().map(|operand| read(values, operand))
}
