//! Samples in blocks, with the penalties of the objective.

use brood_genome::lobes::Shape;
use std::sync::Arc;

use super::albedo::Albedos;
use super::block::{Block, Point, blocks};

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

impl Batch {
    /// Packs points, whose inputs are those of one shape.
    pub(super) fn new<'a>(points: impl Iterator<Item = &'a Point> + Clone) -> Self {
        let mut batch = Self {
            blocks: blocks(points.clone()),
            gain: 1.0,
            total: 0.0,
            ridge: Vec::new(),
            cost: 0.0,
            albedos: None,
        };
        for point in points {
            // Bounds have no relative difference and no gain.
            if point.share > 0.0 {
                batch.gain = point.gain;
            }
            batch.total += 3.0 * f64::from(point.importance) * f64::from(point.importance);
        }
        batch
    }

    /// Copy with more points of the same shape.
    pub(super) fn with<'a>(&self, points: impl Iterator<Item = &'a Point> + Clone) -> Self {
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
