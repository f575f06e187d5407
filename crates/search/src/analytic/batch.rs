//! Samples as models read them: blocks of lanes with the target values of each lane.

use std::sync::Arc;

use brood_brdf::{Block, DirectionPair};
use brood_eval::Level;
use brood_target::{LowerBound, Samples};

use super::LANES;
use super::albedo::Albedos;

/// One block of samples.
#[derive(Debug, Clone)]
pub(super) struct Lanes {
    pub(super) block: Block<LANES>,
    /// Factor of f: cos_i.
    pub(super) weight: [f64; LANES],
    /// Target ln(1 + f cos_i) of red, green and blue.
    pub(super) target: [[f64; LANES]; 3],
    /// 1, or 0 beyond the last sample.
    pub(super) counts: [f64; LANES],
    /// Weight of a positive difference: 1, or 0 if the target is only a lower bound of f; of red,
    /// green and blue.
    pub(super) above: [[f64; LANES]; 3],
}

/// Samples in blocks, with an optional albedo penalty.
#[derive(Debug, Clone)]
pub(super) struct Batch {
    pub(super) lanes: Arc<Vec<Lanes>>,
    /// Number of samples times channels.
    pub(super) total: f64,
    /// Quadrature and level of the penalty on albedos above that level.
    pub(super) albedos: Option<(Arc<Albedos>, f64)>,
    /// Weight of the prior: what one squared standard deviation adds to the mean squared residual.
    pub(super) prior: Option<f64>,
}

impl Batch {
    /// Creates a batch of the samples of these indices, in this order.
    pub(super) fn new(samples: &Samples, indices: &[usize]) -> Self {
        let row = |at: &usize| LowerBound {
            pair: samples.pairs()[*at],
            f: samples.values()[*at],
            is_known: [true; 3],
        };
        let rows: Vec<LowerBound> = indices.iter().map(row).collect();
        let total = 3.0 * indices.len() as f64;
        Self { lanes: Arc::new(lanes(&rows)), total, albedos: None, prior: None }
    }

    /// Adds the lower bounds of `samples`, at most about as many as the batch has samples.
    pub(super) fn with_lower_bounds(mut self, samples: &Samples) -> Self {
        let most = (self.lanes.len() * LANES).max(1);
        let step = samples.lower_bounds().len().div_ceil(most).max(1);
        let rows: Vec<LowerBound> = samples.lower_bounds().iter().step_by(step).copied().collect();
        Arc::make_mut(&mut self.lanes).extend(lanes(&rows));
        self
    }

    /// Copy with a penalty on albedos above that level.
    pub(super) fn with_albedo_penalty(&self, level: f64, albedos: &Arc<Albedos>) -> Self {
        Self { albedos: Some((albedos.clone(), level)), ..self.clone() }
    }

    /// Copy with this weight of the prior.
    pub(super) fn with_prior(&self, weight: f64) -> Self {
        Self { prior: Some(weight), ..self.clone() }
    }

    /// Number of residuals, including those of empty lanes; albedos and prior take a block each.
    pub(super) fn residuals(&self) -> usize {
        let more = usize::from(self.albedos.is_some()) + usize::from(self.prior.is_some());
        3 * LANES * (self.lanes.len() + more)
    }
}

fn lanes(rows: &[LowerBound]) -> Vec<Lanes> {
    let level = Level::best();
    let of = |rows: &[LowerBound]| {
        let pairs: Vec<DirectionPair> = rows.iter().map(|row| row.pair).collect();
        let mut lanes = Lanes {
            block: Block::new(),
            weight: [0.0; LANES],
            target: [[0.0; LANES]; 3],
            counts: [0.0; LANES],
            above: [[0.0; LANES]; 3],
        };
        lanes.block.fill(level, &pairs);
        for (lane, LowerBound { pair, f, is_known }) in rows.iter().enumerate() {
            let cos_i = pair.cos_i();
            lanes.weight[lane] = cos_i;
            lanes.counts[lane] = 1.0;
            for channel in 0..3 {
                lanes.target[channel][lane] = libm::log1p(f[channel] * cos_i);
                lanes.above[channel][lane] = f64::from(u8::from(is_known[channel]));
            }
        }
        lanes
    };
    rows.chunks(LANES).map(of).collect()
}

/// Picks about `count` of these indices: half of them evenly, half evenly among the brightest
/// samples, so that even small highlights are included. In ascending order.
pub(super) fn pick_samples(samples: &Samples, indices: &[usize], count: usize) -> Vec<usize> {
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
