//! Samples as models read them: blocks of lanes, with what is wanted of each.

use std::sync::Arc;

use brood_brdf::{Block, DirectionPair};
use brood_eval::Level;

use super::albedo::Albedos;
use crate::Samples;

/// Samples of a block.
pub(super) const LANES: usize = 64;

/// What is known of the samples of a block.
#[derive(Debug, Clone)]
pub(super) struct Lanes {
    pub(super) block: Block<LANES>,
    /// What f counts times: cos_i.
    pub(super) weight: [f64; LANES],
    /// ln(1 + f cos_i) that is wanted of red, green and blue.
    pub(super) wanted: [[f64; LANES]; 3],
    /// 1, and 0 beyond the last sample.
    pub(super) counts: [f64; LANES],
    /// What counts of being above what is wanted: 1, and 0 where f is only known not to be below.
    pub(super) above: [f64; LANES],
}

/// Samples in blocks.
#[derive(Debug, Clone)]
pub(super) struct Batch {
    pub(super) lanes: Arc<Vec<Lanes>>,
    /// Samples times channels.
    pub(super) total: f64,
    /// Where what is reflected beyond a level counts, too.
    pub(super) albedos: Option<(Arc<Albedos>, f64)>,
}

impl Batch {
    /// Of the samples of these indices, in this order.
    pub(super) fn new(samples: &Samples, indices: &[usize]) -> Self {
        let row = |at: &usize| (samples.pairs()[*at], samples.values()[*at]);
        let rows: Vec<Row> = indices.iter().map(row).collect();
        let total = 3.0 * indices.len() as f64;
        Self { lanes: Arc::new(lanes(&rows, 1.0)), total, albedos: None }
    }

    /// The same held up where nothing is known but that f is not below a value, in about as many places as there are samples at most.
    pub(super) fn with_least(mut self, samples: &Samples) -> Self {
        let most = (self.lanes.len() * LANES).max(1);
        let step = samples.least().len().div_ceil(most).max(1);
        let rows: Vec<Row> = samples.least().iter().step_by(step).copied().collect();
        Arc::make_mut(&mut self.lanes).extend(lanes(&rows, 0.0));
        self
    }

    /// The same with what is reflected beyond that level.
    pub(super) fn below(&self, level: f64, albedos: &Arc<Albedos>) -> Self {
        Self { albedos: Some((albedos.clone(), level)), ..self.clone() }
    }

    /// How many residuals there are, those of lanes that count nothing included; albedos are one more block.
    pub(super) fn residuals(&self) -> usize {
        3 * LANES * (self.lanes.len() + usize::from(self.albedos.is_some()))
    }
}

/// A pair with what is wanted there.
type Row = (DirectionPair, [f64; 3]);

fn lanes(rows: &[Row], above: f64) -> Vec<Lanes> {
    let level = Level::best();
    let of = |rows: &[Row]| {
        let pairs: Vec<DirectionPair> = rows.iter().map(|(pair, _)| *pair).collect();
        let mut lanes = Lanes {
            block: Block::new(),
            weight: [0.0; LANES],
            wanted: [[0.0; LANES]; 3],
            counts: [0.0; LANES],
            above: [above; LANES],
        };
        lanes.block.fill(level, &pairs);
        for (lane, (pair, value)) in rows.iter().enumerate() {
            let cos_i = pair.cos_i();
            lanes.weight[lane] = cos_i;
            lanes.counts[lane] = 1.0;
            for (row, f) in lanes.wanted.iter_mut().zip(value) {
                row[lane] = libm::log1p(f * cos_i);
            }
        }
        lanes
    };
    rows.chunks(LANES).map(of).collect()
}

/// Some of the samples of these indices: half of them evenly, half evenly among those that are brightest, so that highlights are in
/// it however small they are. In ascending order.
pub(super) fn some_of(samples: &Samples, indices: &[usize], count: usize) -> Vec<usize> {
    if indices.len() <= count {
        return indices.to_vec();
    }
    let brightness = |at: usize| -> f64 {
        let cos_i = samples.pairs()[at].cos_i();
        samples.values()[at].iter().fold(0.0f64, |most, f| most.max(*f)) * cos_i
    };
    let mut bright: Vec<usize> = indices.to_vec();
    bright.sort_by(|a, b| brightness(*b).total_cmp(&brightness(*a)).then(a.cmp(b)));
    bright.truncate((indices.len() / 8).max(count));
    let spread = |from: &[usize], count: usize| -> Vec<usize> {
        (0..count).map(|k| from[(2 * k + 1) * from.len() / (2 * count)]).collect()
    };
    let mut chosen = spread(indices, count - count / 2);
    chosen.extend(spread(&bright, count / 2));
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}
