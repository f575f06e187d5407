//! Population on the CPU: programs translated once, errors summed block by block.

use std::ops::Range;

use brood_brdf::{Level, SimdKernel};
use brood_genome::Functions;
use brood_program::Program;
use rayon::prelude::*;

use super::evaluator::{Fitness, FitnessEvaluator, FitnessPopulation};
use super::loss::Loss;
use super::target::FitnessTarget;
use crate::canonical::{
    BoundCode, CanonicalEvaluator, Code, Span, Workspace, reflectance, with_workspace,
};
use crate::evaluator::EvalResult;
use crate::lanes::{BLOCK, LANES, QUARTERS, Quarter, pairwise_sum};
use crate::layer::SharedBlocks;

/// Number of partial sums of a block, which take its errors in turn.
const PARTIAL_SUMS: usize = 16;

/// Programs bound to a target on the CPU.
#[derive(Debug)]
pub struct CanonicalPopulation<'a> {
    codes: Vec<Code<'a>>,
    target: &'a FitnessTarget,
    /// Inputs of the layers of all programs.
    blocks: SharedBlocks<'a>,
    level: Level,
    fitness: Vec<Fitness>,
}

impl<'a> CanonicalPopulation<'a> {
    /// Translates the programs for the samples of the target.
    #[must_use]
    pub fn new(programs: &[&'a Program], target: &'a FitnessTarget, level: Level) -> Self {
        let codes =
            programs.par_iter().map(|program| Code::new(program, target.set(), level)).collect();
        let blocks = SharedBlocks::new(target.set(), level);
        Self { codes, target, blocks, level, fitness: vec![Fitness::default(); programs.len()] }
    }

    /// Returns the number of quarters of blocks that layers have been evaluated on.
    #[cfg(test)]
    pub(super) fn shared_quarters(&self) -> usize {
        self.blocks.computed()
    }
}

impl FitnessPopulation for CanonicalPopulation<'_> {
    fn fitness(&self) -> &[Fitness] {
        &self.fitness
    }

    fn extend(&mut self, programs: &[usize], range: Range<usize>, bound: f64) -> EvalResult {
        let Self { codes, target, blocks, level, fitness } = self;
        let (level, blocks): (Level, &SharedBlocks<'_>) = (*level, blocks);
        let known: &[Fitness] = fitness;
        let done: Vec<Fitness> = programs
            .par_iter()
            .map(|program| {
                let (code, fitness) = (&codes[*program], known[*program]);
                debug_assert_eq!(
                    fitness.blocks, range.start,
                    "the range begins at the next block of every program"
                );
                with_workspace(|workspace| {
                    let range = range.clone();
                    level.run(Sum { code, target, blocks, level, range, bound, fitness, workspace })
                })
            })
            .collect();
        for (program, done) in programs.iter().zip(done) {
            fitness[*program] = done;
        }
        Ok(())
    }
}

impl FitnessEvaluator for CanonicalEvaluator {
    fn population<'a>(
        &'a self,
        programs: &[&'a Program],
        target: &'a FitnessTarget,
    ) -> Box<dyn FitnessPopulation + 'a> {
        Box::new(CanonicalPopulation::new(programs, target, self.level()))
    }
}

/// Kernel that adds the errors of one program block by block until the bound is exceeded.
struct Sum<'a> {
    code: &'a Code<'a>,
    target: &'a FitnessTarget,
    blocks: &'a SharedBlocks<'a>,
    level: Level,
    range: Range<usize>,
    bound: f64,
    fitness: Fitness,
    workspace: &'a mut Workspace,
}

impl SimdKernel for Sum<'_> {
    type Output = Fitness;

    #[inline(always)]
    fn run(self) -> Fitness {
        let Self { code, target, blocks, level, range, bound, mut fitness, workspace } = self;
        let functions = std::hint::black_box(Functions::KNOWN);
        let mut f = [Quarter([0.0; LANES]); 3];
        let mut instructions = BoundCode::new(code, workspace);
        for block in range {
            let span = Span::of(block * BLOCK, target.samples());
            let results = instructions.block(span);
            let mut sums = [0.0f32; PARTIAL_SUMS];
            // Quarters without samples would add only zeros.
            for quarter in 0..span.length.div_ceil(LANES) {
                // Layers are evaluated per quarter, so that a program that ends early has not
                // evaluated more of them.
                let start = span.start + quarter * LANES;
                let layers = code.layers();
                let layers = layers.map(|layers| layers.on_block(level, blocks.quarter(start)));
                let layers = layers.as_ref().map(|rows| rows.each_ref().map(|row| &row[..]));
                reflectance(code.program(), results.quarter(quarter), layers, &mut f);
                let rows = target.quarter(block * QUARTERS + quarter);
                match target.loss() {
                    Loss::Logarithmic => add(&mut sums, &f, rows, |x| functions.log2(1.0 + x)),
                    Loss::Squared => add(&mut sums, &f, rows, |x| x),
                }
            }
            fitness.sum += f64::from(pairwise_sum(sums));
            fitness.blocks += 1;
            if fitness.sum > bound {
                break;
            }
        }
        fitness
    }
}

/// Adds the errors of a quarter to the partial sums. `rows` are the values to reach, then the
/// weights; `scale` is the loss.
#[inline(always)]
fn add(
    sums: &mut [f32; PARTIAL_SUMS],
    f: &[Quarter; 3],
    rows: [&Quarter; 6],
    scale: impl Fn(f32) -> f32,
) {
    let mut errors = [0.0f32; LANES];
    let [red, green, blue] = f;
    deviations(&mut errors, red, rows[0], rows[3], &scale, |_, square| square);
    deviations(&mut errors, green, rows[1], rows[4], &scale, |error, square| error + square);
    deviations(&mut errors, blue, rows[2], rows[5], &scale, |error, square| error + square);
    for errors in errors.as_chunks::<PARTIAL_SUMS>().0 {
        for (sum, error) in sums.iter_mut().zip(errors) {
            *sum += *error;
        }
    }
}

/// Adds the squared deviations of one channel to the errors of a quarter by `join`.
#[inline(always)]
fn deviations(
    errors: &mut [f32; LANES],
    f: &Quarter,
    values: &Quarter,
    weights: &Quarter,
    scale: impl Fn(f32) -> f32,
    join: impl Fn(f32, f32) -> f32,
) {
    for (((error, f), value), weight) in errors.iter_mut().zip(&f.0).zip(&values.0).zip(&weights.0)
    {
        let deviation = scale(f * weight) - value;
        *error = join(*error, deviation * deviation);
    }
}
