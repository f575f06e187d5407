//! What genomes are held against: all samples but those held back, a few to scale by, and places where nothing may stand out.

use brood_brdf::DirectionPair;
use brood_eval::{FitnessTarget, Loss};
use brood_genome::RANGE;
use brood_scene::SampleSet;

use crate::{Samples, narrow_pairs};

/// Every so many samples one is held back, to choose by.
const HELD: usize = 7;
/// Samples that scale and offset are solved on, and parents chosen by.
pub(super) const FEW: usize = 256;
/// Pairs where samples are few.
const NARROW: usize = 512;
/// What nothing there may pass, of the largest sample.
const MARGIN: f64 = 1.5;
/// As much as a program can reflect.
const LARGEST: f64 = (RANGE as f64) * (RANGE as f64);

/// The samples as a genetic search reads them.
pub(super) struct Cases {
    /// All but those held back.
    pub(super) target: FitnessTarget,
    /// A fair few of the same.
    pub(super) few: Wanted,
    /// Those held back.
    pub(super) held: Wanted,
    /// Where samples are few.
    pub(super) narrow: SampleSet,
    /// What nothing there may pass.
    pub(super) ceiling: f64,
}

/// Samples and what is wanted there.
pub(super) struct Wanted {
    pub(super) set: SampleSet,
    /// cos_i of each.
    pub(super) weight: Vec<f64>,
    /// f cos_i of each.
    pub(super) weighted: Vec<[f64; 3]>,
    /// ln(1 + f cos_i) of each.
    pub(super) wanted: Vec<[f64; 3]>,
}

impl Cases {
    pub(super) fn new(samples: &Samples, seed: u64) -> Self {
        let indices =
            |is_held: bool| (0..samples.len()).filter(move |at| (at % HELD == HELD - 1) == is_held);
        let fitted: Vec<usize> = indices(false).collect();
        let step = fitted.len().div_ceil(FEW).max(1);
        Self {
            target: target(samples, &fitted, seed),
            few: Wanted::new(samples, fitted.iter().copied().step_by(step)),
            held: Wanted::new(samples, indices(true)),
            narrow: SampleSet::from_pairs(&narrow_pairs(NARROW, seed), &[]),
            ceiling: (MARGIN * samples.largest()).min(LARGEST),
        }
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

impl Wanted {
    fn new(samples: &Samples, indices: impl Iterator<Item = usize>) -> Self {
        let indices: Vec<usize> = indices.collect();
        let pairs: Vec<DirectionPair> = indices.iter().map(|at| samples.pairs()[*at]).collect();
        let weight: Vec<f64> = pairs.iter().map(DirectionPair::cos_i).collect();
        let weighted = indices.iter().zip(&weight);
        let weighted = weighted.map(|(at, cosine)| samples.values()[*at].map(|f| f * cosine));
        let weighted: Vec<[f64; 3]> = weighted.collect();
        let wanted = weighted.iter().map(|value| value.map(libm::log1p)).collect();
        Self { set: SampleSet::from_pairs(&pairs, &[]), weight, weighted, wanted }
    }

    pub(super) fn len(&self) -> usize {
        self.weight.len()
    }
}
