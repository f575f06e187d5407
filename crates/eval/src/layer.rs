//! What the layers of a program add to the squares of its results: models in f64, summed, rounded to f32 once.
//!
//! Canonical values are those of the branchless functions, lane by lane: the same bits for one sample and for blocks of
//! them, at every instruction set. The reference is the same formulas with `libm`.

mod shared;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use brood_brdf::{
    Block, Branchless, Brdf, DirectionPair, Elementary, Loop, Machine, Plain, PreparedModel,
};
use brood_genome::{Model, ModelKind, RANGE};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::DVec3;
use rayon::prelude::*;

use crate::Level;
use crate::canonical::LANES;

pub(crate) use shared::SharedBlocks;

/// Samples that one task takes.
const TOGETHER: usize = 16 * LANES;
/// As large as the square of a result can be, so that the output stage stays finite.
const MOST: f64 = RANGE as f64 * RANGE as f64;

/// Models that took tables to prepare are kept for so many pictures and batches to come.
const KEPT: usize = 64;

/// Prepared last comes last.
static PREPARED: Mutex<VecDeque<(Model, Arc<PreparedModel>)>> = Mutex::new(VecDeque::new());

/// The layers of a program, ready to be evaluated.
#[derive(Debug)]
pub(crate) struct Layers {
    models: Vec<Arc<PreparedModel>>,
}

/// A model, prepared; not once more where that takes long and has been done lately. No value depends on which.
fn prepared(model: &Model) -> Arc<PreparedModel> {
    if model.kind() != ModelKind::RoughPlastic {
        return model.prepare().into();
    }
    let kept = || PREPARED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, prepared)) = kept().iter().find(|(known, _)| known == model) {
        return prepared.clone();
    }
    let prepared = Arc::new(model.prepare());
    let mut kept = kept();
    if kept.len() == KEPT {
        kept.pop_front();
    }
    kept.push_back((model.clone(), prepared.clone()));
    prepared
}

/// Rows of red, green and blue that a task fills.
type Rows<'a> = [&'a mut [f32]; 3];

impl Layers {
    /// None where the program has no layers.
    pub(crate) fn of(program: &Program) -> Option<Self> {
        let models: Vec<_> = program.layers().iter().map(prepared).collect();
        (!models.is_empty()).then_some(Self { models })
    }

    /// The sum of the models in the reference's arithmetic, at most what the square of a result can be. What a published
    /// formula has below 0 is 0.
    pub(crate) fn f(&self, pair: &DirectionPair) -> DVec3 {
        let sum: DVec3 = self.models.iter().map(|model| model.f(pair).max(DVec3::ZERO)).sum();
        sum.min(DVec3::splat(MOST))
    }

    /// The same as canonical evaluators have it, of one sample.
    pub(crate) fn rounded(&self, pair: &DirectionPair) -> [f32; 3] {
        let machine = Plain::<Branchless>::new();
        let mut block = Block::<1>::new();
        block.fill(machine, std::slice::from_ref(pair));
        self.on_block(machine, &block).map(|[value]| value)
    }

    /// The same of each lane of a block.
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

    /// On each sample of a set that has directions.
    pub(crate) fn on(&self, set: &SampleSet, level: Level) -> LayerValues {
        let mut values = [(); 3].map(|()| vec![0.0; set.len()]);
        let [red, green, blue] = &mut values;
        fill(&mut [(self, [red, green, blue])], set, level);
        LayerValues(values)
    }
}

/// Fills the rows of each of some layers with what they are worth on the samples of a set. What models read of a block of
/// samples is computed once for all of them.
pub(crate) fn fill(layers: &mut [(&Layers, Rows<'_>)], set: &SampleSet, level: Level) {
    let mut tasks: Vec<Vec<(&Layers, Rows<'_>)>> = Vec::new();
    tasks.resize_with(set.len().div_ceil(TOGETHER), Vec::new);
    for (layers, [red, green, blue]) in layers {
        let rows = red.chunks_mut(TOGETHER).zip(green.chunks_mut(TOGETHER));
        let rows = rows.zip(blue.chunks_mut(TOGETHER)).map(|((r, g), b)| [r, g, b]);
        for (task, rows) in tasks.iter_mut().zip(rows) {
            task.push((*layers, rows));
        }
    }
    tasks.into_par_iter().enumerate().for_each(|(task, mut programs)| {
        let start = task * TOGETHER;
        let pairs = set.pairs(start..set.len().min(start + TOGETHER));
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

/// Adds what one model reflects to the sum of those before.
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
                *rounded = nearest(if *sum < MOST { *sum } else { MOST });
            }
        }
        rounded
    }
}

/// What layers are worth on each sample of a set, channel by channel.
#[derive(Debug)]
pub(crate) struct LayerValues([Vec<f32>; 3]);

impl LayerValues {
    /// Those of the samples from `start` on that a quarter of a block takes; fewer at the end of the set.
    pub(crate) fn quarter(&self, start: usize) -> [&[f32]; 3] {
        let end = (start + LANES).min(self.0[0].len());
        [&self.0[0][start..end], &self.0[1][start..end], &self.0[2][start..end]]
    }
}

#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}
