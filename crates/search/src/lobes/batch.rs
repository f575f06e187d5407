//! Samples as the fit reads them: rows of lanes, block by block.

use std::sync::Arc;

use brood_brdf::Input;
use brood_scene::SampleSet;

use super::Shape;
use super::albedo::Albedos;
use crate::Samples;

/// Samples of a block.
pub(super) const LANES: usize = 256;

/// One number for each sample of a block.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Row(pub(super) [f32; LANES]);

impl Row {
    pub(super) const ZERO: Self = Self([0.0; LANES]);
}

/// What is known of the samples of a block.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Of each input of the shape.
    pub(super) inputs: Vec<Row>,
    /// What f counts times: cos_i.
    pub(super) weight: Row,
    /// ln(1 + f cos_i) that is wanted of red, green and blue.
    pub(super) wanted: [Row; 3],
    /// ln(1 + f cos_i / m) that is wanted of them, m being an eighth of the median of what is wanted.
    pub(super) relative: [Row; 3],
    /// Root of what a squared difference counts; 0 beyond the last sample.
    pub(super) importance: Row,
    /// Root of what a squared difference of `relative` counts; 0 where what is wanted is a bound, and beyond the last sample.
    pub(super) share: Row,
    /// 1 where what is wanted is a bound from above, -1 where it is one from below, 0 where it is a value.
    pub(super) side: Row,
}

/// Samples in blocks.
#[derive(Debug, Clone)]
pub struct Batch {
    pub(super) blocks: Vec<Block>,
    /// 1 / m.
    pub(super) gain: f32,
    /// Sum of what the squared differences count, over samples and channels.
    pub(super) total: f64,
    /// What the square of each number of the shape costs, as often as `cost` says.
    pub(super) ridge: Vec<f64>,
    /// In units of the mean of the squared differences.
    pub(super) cost: f64,
    /// Where these count as well.
    pub(super) albedos: Option<Arc<Albedos>>,
}

/// A sample, before it has been put into a block.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub(super) inputs: Vec<f32>,
    pub(super) weight: f32,
    pub(super) wanted: [f32; 3],
    pub(super) relative: [f32; 3],
    pub(super) gain: f32,
    pub(super) importance: f32,
    pub(super) share: f32,
    pub(super) side: f32,
}

/// Root of what squared differences of ln(1 + f cos_i / m) count of those of ln(1 + f cos_i). Without, a dark body under a bright
/// highlight is as good as black.
const SHARE: f64 = 0.6;
/// m over the median of what is wanted. Eyes see differences relative to what is there far below it.
const BELOW_MEDIAN: f64 = 0.125;
/// m is at least this and at most 1, and then the two are the same.
const DARKEST: f64 = 1e-5;

impl Batch {
    /// Of points whose inputs are those of one shape.
    pub(super) fn new<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let mut batch = Self {
            blocks: Vec::new(),
            gain: 1.0,
            total: 0.0,
            ridge: Vec::new(),
            cost: 0.0,
            albedos: None,
        };
        let mut lane = LANES;
        for point in points {
            if lane == LANES {
                // What is beyond the last sample is like the first of its block, and counts nothing.
                let repeated = |value: f32| Row([value; LANES]);
                batch.blocks.push(Block {
                    inputs: point.inputs.iter().map(|value| repeated(*value)).collect(),
                    weight: repeated(point.weight),
                    wanted: point.wanted.map(repeated),
                    relative: point.relative.map(repeated),
                    importance: Row::ZERO,
                    share: Row::ZERO,
                    side: Row::ZERO,
                });
                lane = 0;
            }
            let block = batch.blocks.last_mut().expect("one has been pushed");
            for (row, value) in block.inputs.iter_mut().zip(&point.inputs) {
                row.0[lane] = *value;
            }
            for (row, value) in block.wanted.iter_mut().zip(point.wanted) {
                row.0[lane] = value;
            }
            for (row, value) in block.relative.iter_mut().zip(point.relative) {
                row.0[lane] = value;
            }
            // Bounds have nothing to be relative to.
            if point.share > 0.0 {
                batch.gain = point.gain;
            }
            block.share.0[lane] = point.share;
            block.weight.0[lane] = point.weight;
            block.importance.0[lane] = point.importance;
            block.side.0[lane] = point.side;
            batch.total += 3.0 * f64::from(point.importance) * f64::from(point.importance);
            lane += 1;
        }
        batch
    }
}

