//! Fitness with the sums on the device: one number per program and block of samples comes back, which the CPU adds in
//! f64. What the sum is, to the bit, is said in brood-eval's fitness.rs.

use std::ops::Range;

use brood_brdf::InputMask;
use brood_eval::{EvalError, Fitness, FitnessEvaluator, FitnessTarget, Loss, Population};
use brood_program::Program;

use crate::evaluator::{eval_error, refuse_layers};
use crate::residency::Rows;
use crate::sums::Targets;
use crate::{BatchTiming, GpuEvaluator};

/// Blocks of the first round where programs may end early; each later round doubles what was evaluated.
const FIRST_ROUND: usize = 4;

/// Programs bound to a target on a graphics adapter.
#[derive(Debug)]
pub struct GpuPopulation<'a> {
    gpu: &'a GpuEvaluator,
    programs: Vec<&'a Program>,
    /// The inputs of all of them, so that what is on the device stays the same as programs drop out.
    mask: InputMask,
    target: &'a FitnessTarget,
    fitness: Vec<Fitness>,
    timing: BatchTiming,
}

impl<'a> GpuPopulation<'a> {
    /// Binds programs to a target, nothing being evaluated yet.
    #[must_use]
    pub fn new(gpu: &'a GpuEvaluator, programs: &[&'a Program], target: &'a FitnessTarget) -> Self {
        let mask = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
        let fitness = vec![Fitness::default(); programs.len()];
        let (programs, timing) = (programs.to_vec(), BatchTiming::default());
        Self { gpu, programs, mask, target, fitness, timing }
    }

    /// What the last call of [`Population::extend`] took.
    #[must_use]
    pub fn timing(&self) -> BatchTiming {
        self.timing
    }

    /// The sums of some programs over some blocks: [program][block].
    fn sums(&mut self, going: &[usize], blocks: Range<usize>) -> Result<Vec<f32>, EvalError> {
        let Self { gpu, programs, mask, target, timing, .. } = self;
        let set = target.set();
        let row = |input| set.input(input);
        let rows = Rows { set: Some(set.id()), mask: *mask, len: set.len(), row: &row };
        let targets = Targets {
            set: set.id(),
            values: target.values(),
            weights: target.weights(),
            logarithmic: target.loss() == Loss::Logarithmic,
        };
        let batch: Vec<&Program> = going.iter().map(|index| programs[*index]).collect();
        refuse_layers(&batch).map_err(eval_error)?;
        let before = *timing;
        gpu.with_engine(|engine| {
            engine.timing = before;
            let sums = engine.sums(&batch, &rows, &targets, blocks.clone())?;
            *timing = engine.timing;
            Ok(sums)
        })
        .map_err(eval_error)
    }
}

impl Population for GpuPopulation<'_> {
    fn fitness(&self) -> &[Fitness] {
        &self.fitness
    }

    /// The device evaluates in rounds and may go further than a program needs; what is known afterwards is the same.
    fn extend(
        &mut self,
        programs: &[usize],
        range: Range<usize>,
        bound: f64,
    ) -> Result<(), EvalError> {
        self.timing = BatchTiming::default();
        let mut going = programs.to_vec();
        let mut from = range.start;
        while from < range.end && !going.is_empty() {
            let further = if bound.is_finite() { from.max(FIRST_ROUND) } else { range.len() };
            let to = range.end.min(from + further);
            let sums = self.sums(&going, from..to)?;
            let mut sums = sums.chunks_exact(to - from);
            going.retain(|program| {
                let sums = sums.next().expect("sums of every program");
                add(&mut self.fitness[*program], sums, bound)
            });
            from = to;
        }
        Ok(())
    }
}

/// Adds blocks in their order; `false` where the bound was passed, beyond which nothing counts.
fn add(fitness: &mut Fitness, sums: &[f32], bound: f64) -> bool {
    for sum in sums {
        fitness.sum += f64::from(*sum);
        fitness.blocks += 1;
        if fitness.sum > bound {
            return false;
        }
    }
    true
}

impl FitnessEvaluator for GpuEvaluator {
    fn population<'a>(
        &'a self,
        programs: &[&'a Program],
        target: &'a FitnessTarget,
    ) -> Box<dyn Population + 'a> {
        Box::new(GpuPopulation::new(self, programs, target))
    }
}

#[cfg(test)]
#[path = "fitness_tests.rs"]
mod tests;
