//! Fitness with sums on the device: one number per program and block of 256 samples is read back,
//! and the CPU adds these in f64. The fitness module of brood-eval defines the order of additions.

use std::ops::Range;

use brood_brdf::InputMask;
use brood_eval::{
    EvalError, EvalResult, Fitness, FitnessEvaluator, FitnessPopulation, FitnessTarget, Loss,
};
use brood_program::Program;

use crate::evaluator::{eval_error, reject_layers};
use crate::residency::Rows;
use crate::sums::Targets;
use crate::{BatchTiming, GpuEvaluator};

/// Number of blocks of the first round if programs may end early; each later round doubles the
/// number of evaluated blocks.
const FIRST_ROUND: usize = 4;

/// Programs bound to a target on a graphics adapter.
#[derive(Debug)]
pub struct GpuPopulation<'a> {
    gpu: &'a GpuEvaluator,
    programs: Vec<&'a Program>,
    /// Inputs of all programs, so that the rows on the device stay the same as programs drop out.
    mask: InputMask,
    target: &'a FitnessTarget,
    fitness: Vec<Fitness>,
    timing: BatchTiming,
}

impl<'a> GpuPopulation<'a> {
    /// Binds programs to a target; nothing is evaluated yet.
    #[must_use]
    pub fn new(gpu: &'a GpuEvaluator, programs: &[&'a Program], target: &'a FitnessTarget) -> Self {
        let mask = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
        let fitness = vec![Fitness::default(); programs.len()];
        let (programs, timing) = (programs.to_vec(), BatchTiming::default());
        Self { gpu, programs, mask, target, fitness, timing }
    }

    /// Returns the cost of the last call of [`FitnessPopulation::extend`].
    #[must_use]
    pub fn timing(&self) -> BatchTiming {
        self.timing
    }

    /// Returns the sums of some programs over some blocks: [program][block].
    fn sums(&mut self, active: &[usize], blocks: Range<usize>) -> Result<Vec<f32>, EvalError> {
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
        let batch: Vec<&Program> = active.iter().map(|index| programs[*index]).collect();
        reject_layers(&batch).map_err(eval_error)?;
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

impl FitnessPopulation for GpuPopulation<'_> {
    fn fitness(&self) -> &[Fitness] {
        &self.fitness
    }

    /// Evaluates in rounds. The device may evaluate further than a program needs; the recorded
    /// fitness is the same.
    fn extend(&mut self, programs: &[usize], range: Range<usize>, bound: f64) -> EvalResult {
        self.timing = BatchTiming::default();
        let mut active = programs.to_vec();
        let mut from = range.start;
        while from < range.end && !active.is_empty() {
            let further = if bound.is_finite() { from.max(FIRST_ROUND) } else { range.len() };
            let to = range.end.min(from + further);
            let sums = self.sums(&active, from..to)?;
            let mut sums = sums.chunks_exact(to - from);
            active.retain(|program| {
                let sums = sums.next().expect("there are sums of every program");
                add(&mut self.fitness[*program], sums, bound)
            });
            from = to;
        }
        Ok(())
    }
}

/// Adds blocks in their order; `false` if the bound was exceeded, after which nothing is added.
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
    ) -> Box<dyn FitnessPopulation + 'a> {
        Box::new(GpuPopulation::new(self, programs, target))
    }
}

#[cfg(test)]
#[path = "fitness_tests.rs"]
mod tests;
