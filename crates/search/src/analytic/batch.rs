//! Samples as models read them: blocks of lanes with the target values of each lane, and means over
//! the lanes of shared blocks.

use std::sync::Arc;

use brood_brdf::{Block, DirectionPair};
use brood_eval::Level;
use brood_target::{LightMeans, LowerBound, MeanValue, Samples};

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

/// Means over pairs of directions.
#[derive(Debug, Clone)]
pub(super) struct Means {
    /// Blocks of all pairs.
    pub(super) blocks: Vec<Block<LANES>>,
    /// The means, with their terms at the pairs.
    pub(super) means: LightMeans,
    /// Target values of the means. The blocks of these lanes are empty.
    pub(super) lanes: Vec<Lanes>,
}

/// Samples in blocks, with an optional albedo penalty.
#[derive(Debug, Clone)]
pub(super) struct Batch {
    pub(super) lanes: Arc<Vec<Lanes>>,
    /// `None` if there are no means.
    pub(super) means: Option<Arc<Means>>,
    /// Number of samples and means times channels.
    pub(super) total: f64,
    /// Quadrature and level of the penalty on albedos above that level.
    pub(super) albedos: Option<(Arc<Albedos>, f64)>,
    /// Residual from which differences count less than their square; infinite if all count fully.
    pub(super) large: f64,
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
        let lanes = Arc::new(lanes(&rows));
        Self { lanes, means: None, total, albedos: None, large: f64::INFINITY, prior: None }
    }

    /// Adds means over pairs of directions.
    pub(super) fn with_means(mut self, means: LightMeans) -> Self {
        if !means.is_empty() {
            self.total += 3.0 * means.samples() as f64;
            self.means = Some(Arc::new(Means::new(means)));
        }
        self
    }

    /// Adds the lower bounds of `samples`, at most about as many as the batch has samples.
    pub(super) fn with_lower_bounds(mut self, samples: &Samples) -> Self {
        let most = (self.lanes.len() * LANES).max(1);
        let step = samples.lower_bounds().len().div_ceil(most).max(1);
        let rows: Vec<LowerBound> = samples.lower_bounds().iter().step_by(step).copied().collect();
        Arc::make_mut(&mut self.lanes).extend(lanes(&rows));
        self
    }

    /// Makes differences above `large` count less than their square: about linearly.
    pub(super) fn with_large(self, large: f64) -> Self {
        Self { large, ..self }
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
        let means = self.means.as_ref().map_or(0, |means| means.lanes.len());
        3 * LANES * (self.lanes.len() + means + more)
    }
}

impl Means {
    fn new(means: LightMeans) -> Self {
        let of = |values: &[MeanValue]| {
            let mut lanes = Lanes::empty();
            for (lane, value) in values.iter().enumerate() {
                lanes.put(lane, 1.0, value.mean, value.is_known);
            }
            lanes
        };
        let lanes = means.values().chunks(LANES).map(of).collect();
        Self { blocks: means.pairs().chunks(LANES).map(block).collect(), lanes, means }
    }
}

impl Lanes {
    fn empty() -> Self {
        Self {
            block: Block::new(),
            weight: [0.0; LANES],
            target: [[0.0; LANES]; 3],
            counts: [0.0; LANES],
            above: [[0.0; LANES]; 3],
        }
    }

    fn put(&mut self, lane: usize, cos_i: f64, f: [f64; 3], is_known: [bool; 3]) {
        self.weight[lane] = cos_i;
        self.counts[lane] = 1.0;
        for channel in 0..3 {
            self.target[channel][lane] = libm::log1p(f[channel] * cos_i);
            self.above[channel][lane] = f64::from(u8::from(is_known[channel]));
        }
    }
}

fn block(pairs: &[DirectionPair]) -> Block<LANES> {
    let mut block = Block::new();
    block.fill(Level::best(), pairs);
    block
}

fn lanes(rows: &[LowerBound]) -> Vec<Lanes> {
    let of = |rows: &[LowerBound]| {
        let pairs: Vec<DirectionPair> = rows.iter().map(|row| row.pair).collect();
        let mut lanes = Lanes { block: block(&pairs), ..Lanes::empty() };
        for (lane, LowerBound { pair, f, is_known }) in rows.iter().enumerate() {
            lanes.put(lane, pair.cos_i(), *f, *is_known);
        }
        lanes
    };
    rows.chunks(LANES).map(of).collect()
}

/// Picks some of these means as [`pick_samples`] does, `count` at most, and no more than refer to
/// about `pairs` pairs of directions.
pub(super) fn pick_means(
    means: &LightMeans,
    indices: &[usize],
    (count, pairs): (usize, usize),
) -> LightMeans {
    let per_mean = means.pairs().len().div_ceil(means.len().max(1)).max(1);
    let brightness = |at: usize| means.values()[at].mean.into_iter().fold(0.0, f64::max);
    means.select(pick(indices, brightness, count.min(pairs / per_mean)))
}

/// Picks about `count` of these indices: half of them evenly, half evenly among the brightest
/// samples, so that even small highlights are included. In ascending order.
pub(super) fn pick_samples(samples: &Samples, indices: &[usize], count: usize) -> Vec<usize> {
    let brightness = |at: usize| -> f64 {
        let cos_i = samples.pairs()[at].cos_i();
        samples.values()[at].iter().fold(0.0f64, |most, f| most.max(*f)) * cos_i
    };
    pick(indices, brightness, count)
}

fn pick(indices: &[usize], brightness: impl Fn(usize) -> f64, count: usize) -> Vec<usize> {
    if indices.len() <= count {
        return indices.to_vec();
    }
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
