//! Layers of a program: models evaluated in f64, summed, rounded to f32 once, and added to the
//! squares of the results of the program.
//!
//! Canonical values are those of the branchless elementary functions, lane by lane: the same bits
//! for one sample and for blocks, with every instruction set. The reference uses the same formulas
//! with `libm`.

mod shared;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use brood_brdf::{
    Block, Branchless, Brdf, DirectionPair, Elementary, Level, Loop, Machine, Plain, PreparedModel,
};
use brood_genome::{Model, ModelKind, RANGE};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::DVec3;
use rayon::prelude::*;

use crate::lanes::{LANES, pairwise_sum};
use crate::rounding::round_to_f32;

pub(crate) use shared::SharedBlocks;

/// Number of samples per task.
const TASK_SAMPLES: usize = 16 * LANES;
/// Largest square of a result; the bound keeps the output stage finite.
const LARGEST_SQUARE: f64 = RANGE as f64 * RANGE as f64;

/// Capacity of the cache of prepared models. Only models whose preparation computes tables are
/// cached.
const CACHE_MODELS: usize = 64;

/// Prepared models, oldest first.
static PREPARED_MODELS: Mutex<VecDeque<(Model, Arc<PreparedModel>)>> = Mutex::new(VecDeque::new());

/// The layers of a program, prepared for evaluation.
#[derive(Debug)]
pub(crate) struct Layers {
    models: Vec<Arc<PreparedModel>>,
}

/// Prepares a model, or takes it from the cache if preparing it takes long. Values do not depend on
/// the cache.
fn prepared(model: &Model) -> Arc<PreparedModel> {
    if model.kind() != ModelKind::RoughPlastic {
        return model.prepare().into();
    }
    let cache = || PREPARED_MODELS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, prepared)) = cache().iter().find(|(cached, _)| cached == model) {
        return prepared.clone();
    }
    let prepared = Arc::new(model.prepare());
    let mut cache = cache();
    if cache.len() == CACHE_MODELS {
        cache.pop_front();
    }
    cache.push_back((model.clone(), prepared.clone()));
    prepared
}

/// Rows of red, green and blue that a task writes.
type Rows<'a> = [&'a mut [f32]; 3];

impl Layers {
    /// Returns the layers of a program, or `None` if it has none.
    pub(crate) fn of(program: &Program) -> Option<Self> {
        let models: Vec<_> = program.layers().iter().map(prepared).collect();
        (!models.is_empty()).then_some(Self { models })
    }

    /// Returns the sum of the models in reference arithmetic, at most the largest square of a
    /// result. Where a published formula is negative, it counts as 0.
    pub(crate) fn f(&self, pair: &DirectionPair) -> DVec3 {
        let sum: DVec3 = self.models.iter().map(|model| model.f(pair).max(DVec3::ZERO)).sum();
        sum.min(DVec3::splat(LARGEST_SQUARE))
    }

    /// Returns the canonical sum for one sample.
    pub(crate) fn rounded(&self, pair: &DirectionPair) -> [f32; 3] {
        let machine = Plain::<Branchless>::new();
        let mut block = Block::<1>::new();
        block.fill(machine, std::slice::from_ref(pair));
        self.on_block(machine, &block).map(|[value]| value)
    }

    /// Returns the canonical sum for each lane of a block.
    pub(crate) fn on_block<M: Machine, const N: usize>(
        &self,
        machine: M,
        block: &Block<N>,
    ) -> [[f32; N]; 3] {
        let mut sum = [[0.0; N]; 3];
        for model in &self.models {
            let f = model.f_block(machine, block);
            machine.run(Add { sum: &mut sum, f: &f });
        }
        machine.run(Rounded { sum: &sum })
    }

    /// Returns the weighted sum of one layer's reflectance, in f64, before it is rounded. Values
    /// are at least 0 and at most the largest square of a result. The sum has the same bits at
    /// every level.
    pub(crate) fn weighted_sum(
        &self,
        layer: usize,
        pairs: &[DirectionPair],
        weights: &[f64],
        level: Level,
    ) -> DVec3 {
        let mut sums = [[0.0; LANES]; 3];
        let mut block = Block::<LANES>::new();
        for (pairs, weights) in pairs.chunks(LANES).zip(weights.chunks(LANES)) {
            block.fill(level, pairs);
            let f = self.models[layer].f_block(level, &block);
            for (sums, f) in sums.iter_mut().zip(&f) {
                for ((sum, f), weight) in sums.iter_mut().zip(f).zip(weights) {
                    *sum += weight * if *f > 0.0 { f.min(LARGEST_SQUARE) } else { 0.0 };
                }
            }
        }
        DVec3::from(sums.map(pairwise_sum))
    }

