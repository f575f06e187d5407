//! Samples as the fit reads them: blocks of 256 samples, one per lane, with one row for each
//! quantity.

use brood_brdf::Input;
use brood_genome::lobes::Shape;
use brood_scene::SampleSet;
use brood_target::Samples;

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

/// A sample before it is put into a block; fields as in [`Block`].
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

/// Packs points, whose inputs are those of one shape, into blocks.
pub(super) fn blocks<'a>(points: impl Iterator<Item = &'a Point>) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lane = LANES;
    for point in points {
        if lane == LANES {
            // Lanes beyond the last sample repeat the first of the block, with weight 0.
            let repeated = |value: f32| Row([value; LANES]);
            blocks.push(Block {
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
        let block: &mut Block = blocks.last_mut().expect("the first point adds a block");
        for (row, value) in block.inputs.iter_mut().zip(&point.inputs) {
            row.0[lane] = *value;
        }
        for (row, value) in block.target.iter_mut().zip(point.target) {
            row.0[lane] = value;
        }
        for (row, value) in block.relative.iter_mut().zip(point.relative) {
            row.0[lane] = value;
        }
        block.share.0[lane] = point.share;
        block.weight.0[lane] = point.weight;
        block.importance.0[lane] = point.importance;
        block.side.0[lane] = point.side;
        lane += 1;
    }
    blocks
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
    let (pairs, values) = samples.lower_bounds().iter().map(|bound| (bound.pair, bound.f)).unzip();
    let points = points(&Samples::new(pairs, values), shape);
    points.into_iter().map(|point| Point { share: 0.0, side: -1.0, ..point }).collect()
}

/// Points of the samples, with the inputs of a shape, each of weight 1.
pub(super) fn points(samples: &Samples, shape: &Shape) -> Vec<Point> {
    points_of_gain(samples, shape, gain(&samples.weighted()))
}

/// Points of the samples, and of their expected values.
pub(super) fn points_with_expected(samples: &Samples, shape: &Shape) -> (Vec<Point>, Vec<Point>) {
    let gain = gain(&samples.weighted());
    let (pairs, values) = samples.expected().iter().copied().unzip();
    let expected = points_of_gain(&Samples::new(pairs, values), shape, gain);
    (points_of_gain(samples, shape, gain), expected)
}

#[expect(clippy::cast_possible_truncation, reason = "the fit is of f32, as the machine is")]
fn points_of_gain(samples: &Samples, shape: &Shape, gain: f64) -> Vec<Point> {
    let set = SampleSet::from_pairs(samples.pairs(), &[]);
    let inputs: Vec<&[f32]> = shape.inputs.iter().map(|input: &Input| set.input(*input)).collect();
    let weighted = samples.weighted();
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
