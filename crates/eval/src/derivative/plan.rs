//! What is the same for all samples of a program: where values stand, and which steps carry a derivative.

use brood_genome::Input;
use brood_program::{Operand, Operation, Program};
use brood_scene::SampleSet;

use crate::Level;
use crate::layer::{LayerValues, Layers};

/// A program as its sweeps walk through it. Rows of values: constants, then the inputs read, then steps.
pub(super) struct Plan<'a> {
    pub(super) program: &'a Program,
    pub(super) constants: usize,
    pub(super) inputs: Vec<Input>,
    pub(super) steps: Vec<PlannedStep>,
    /// Rows of g of red, green and blue.
    pub(super) results: [usize; 3],
    /// `coefficients[channel][k]`: what the output stage takes of the square of g of channel k.
    pub(super) coefficients: [[f32; 3]; 3],
    layers: Option<LayerValues>,
}

/// A step with the rows of its operands.
pub(super) struct PlannedStep {
    pub(super) operation: Operation,
    pub(super) a: usize,
    pub(super) b: usize,
    /// Whether a constant stands anywhere before it.
    pub(super) is_active: bool,
}

/// Where the tangent of an operand is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tangent {
    Zero,
    One,
    Step(usize),
}

/// A step whose value changes with one constant.
pub(super) struct TangentStep {
    pub(super) step: usize,
    pub(super) a: Tangent,
    pub(super) b: Tangent,
}

/// Where an adjoint goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Adjoint {
    /// To what no constant changes.
    Nowhere,
    Constant(usize),
    /// To a step, as its first share or on top of others.
    Step {
        step: usize,
        is_first: bool,
    },
}

/// A step that both changes with a constant and changes the result of one channel.
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
                constants + place.expect("the inputs are those that are read")
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
        // The output stage is affine: a unit in, less the offset, is its coefficient.
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

    /// What the layers add on the samples of a quarter, the first of them `start`.
    pub(super) fn layers(&self, start: usize) -> Option<[&[f32]; 3]> {
        self.layers.as_ref().map(|layers| layers.quarter(start))
    }

    /// The row of the first step.
    pub(super) fn first_step(&self) -> usize {
        self.constants + self.inputs.len()
    }

    /// For each constant the steps that change with it, and where the tangents of the results are.
    pub(super) fn tangents(&self) -> Vec<(Vec<TangentStep>, [Tangent; 3])> {
        (0..self.constants).map(|constant| self.tangents_of(constant)).collect()
    }

    fn tangents_of(&self, constant: usize) -> (Vec<TangentStep>, [Tangent; 3]) {
        let first_step = self.first_step();
        let mut changes = vec![false; self.steps.len()];
        let mut walk = Vec::new();
        let tangent = |row: usize, changes: &[bool]| match row.checked_sub(first_step) {
            Some(step) if changes[step] => Tangent::Step(step),
            None if row == constant => Tangent::One,
            _ => Tangent::Zero,
        };
        for (index, step) in self.steps.iter().enumerate() {
            let a = tangent(step.a, &changes);
            // The second operand of what takes one repeats the first.
            let is_binary = step.operation.is_binary();
            let b = if is_binary { tangent(step.b, &changes) } else { Tangent::Zero };
            if a != Tangent::Zero || b != Tangent::Zero {
                changes[index] = true;
                walk.push(TangentStep { step: index, a, b });
            }
        }
        let results = self.results.map(|row| tangent(row, &changes));
        (walk, results)
    }

    /// For each channel where the adjoint of its result goes, and the steps on the way to constants, last first.
    pub(super) fn adjoints(&self) -> [(Adjoint, Vec<AdjointStep>); 3] {
        self.results.map(|row| {
            let mut is_reached = vec![false; self.steps.len()];
            let result = self.adjoint(row, &mut is_reached);
            let mut walk = Vec::new();
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
                walk.push(AdjointStep { step: index, a, b });
            }
            (result, walk)
        })
    }

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
