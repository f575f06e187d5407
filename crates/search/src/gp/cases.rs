//! Samples by which genomes are evaluated: training and validation samples, a small subset for
//! solving scale and offset, pairs of directions at which f is bounded, and the energy limit.

use brood_brdf::DirectionPair;
use brood_eval::{FitnessTarget, Loss};
use brood_genome::Genome;
use brood_program::Program;
use brood_scene::SampleSet;
use brood_target::{MeasuredTarget, Samples, narrow_pairs};

use super::albedo::Albedos;
use crate::found::limited;
use crate::method::is_held_back;

/// Largest number of samples for solving scale and offset and for selecting parents.
pub(super) const FEW: usize = 256;
/// Number of pairs in regions with few samples.
const NARROW: usize = 512;
/// Upper bound there, as a multiple of the largest sample.
const MARGIN: f64 = 1.5;

/// Samples of a genetic search.
pub(super) struct Cases {
    /// Training samples.
    pub(super) target: FitnessTarget,
    /// At most [`FEW`] of these, evenly taken.
    pub(super) few: TargetSamples,
    /// Validation samples.
    pub(super) held: TargetSamples,
    /// Pairs in regions with few samples.
    pub(super) narrow: SampleSet,
    /// Upper bound of f at the pairs of `narrow`.
    pub(super) ceiling: f64,
    albedos: Albedos,
}

/// Samples with their target values.
pub(super) struct TargetSamples {
    pub(super) set: SampleSet,
    /// cos_i of each.
    pub(super) weight: Vec<f64>,
    /// f cos_i of each.
    pub(super) weighted: Vec<[f64; 3]>,
    /// ln(1 + f cos_i) of each.
    pub(super) log_weighted: Vec<[f64; 3]>,
}

impl Cases {
    pub(super) fn new(samples: &Samples, seed: u64) -> Self {
        let indices =
            |is_held: bool| (0..samples.len()).filter(move |at| is_held_back(*at) == is_held);
        let fitted: Vec<usize> = indices(false).collect();
        let step = fitted.len().div_ceil(FEW).max(1);
        Self {
            target: target(samples, &fitted, seed),
            few: TargetSamples::new(samples, fitted.iter().copied().step_by(step)),
            held: TargetSamples::new(samples, indices(true)),
            narrow: SampleSet::from_pairs(&narrow_pairs(NARROW, seed), &[]),
            ceiling: (MARGIN * samples.largest()).min(MeasuredTarget::LARGEST),
            albedos: Albedos::new(),
        }
    }

    /// Program of a genome under the approximate energy limit.
    pub(super) fn limited_program(&self, genome: &Genome) -> Program {
        self.limited(&[&Program::lower(genome)]).swap_remove(0).0
    }

    /// Programs under the approximate energy limit, with the divisors of their f.
    pub(super) fn limited(&self, programs: &[&Program]) -> Vec<(Program, f64)> {
        let divisors = self.albedos.divisors(programs).into_iter();
        let of =
            |(program, divisor): (&&Program, f64)| (limited((*program).clone(), divisor), divisor);
        programs.iter().zip(divisors).map(of).collect()
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the machine is of f32")]
fn target(samples: &Samples, fitted: &[usize], seed: u64) -> FitnessTarget {
    let pairs: Vec<DirectionPair> = fitted.iter().map(|at| samples.pairs()[*at]).collect();
    let values = |channel: usize| -> Vec<f32> {
        fitted.iter().map(|at| samples.values()[*at][channel] as f32).collect()
    };
    let values = [values(0), values(1), values(2)];
    let cosine: Vec<f32> = pairs.iter().map(|pair| pair.cos_i() as f32).collect();
    let set = SampleSet::from_pairs(&pairs, &[]);
    let rows = [0, 1, 2].map(|channel| &values[channel][..]);
    FitnessTarget::new(&set, rows, [&cosine; 3], Loss::Logarithmic, seed)
        .expect("a target's samples are within the machine's range")
        .hardest_first()
}

impl TargetSamples {
    fn new(samples: &Samples, indices: impl Iterator<Item = usize>) -> Self {
        let indices: Vec<usize> = indices.collect();
        let pairs: Vec<DirectionPair> = indices.iter().map(|at| samples.pairs()[*at]).collect();
        let weight: Vec<f64> = pairs.iter().map(DirectionPair::cos_i).collect();
        let weighted = indices.iter().zip(&weight);
        let weighted = weighted.map(|(at, cosine)| samples.values()[*at].map(|f| f * cosine));
        let weighted: Vec<[f64; 3]> = weighted.collect();
        let log_weighted = weighted.iter().map(|value| value.map(libm::log1p)).collect();
        Self { set: SampleSet::from_pairs(&pairs, &[]), weight, weighted, log_weighted }
    }

    pub(super) fn len(&self) -> usize {
        self.weight.len()
    }
}
