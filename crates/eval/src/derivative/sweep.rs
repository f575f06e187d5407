//! One pass through a program over a few samples: values forwards, derivatives in either direction.

use brood_genome::{Arithmetic, Functions};
use brood_program::{Operand, Program, Step};

use super::local::partials;
use super::{Direction, NormalEquations};
use crate::canonical::LANES;
use crate::{FitnessTarget, Loss};

type Lanes = [f32; LANES];
const ZERO: Lanes = [0.0; LANES];

/// Room for one program, used for all samples in turn.
pub(super) struct Sweep<'a> {
    program: &'a Program,
    /// Of every step.
    values: Vec<Lanes>,
    /// Of every step: adjoints of one channel, or tangents of one constant.
    carried: Vec<Lanes>,
    /// [channel][constant]: derivatives of the result g of a channel.
    jacobian: Vec<Lanes>,
    inputs: Vec<Lanes>,
}

impl<'a> Sweep<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        let steps = program.steps().len();
        Self {
            program,
            values: vec![ZERO; steps],
            carried: vec![ZERO; steps],
            jacobian: vec![ZERO; 3 * program.constants().len()],
            inputs: vec![ZERO; brood_genome::Input::ALL.len()],
        }
    }

    /// Adds what the samples from `start` contribute.
    pub(super) fn run(
        &mut self,
        target: &FitnessTarget,
        start: usize,
        direction: Direction,
        equations: &mut NormalEquations,
    ) {
        self.read(target, start);
        self.forwards();
        match direction {
            Direction::Forward => self.tangents(),
            Direction::Reverse => self.adjoints(),
        }
        self.accumulate(target, start / LANES, equations);
    }

    fn read(&mut self, target: &FitnessTarget, start: usize) {
        for input in self.program.inputs().iter() {
            let values = &target.set().input(input)[start..];
            let lanes = &mut self.inputs[input.index()];
            let count = values.len().min(LANES);
            lanes[..count].copy_from_slice(&values[..count]);
            // The weight of what is beyond the last sample is 0; any value will do.
            lanes[count..].fill(values[count - 1]);
        }
    }

    fn operand(&self, operand: Operand) -> Lanes {
        match operand {
            Operand::Step(index) => self.values[usize::from(index)],
            Operand::Input(input) => self.inputs[input.index()],
            Operand::Constant(index) => {
                [self.program.constants()[usize::from(index)].canonical; LANES]
            }
        }
    }

    fn forwards(&mut self) {
        for (index, step) in self.program.steps().iter().enumerate() {
            let (a, b) = (self.operand(step.a), self.operand(step.b));
            let mut value = ZERO;
            for lane in 0..LANES {
                value[lane] = step.operation.apply(a[lane], b[lane]);
            }
            self.values[index] = value;
        }
    }

    /// The derivatives of a step with respect to its operands.
    fn partials(&self, index: usize, step: &Step) -> (Lanes, Lanes) {
        let (a, b) = (self.operand(step.a), self.operand(step.b));
        let value = &self.values[index];
        let (mut by_a, mut by_b) = (ZERO, ZERO);
        for lane in 0..LANES {
            (by_a[lane], by_b[lane]) = partials(step.operation, a[lane], b[lane], value[lane]);
        }
        (by_a, by_b)
    }

    fn adjoints(&mut self) {
        self.jacobian.fill(ZERO);
        let constants = self.program.constants().len();
        for (channel, result) in self.program.results().iter().enumerate() {
            self.carried.fill(ZERO);
            self.spread(*result, &[1.0; LANES], channel * constants);
            for (index, step) in self.program.steps().iter().enumerate().rev() {
                let adjoint = self.carried[index];
                if adjoint == ZERO {
                    continue;
                }
                let (by_a, by_b) = self.partials(index, step);
                self.spread(step.a, &product(&adjoint, &by_a), channel * constants);
                if step.operation.is_binary() {
                    self.spread(step.b, &product(&adjoint, &by_b), channel * constants);
                }
            }
        }
    }

    /// Adds to the adjoint of an operand, or to the derivative by a constant.
    fn spread(&mut self, operand: Operand, share: &Lanes, row: usize) {
        let place = match operand {
            Operand::Step(index) => &mut self.carried[usize::from(index)],
            Operand::Constant(index) => &mut self.jacobian[row + usize::from(index)],
            Operand::Input(_) => return,
        };
        for (place, share) in place.iter_mut().zip(share) {
            *place += share;
        }
    }

    fn tangents(&mut self) {
        let constants = self.program.constants().len();
        for constant in 0..constants {
            for (index, step) in self.program.steps().iter().enumerate() {
                let (a, b) = (self.tangent(step.a, constant), self.tangent(step.b, constant));
                let mut tangent = ZERO;
                if a != ZERO || b != ZERO {
                    let (by_a, by_b) = self.partials(index, step);
                    for lane in 0..LANES {
                        tangent[lane] = a[lane] * by_a[lane] + b[lane] * by_b[lane];
                    }
                }
                self.carried[index] = tangent;
            }
            for (channel, result) in self.program.results().iter().enumerate() {
                self.jacobian[channel * constants + constant] = self.tangent(*result, constant);
            }
        }
    }

    fn tangent(&self, operand: Operand, constant: usize) -> Lanes {
        match operand {
            Operand::Step(index) => self.carried[usize::from(index)],
            Operand::Constant(index) if usize::from(index) == constant => [1.0; LANES],
            Operand::Constant(_) | Operand::Input(_) => ZERO,
        }
    }

    /// From derivatives of g to those of residuals, and their products.
    fn accumulate(&self, target: &FitnessTarget, quarter: usize, equations: &mut NormalEquations) {
        let constants = equations.constants;
        let rows = target.quarter(quarter);
        let g = self.program.results().map(|result| self.operand(result));
        let output = self.program.output();
        let mut residual = [ZERO; 3];
        // by_square[channel][k]: derivative of the residual of a channel by the square of g of channel k.
        let mut by_square = [[ZERO; 3]; 3];
        for lane in 0..LANES {
            let squares = [0, 1, 2].map(|channel: usize| g[channel][lane].square());
            let offset = output.apply([0.0; 3]);
            for channel in 0..3 {
                let weight = rows[3 + channel].0[lane];
                let f = output.channel(channel, squares);
                let weighted = f * weight;
                let slope = match target.loss() {
                    Loss::Logarithmic => weight / (std::f32::consts::LN_2 * (1.0 + weighted)),
                    Loss::Squared => weight,
                };
                let scaled = match target.loss() {
                    Loss::Logarithmic => Functions::KNOWN.log2(1.0 + weighted),
                    Loss::Squared => weighted,
                };
                residual[channel][lane] = scaled - rows[channel].0[lane];
                for k in 0..3 {
                    // The output stage is affine: a unit in, less the offset, is its coefficient.
                    let mut unit = [0.0; 3];
                    unit[k] = 1.0;
                    by_square[channel][k][lane] =
                        slope * (output.channel(channel, unit) - offset[channel]);
                }
            }
        }
        let mut by_constant = vec![ZERO; constants];
        for channel in 0..3 {
            for (constant, row) in by_constant.iter_mut().enumerate() {
                *row = ZERO;
                for k in 0..3 {
                    let derivative = &self.jacobian[k * constants + constant];
                    for lane in 0..LANES {
                        row[lane] +=
                            by_square[channel][k][lane] * 2.0 * g[k][lane] * derivative[lane];
                    }
                }
            }
            equations.sum += dot(&residual[channel], &residual[channel]);
            for (first, a) in by_constant.iter().enumerate() {
                equations.gradient[first] += dot(a, &residual[channel]);
                for (second, b) in by_constant.iter().enumerate().take(first + 1) {
                    let value = dot(a, b);
                    equations.matrix[first * constants + second] += value;
                    if second < first {
                        equations.matrix[second * constants + first] += value;
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn product(a: &Lanes, b: &Lanes) -> Lanes {
    let mut product = ZERO;
    for lane in 0..LANES {
        product[lane] = a[lane] * b[lane];
    }
    product
}

/// In sixteen sums that are added in order.
#[inline(always)]
fn dot(a: &Lanes, b: &Lanes) -> f64 {
    let mut sums = [0.0f32; 16];
    for (a, b) in a.as_chunks::<16>().0.iter().zip(b.as_chunks::<16>().0) {
        for lane in 0..16 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().map(|sum| f64::from(*sum)).sum()
}