    /// Evaluates the layers on each sample of a set that has directions.
    pub(crate) fn on(&self, set: &SampleSet, level: Level) -> LayerValues {
        let mut values = [(); 3].map(|()| vec![0.0; set.len()]);
        let [red, green, blue] = &mut values;
        fill(&mut [(self, [red, green, blue])], set, level);
        LayerValues(values)
    }
}

/// Writes the values of several layers on the samples of a set into their rows. The block of inputs
/// that models read is computed once for all of them.
pub(crate) fn fill(layers: &mut [(&Layers, Rows<'_>)], set: &SampleSet, level: Level) {
    let mut tasks: Vec<Vec<(&Layers, Rows<'_>)>> = Vec::new();
    tasks.resize_with(set.len().div_ceil(TASK_SAMPLES), Vec::new);
    for (layers, [red, green, blue]) in layers {
        let rows = red.chunks_mut(TASK_SAMPLES).zip(green.chunks_mut(TASK_SAMPLES));
        let rows = rows.zip(blue.chunks_mut(TASK_SAMPLES)).map(|((r, g), b)| [r, g, b]);
        for (task, rows) in tasks.iter_mut().zip(rows) {
            task.push((*layers, rows));
        }
    }
    tasks.into_par_iter().enumerate().for_each(|(task, mut programs)| {
        let start = task * TASK_SAMPLES;
        let pairs = set.pairs(start..set.len().min(start + TASK_SAMPLES));
        let mut block = Block::<LANES>::new();
        for (quarter, pairs) in pairs.chunks(LANES).enumerate() {
            block.fill(level, pairs);
            for (layers, rows) in &mut programs {
                let values = layers.on_block(level, &block);
                for (row, values) in rows.iter_mut().zip(&values) {
                    row[quarter * LANES..][..pairs.len()].copy_from_slice(&values[..pairs.len()]);
                }
            }
        }
    });
}

/// Loop that adds the reflectance of a model to the sum; negative values count as 0.
struct Add<'a, const N: usize> {
    sum: &'a mut [[f64; N]; 3],
    f: &'a [[f64; N]; 3],
}

impl<const N: usize> Loop for Add<'_, N> {
    type Values = ();

    #[inline(always)]
    fn run<F: Elementary>(self) {
        for (sum, f) in self.sum.iter_mut().zip(self.f) {
            for (sum, f) in sum.iter_mut().zip(f) {
                *sum += if *f > 0.0 { *f } else { 0.0 };
            }
        }
    }
}

/// Loop that limits the sum to the largest square of a result and rounds it to f32.
struct Rounded<'a, const N: usize> {
    sum: &'a [[f64; N]; 3],
}

impl<const N: usize> Loop for Rounded<'_, N> {
    type Values = [[f32; N]; 3];

    #[inline(always)]
    fn run<F: Elementary>(self) -> [[f32; N]; 3] {
        let mut rounded = [[0.0; N]; 3];
        for (rounded, sum) in rounded.iter_mut().zip(self.sum) {
            for (rounded, sum) in rounded.iter_mut().zip(sum) {
                let bounded = if *sum < LARGEST_SQUARE { *sum } else { LARGEST_SQUARE };
                *rounded = round_to_f32(bounded);
            }
        }
        rounded
    }
}

/// Values of layers on each sample of a set, channel by channel.
#[derive(Debug)]
pub(crate) struct LayerValues([Vec<f32>; 3]);

impl LayerValues {
    /// Returns the values of one quarter of a block, from the sample `start` on; the last quarter
    /// of a set may be shorter.
    pub(crate) fn quarter(&self, start: usize) -> [&[f32]; 3] {
        let end = (start + LANES).min(self.0[0].len());
        [&self.0[0][start..end], &self.0[1][start..end], &self.0[2][start..end]]
    }
}
