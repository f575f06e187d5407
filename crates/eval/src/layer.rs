//! What the layers of a program add to the squares of its results: models in f64, summed, rounded to f32 once.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use brood_brdf::{Brdf, DirectionPair};
use brood_genome::{Model, ModelKind, RANGE};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::DVec3;
use rayon::prelude::*;

use crate::canonical::LANES;

/// Samples that one task takes.
const TOGETHER: usize = 1024;
/// As large as the square of a result can be, so that the output stage stays finite.
const MOST: f64 = RANGE as f64 * RANGE as f64;

/// Models that took tables to prepare are kept for so many pictures and batches to come.
const KEPT: usize = 64;

/// Prepared last comes last.
static PREPARED: Mutex<VecDeque<(Model, Arc<dyn Brdf>)>> = Mutex::new(VecDeque::new());

/// The layers of a program, ready to be evaluated.
pub(crate) struct Layers {
    models: Vec<Arc<dyn Brdf>>,
}

/// A model, prepared; not once more where that takes long and has been done lately. No value depends on which.
fn prepared(model: &Model) -> Arc<dyn Brdf> {
    if model.kind() != ModelKind::RoughPlastic {
        return model.brdf().into();
    }
    let kept = || PREPARED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, brdf)) = kept().iter().find(|(known, _)| known == model) {
        return brdf.clone();
    }
    let brdf: Arc<dyn Brdf> = model.brdf().into();
    let mut kept = kept();
    if kept.len() == KEPT {
        kept.pop_front();
    }
    kept.push_back((model.clone(), brdf.clone()));
    brdf
}

impl Layers {
    /// None where the program has no layers.
    pub(crate) fn of(program: &Program) -> Option<Self> {
        let models: Vec<_> = program.layers().iter().map(prepared).collect();
        (!models.is_empty()).then_some(Self { models })
    }

    /// The sum of the models, at most what the square of a result can be. What a published formula has below 0 is 0.
    pub(crate) fn f(&self, pair: &DirectionPair) -> DVec3 {
        let sum: DVec3 = self.models.iter().map(|model| model.f(pair).max(DVec3::ZERO)).sum();
        sum.min(DVec3::splat(MOST))
    }

    /// The same as canonical evaluators have it.
    pub(crate) fn rounded(&self, pair: &DirectionPair) -> [f32; 3] {
        self.f(pair).to_array().map(nearest)
    }

    /// On each sample of a set that has directions.
    pub(crate) fn on(&self, set: &SampleSet) -> LayerValues {
        let mut values = [(); 3].map(|()| vec![0.0; set.len()]);
        let [red, green, blue] = &mut values;
        let parts = red.par_chunks_mut(TOGETHER).zip(green.par_chunks_mut(TOGETHER));
        parts.zip(blue.par_chunks_mut(TOGETHER)).enumerate().for_each(
            |(part, ((red, green), blue))| {
                for k in 0..red.len() {
                    [red[k], green[k], blue[k]] = self.rounded(&set.pair(part * TOGETHER + k).0);
                }
            },
        );
        LayerValues(values)
    }
}

/// What layers are worth on each sample of a set, channel by channel.
#[derive(Debug)]
pub(crate) struct LayerValues([Vec<f32>; 3]);

impl LayerValues {
    /// Those of the samples from `start` on that a quarter of a block takes; fewer at the end of the set.
    #[inline(always)]
    pub(crate) fn quarter(&self, start: usize) -> [&[f32]; 3] {
        let end = (start + LANES).min(self.0[0].len());
        [&self.0[0][start..end], &self.0[1][start..end], &self.0[2][start..end]]
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}
