//! Plan of the sweeps through a program, the same for all samples: the place of each value, and the
//! steps that derivatives are propagated through.

use brood_brdf::Level;
use brood_genome::Input;
use brood_program::{Operand, Operation, Program};
use brood_scene::SampleSet;

use crate::layer::{LayerValues, Layers};

/// A program prepared for sweeps. Every value has a row: constants first, then the inputs that are
/// read, then steps.
pub(super) struct Plan<'a> {
    pub(super) program: &'a Program,
    /// Number of constants.
    pub(super) constants: usize,
    /// Inputs that are read, in the order of their rows.
    pub(super) inputs: Vec<Input>,
    pub(super) steps: Vec<PlannedStep>,
    /// Rows of the results g of red, green and blue.
    pub(super) results: [usize; 3],
    /// `coefficients[channel][k]`: derivative of f of a channel with respect to the square of g of
    /// channel k. The output stage is affine, so it is constant.
    pub(super) coefficients: [[f32; 3]; 3],
    /// Reflectance of the layers on all samples; it depends on no constant.
    layers: Option<LayerValues>,
}

/// A step with the rows of its operands.
pub(super) struct PlannedStep {
    pub(super) operation: Operation,
    pub(super) a: usize,
    pub(super) b: usize,
    /// True if the step depends on a constant.
    pub(super) is_active: bool,
}

/// Tangent of an operand: its derivative with respect to one constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tangent {
    /// The operand does not depend on the constant.
    Zero,
    /// The operand is the constant.
    One,
    /// The tangent of this step.
    Step(usize),
}

/// Step that depends on a constant, and the tangent of each operand.
pub(super) struct TangentStep {
    pub(super) step: usize,
    pub(super) a: Tangent,
    pub(super) b: Tangent,
}

/// Destination of the adjoint of an operand, which is the derivative of a result with respect to
/// it. For a constant, contributions are added to the Jacobian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Adjoint {
    /// The operand depends on no constant.
    Nowhere,
    Constant(usize),
    /// The operand is a step. The first contribution to its adjoint is stored, others are added.
    Step {
        step: usize,
        is_first: bool,
    },
}

/// Step between a constant and the result of one channel. Names the destination of the adjoint of
/// each operand.
pub(super) struct AdjointStep {
    pub(super) step: usize,
    pub(super) a: Adjoint,
    pub(super) b: Adjoint,
}

impl<'a> Plan<'a> {
    pub(super) fn new(program: &'a Program, set: &SampleSet) -> Self {
        let constants = program.constants().len();
        let inputs: Vec<Input> = program.inputs().iter().collect();
        let first_step = constants + inputs.len();
        let row = |operand| match operand {
            Operand::Constant(index) => usize::from(index),
            Operand::Input(input) => {
                let place = inputs.iter().position(|read| *read == input);
                constants + place.expect("the mask contains every input that is read")
            }
            Operand::Step(index) => first_step + usize::from(index),
        };
        let mut steps: Vec<PlannedStep> = Vec::with_capacity(program.steps().len());
        for step in program.steps() {
            let is_active = |operand| match operand {
                Operand::Constant(_) => true,
                Operand::Input(_) => false,
                Operand::Step(index) => steps[usize::from(index)].is_active,
            };
            let is_active = is_active(step.a) || is_active(step.b);
            let (a, b) = (row(step.a), row(step.b));
            steps.push(PlannedStep { operation: step.operation, a, b, is_active });
        }
        let output = program.output();
        // The result of the output stage for a unit input, minus that for 0.
        let offset = output.apply([0.0; 3]);
        let coefficient = |channel: usize, k: usize| {
            let mut unit = [0.0; 3];
            unit[k] = 1.0;
            output.channel(channel, unit) - offset[channel]
        };
        let coefficients = [0, 1, 2].map(|channel| [0, 1, 2].map(|k| coefficient(channel, k)));
        let results = program.results().map(row);
        let layers = Layers::of(program).map(|layers| layers.on(set, Level::best()));
        Self { program, constants, inputs, steps, results, coefficients, layers }
    }

    /// Returns the values of the layers on the samples of a quarter that begins at `start`.
    pub(super) fn layers(&self, start: usize) -> Option<[&[f32]; 3]> {
        self.layers.as_ref().map(|layers| layers.quarter(start))
    }

    /// Returns the row of the first step.
    pub(super) fn first_step(&self) -> usize {
        self.constants + self.inputs.len()
    }

    /// Returns for each constant the steps that depend on it, and the tangents of the results.
    pub(super) fn tangents(&self) -> Vec<(Vec<TangentStep>, [Tangent; 3])> {
        (0..self.constants).map(|constant| self.tangents_of(constant)).collect()
    }

    /// Returns the steps that depend on one constant, in order, and the tangents of the results.
    fn tangents_of(&self, constant: usize) -> (Vec<TangentStep>, [Tangent; 3]) {
        let first_step = self.first_step();
        let mut changes = vec![false; self.steps.len()];
        let mut visited = Vec::new();
        let tangent = |row: usize, changes: &[bool]| match row.checked_sub(first_step) {
            Some(step) if changes[step] => Tangent::Step(step),
            None if row == constant => Tangent::One,
            _ => Tangent::Zero,
        };
        for (index, step) in self.steps.iter().enumerate() {
            let a = tangent(step.a, &changes);
            // The second operand of a unary operation repeats the first.
            let is_binary = step.operation.is_binary();
            let b = if is_binary { tangent(step.b, &changes) } else { Tangent::Zero };
            if a != Tangent::Zero || b != Tangent::Zero {
                changes[index] = true;
                visited.push(TangentStep { step: index, a, b });
            }
        }
        let results = self.results.map(|row| tangent(row, &changes));
        (visited, results)
    }

    /// Returns for each channel the destination of the adjoint of its result, and the steps on the
    /// paths to constants, last first.
    pub(super) fn adjoints(&self) -> [(Adjoint, Vec<AdjointStep>); 3] {
        self.results.map(|row| {
            let mut is_reached = vec![false; self.steps.len()];
            let result = self.adjoint(row, &mut is_reached);
            let mut visited = Vec::new();
            for index in (0..self.steps.len()).rev().filter(|index| self.steps[*index].is_active) {
                if !is_reached[index] {
                    continue;
                }
                let step = &self.steps[index];
                let a = self.adjoint(step.a, &mut is_reached);
                let b = match step.operation.is_binary() {
                    true => self.adjoint(step.b, &mut is_reached),
                    false => Adjoint::Nowhere,
                };
                visited.push(AdjointStep { step: index, a, b });
            }
            (result, visited)
        })
    }

    /// Returns the destination of the adjoint of a row and marks its step as reached.
    fn adjoint(&self, row: usize, is_reached: &mut [bool]) -> Adjoint {
        match row.checked_sub(self.first_step()) {
            Some(step) if self.steps[step].is_active => {
                let is_first = !std::mem::replace(&mut is_reached[step], true);
                Adjoint::Step { step, is_first }
            }
            None if row < self.constants => Adjoint::Constant(row),
            _ => Adjoint::Nowhere,
        }
    }
}