impl Batch {
    /// The same with more points, of the same shape.
    pub(super) fn with<'a>(&self, points: impl Iterator<Item = &'a Point>) -> Self {
        let Self { blocks, total, .. } = Self::new(points);
        let mut both = self.clone();
        both.blocks.extend(blocks);
        both.total += total;
        both
    }

    /// The same where reflecting more than there is costs something.
    pub(super) fn under(self, albedos: &Arc<Albedos>) -> Self {
        Self { albedos: Some(albedos.clone()), ..self }
    }

    /// The same under a cost of large weights, each as far as its feature spreads, which says next to nothing where samples do.
    pub(super) fn with_ridge(self, shape: &Shape, points: &[Point]) -> Self {
        let spread = |input: usize| {
            let of = |point: &Point| f64::from(point.inputs[input]);
            let count = points.len() as f64;
            let mean = points.iter().map(of).sum::<f64>() / count;
            points.iter().map(|point| (of(point) - mean) * (of(point) - mean)).sum::<f64>() / count
        };
        let spreads: Vec<f64> = (0..shape.inputs.len()).map(spread).collect();
        let mut ridge = vec![0.0; shape.len()];
        for (input, spread) in spreads.iter().enumerate() {
            for unit in 0..shape.units {
                ridge[shape.unit(unit, input)] = *spread;
            }
            for term in 0..shape.terms {
                ridge[shape.term(term, shape.units + input)] = *spread;
            }
        }
        for term in 0..shape.terms {
            for unit in 0..shape.units {
                ridge[shape.term(term, unit)] = 1.0;
            }
        }
        Self { ridge, ..self }
    }
}

/// 1 / m of samples: what differences are relative to that can be seen although they are small.
fn gain(weighted: &[[f64; 3]]) -> f64 {
    let mut all: Vec<f64> = weighted.iter().map(|value| value.iter().sum::<f64>() / 3.0).collect();
    all.sort_by(f64::total_cmp);
    let median = all.get(all.len() / 2).copied().unwrap_or(1.0);
    1.0 / (BELOW_MEDIAN * median).clamp(DARKEST, 1.0)
}

/// The points where nothing is known but that f is not below a value, each counting 1 where it is.
pub(super) fn least(samples: &Samples, shape: &Shape) -> Vec<Point> {
    let (pairs, values) = samples.least().iter().copied().unzip();
    let points = points(&Samples::new(pairs, values), shape);
    points.into_iter().map(|point| Point { share: 0.0, side: -1.0, ..point }).collect()
}

/// The points of samples, with the inputs of a shape, each counting 1.
#[expect(clippy::cast_possible_truncation, reason = "the fit is of f32, as the machine is")]
pub(super) fn points(samples: &Samples, shape: &Shape) -> Vec<Point> {
    let set = SampleSet::from_pairs(samples.pairs(), &[]);
    let inputs: Vec<&[f32]> = shape.inputs.iter().map(|input: &Input| set.input(*input)).collect();
    let weighted = samples.weighted();
    let gain = gain(&weighted);
    (0..samples.len())
        .map(|k| Point {
            inputs: inputs.iter().map(|row| row[k]).collect(),
            weight: samples.pairs()[k].cos_i() as f32,
            wanted: weighted[k].map(|value| libm::log1p(value) as f32),
            relative: weighted[k].map(|value| libm::log1p(gain * value) as f32),
            gain: gain as f32,
            importance: 1.0,
            share: SHARE as f32,
            side: 0.0,
        })
        .collect()
}
