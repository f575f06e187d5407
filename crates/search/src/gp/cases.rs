//! Samples by which genomes are evaluated: training and validation samples, a small subset for
//! solving scale and offset, lower bounds of clipped pixels, pairs of directions at which f is
//! bounded, and the energy limit.

use brood_brdf::DirectionPair;
use brood_eval::{FitnessTarget, Loss};
use brood_genome::Genome;
use brood_program::Program;
use brood_scene::SampleSet;
use brood_target::{LowerBound, MeasuredTarget, Samples, narrow_pairs};

use super::albedo::Albedos;
use crate::found::limited;
use crate::method::is_held_back;

/// Largest number of samples for solving scale and offset and for selecting parents.
pub(super) const FEW: usize = 256;
/// The same of lower bounds.
const FEW_BOUNDS: usize = 64;
/// Number of pairs in regions with few samples.
const NARROW: usize = 512;
/// Upper bound there, as a multiple of the largest sample or lower bound.
const MARGIN: f64 = 1.5;

/// Samples of a genetic search.
pub(super) struct Cases {
    /// Training samples and expected values.
    pub(super) target: FitnessTarget,
    /// At most [`FEW`] of these, evenly taken.
    pub(super) few: TargetSamples,
    /// Validation samples.
    pub(super) held: TargetSamples,
    /// Lower bounds, at most about as many as training samples; `None` if there are none.
    pub(super) bounds: Option<Bounds>,
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

/// Pairs for which only a lower bound of f is known, in some channels.
pub(super) struct Bounds {
    pub(super) set: SampleSet,
    rows: Vec<LowerBound>,
    /// At most [`FEW_BOUNDS`] of these, evenly taken, for solving scale and offset.
    pub(super) few: TargetSamples,
    /// True for the channels of `few` whose f is known.
    pub(super) few_known: Vec<[bool; 3]>,
}

impl Cases {
    pub(super) fn new(samples: &Samples, seed: u64) -> Self {
        let own = || samples.pairs().iter().copied().zip(samples.values().iter().copied());
        let part = |is_held: bool| {
            let own = own().enumerate().filter(move |(at, _)| is_held_back(*at) == is_held);
            own.map(|(_, sample)| sample)
        };
        let (pairs, values) = part(false).chain(samples.expected().iter().copied()).unzip();
        let fitted: Samples = Samples::new(pairs, values);
        let (pairs, values) = part(true).unzip();
        let held = Samples::new(pairs, values);
        let step = fitted.len().div_ceil(FEW).max(1);
        let below = samples.lower_bounds().iter().flat_map(|bound| bound.f);
        let largest = below.fold(fitted.largest().max(held.largest()), f64::max);
        Self {
            target: target(&fitted, seed),
            few: TargetSamples::new(&fitted, step),
            held: TargetSamples::new(&held, 1),
            bounds: Bounds::new(samples, fitted.len()),
            narrow: SampleSet::from_pairs(&narrow_pairs(NARROW, seed), &[]),
            ceiling: (MARGIN * largest).min(MeasuredTarget::LARGEST),
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
fn target(fitted: &Samples, seed: u64) -> FitnessTarget {
    let pairs = fitted.pairs();
    let values = |channel: usize| -> Vec<f32> {
        fitted.values().iter().map(|f| f[channel] as f32).collect()
    };
    let values = [values(0), values(1), values(2)];
    let cosine: Vec<f32> = pairs.iter().map(|pair| pair.cos_i() as f32).collect();
    let set = SampleSet::from_pairs(pairs, &[]);
    let rows = [0, 1, 2].map(|channel| &values[channel][..]);
    FitnessTarget::new(&set, rows, [&cosine; 3], Loss::Logarithmic, seed)
        .expect("a target's samples are within the machine's range")
        .hardest_first()
}

impl Bounds {
    fn new(samples: &Samples, most: usize) -> Option<Self> {
        let all = samples.lower_bounds();
        let step = all.len().div_ceil(most.max(1)).max(1);
        let rows: Vec<LowerBound> = all.iter().step_by(step).copied().collect();
        if rows.is_empty() {
            return None;
        }
        let pairs = |rows: &[LowerBound]| rows.iter().map(|row| row.pair).collect::<Vec<_>>();
        let step = rows.len().div_ceil(FEW_BOUNDS);
        let few: Vec<LowerBound> = rows.iter().step_by(step).copied().collect();
        let of_few = Samples::new(pairs(&few), few.iter().map(|row| row.f).collect());
        Some(Self {
            set: SampleSet::from_pairs(&pairs(&rows), &[]),
            few: TargetSamples::new(&of_few, 1),
            few_known: few.iter().map(|row| row.is_known).collect(),
            rows,
        })
    }

    /// Sum over pairs and channels of the squared differences of log2(1 + f cos_i), where f is
    /// known or below its bound.
    ///
    /// # Shapes
    /// `values` is f by channel and pair.
    pub(super) fn sum(&self, values: &[f32]) -> f64 {
        let count = self.rows.len();
        let of = |(at, row): (usize, &LowerBound)| -> f64 {
            let cos_i = row.pair.cos_i();
            let off = |channel: usize| {
                let found = f64::from(values[channel * count + at]);
                let off = libm::log1p(found * cos_i) - libm::log1p(row.f[channel] * cos_i);
                let off = if row.is_known[channel] { off } else { off.min(0.0) };
                (off * std::f64::consts::LOG2_E).powi(2)
            };
            (0..3).map(off).sum()
        };
        self.rows.iter().enumerate().map(of).sum()
    }
}

impl TargetSamples {
    /// Takes every `step`-th sample.
    fn new(samples: &Samples, step: usize) -> Self {
        let indices: Vec<usize> = (0..samples.len()).step_by(step).collect();
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
