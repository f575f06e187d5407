//! Samples as the fit reads them: blocks of 256 samples, one per lane, with one row for each
//! quantity.

use std::sync::Arc;

use brood_brdf::Input;
use brood_scene::SampleSet;
use brood_target::Samples;

use super::Shape;
use super::albedo::Albedos;

/// Number of samples per block.
pub(super) const LANES: usize = 256;

/// One value for each sample of a block.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Row(pub(super) [f32; LANES]);

impl Row {
    pub(super) const ZERO: Self = Self([0.0; LANES]);
}

/// One block of samples.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Values of each input of the shape.
    pub(super) inputs: Vec<Row>,
    /// Factor of f: cos_i, or at least a floor if the sample is a bound.
    pub(super) weight: Row,
    /// Target ln(1 + f cos_i) of red, green and blue.
    pub(super) target: [Row; 3],
    /// Target ln(1 + f cos_i / m) of each channel, m being an eighth of the median target.
    pub(super) relative: [Row; 3],
    /// Root of the weight of a squared difference; 0 beyond the last sample.
    pub(super) importance: Row,
    /// Root of the weight of a squared difference of `relative`; 0 for bounds and beyond the last
    /// sample.
    pub(super) share: Row,
    /// 1 if the target is an upper bound, -1 if it is a lower bound, 0 if it is a value.
    pub(super) side: Row,
}

/// Samples in blocks, with the penalties of the objective.
#[derive(Debug, Clone)]
pub struct Batch {
    pub(super) blocks: Vec<Block>,
    /// 1 / m, as in [`Block::relative`].
    pub(super) gain: f32,
    /// Sum over samples and channels of the weights of the squared differences of ln(1 + f cos_i),
    /// bounds included. Divides sums to get means.
    pub(super) total: f64,
    /// Ridge weight of each parameter of the shape; multiplied by `cost`.
    pub(super) ridge: Vec<f64>,
    /// Factor of the ridge penalty, in the unit of the mean squared difference.
    pub(super) cost: f64,
    /// Quadrature of the albedo penalty, if there is one.
    pub(super) albedos: Option<Arc<Albedos>>,
}

/// A sample before it is put into a block; fields as in [`Block`] and [`Batch`].
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub(super) inputs: Vec<f32>,
    pub(super) weight: f32,
    pub(super) target: [f32; 3],
    pub(super) relative: [f32; 3],
    pub(super) gain: f32,
    pub(super) importance: f32,
    pub(super) share: f32,
    pub(super) side: f32,
}

/// Root of the weight of squared differences of ln(1 + f cos_i / m), relative to those of ln(1 + f
/// cos_i). Without the former, a black body under a bright highlight fits as well as the dark one
/// that was measured.
const SHARE: f64 = 0.6;
/// m over the median of the target's f cos_i. Vision is sensitive to relative differences far below
/// the median.
const BELOW_MEDIAN: f64 = 0.125;
/// Least m. The largest m is 1: both differences are then the same.
const DARKEST: f64 = 1e-5;

impl Batch {
    /// Packs points, whose inputs are those of one shape, into blocks.
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
                // Lanes beyond the last sample repeat the first of the block, with weight 0.
                let repeated = |value: f32| Row([value; LANES]);
                batch.blocks.push(Block {
                    inputs: point.inputs.iter().map(|value| repeated(*value)).collect(),
                    weight: repeated(point.weight),
                    target: point.target.map(repeated),
                    relative: point.relative.map(repeated),
                    importance: Row::ZERO,
                    share: Row::ZERO,
                    side: Row::ZERO,
                });
                lane = 0;
            }
            let block = batch.blocks.last_mut().expect("the first point adds a block");
            for (row, value) in block.inputs.iter_mut().zip(&point.inputs) {
                row.0[lane] = *value;
            }
            for (row, value) in block.target.iter_mut().zip(point.target) {
                row.0[lane] = value;
            }
            for (row, value) in block.relative.iter_mut().zip(point.relative) {
                row.0[lane] = value;
            }
            // Bounds have no relative difference and no gain.
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
    /// Copy with more points of the same shape.
    pub(super) fn with<'a>(&self, points: impl Iterator<Item = &'a Point>) -> Self {
        let Self { blocks, total, .. } = Self::new(points);
        let mut both = self.clone();
        both.blocks.extend(blocks);
        both.total += total;
        both
    }

    /// Adds the albedo penalty.
    pub(super) fn with_albedo_penalty(self, albedos: &Arc<Albedos>) -> Self {
        Self { albedos: Some(albedos.clone()), ..self }
    }

    /// Adds a ridge penalty on weights, each scaled by the variance of its feature. It is
    /// negligible where samples determine a weight.
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

/// 1 / m of the samples.
fn gain(weighted: &[[f64; 3]]) -> f64 {
    let mut all: Vec<f64> = weighted.iter().map(|value| value.iter().sum::<f64>() / 3.0).collect();
    all.sort_by(f64::total_cmp);
    let median = all.get(all.len() / 2).copied().unwrap_or(1.0);
    1.0 / (BELOW_MEDIAN * median).clamp(DARKEST, 1.0)
}

/// Points of the lower bounds of `samples`, each of weight 1.
pub(super) fn lower_bounds(samples: &Samples, shape: &Shape) -> Vec<Point> {
    let (pairs, values) = samples.lower_bounds().iter().copied().unzip();
    let points = points(&Samples::new(pairs, values), shape);
    points.into_iter().map(|point| Point { share: 0.0, side: -1.0, ..point }).collect()
}

/// Points of the samples, with the inputs of a shape, each of weight 1.
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
            target: weighted[k].map(|value| libm::log1p(value) as f32),
            relative: weighted[k].map(|value| libm::log1p(gain * value) as f32),
            gain: gain as f32,
            importance: 1.0,
            share: SHARE as f32,
            side: 0.0,
        })
        .collect()
}
