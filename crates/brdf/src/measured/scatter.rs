//! Material given by samples at scattered pairs of directions, interpolated between them.
//!
//! Assumes that the material is isotropic and symmetric under mirroring, and reciprocal where only
//! one of a pair and its swap was measured. Independent of the source of the samples.

mod coordinates;
mod node;
#[cfg(test)]
mod tests;
mod tree;

use glam::DVec3;

use super::sample::MeasuredSamples;
use crate::{Brdf, Claims, DirectionPair};
use coordinates::{coordinates, swapped};
use node::{Neighbour, Node};
use tree::Tree;

/// Number of nearest samples that are blended.
const BLENDED: usize = 8;
/// Number of nearest samples that each local polynomial is fitted to, its own sample included.
const FITTED: usize = 29;
/// Offset of the interpolated quantity ln(f + floor), as a fraction of the median of the samples'
/// brightest channels.
const FLOOR: f64 = 1e-3;
/// Grid step of coordinates: samples in the same grid cell are merged.
const CELL: f64 = 1e-6;
/// A swapped pair counts as unmeasured if the nearest sample is farther away than this times the
/// distance of the last blended neighbour at the pair itself.
const GAP: f64 = 2.0;
/// Largest logarithm whose exponential is finite in f64.
const MAX_LOGARITHM: f64 = 700.0;

/// BRDF that interpolates scattered samples.
///
/// Equal to each sample's value at the sample (0 where that is below 0) and continuous in between.
/// Beyond the samples, and where they are sparse, it stays near the range of the nearest ones.
///
/// # Source
/// The weights of Franke and Little (Franke 1982) with local polynomials as in Renka 1988, in the
/// coordinates of `docs/maths/shading.md`.
pub struct Scattered {
    tree: Tree,
    /// Local polynomials, in the order of the tree.
    nodes: Vec<Node>,
    floor: f64,
}

impl Scattered {
    /// Prepares the interpolation. Deterministic for the same samples in the same order.
    #[must_use]
    pub fn new(samples: &MeasuredSamples) -> Self {
        let merged = complete(merge(samples));
        let floor = floor(&merged);
        let points: Vec<DVec3> = merged.iter().map(|(at, _)| *at).collect();
        let (tree, order) = Tree::new(&points);
        let logarithm = |value: f64| libm::log(value.max(0.0) + floor);
        let values: Vec<[f64; 3]> =
            order.iter().map(|index| merged[*index].1.to_array().map(logarithm)).collect();
        let nodes = (0..values.len()).map(|position| node(&tree, &values, position)).collect();
        Self { tree, nodes, floor }
    }

    /// Blends the predictions of the nearest samples at these coordinates, clamped to their ranges.
    fn at(&self, at: DVec3) -> DVec3 {
        let found = self.tree.nearest::<BLENDED>(at);
        let radius = found.squares[found.count - 1].sqrt() * (1.0 + 1e-6);
        let mut sum = [0.0; 3];
        let mut total = 0.0;
        let mut ranges = [(f64::INFINITY, f64::NEG_INFINITY); 3];
        for (square, position) in found.squares.iter().zip(found.positions).take(found.count) {
            let node = &self.nodes[position];
            let distance = square.sqrt();
            // Infinite at the sample, 0 at the distance of the farthest one.
            let weight = (radius - distance) / (radius * distance + f64::MIN_POSITIVE.sqrt());
            let weight = (weight * weight).clamp(1e-30, 1e30);
            total += weight;
            let predicted = node.at(at - self.tree.point(position));
            for channel in 0..3 {
                sum[channel] += weight * predicted[channel];
                let ((low, high), (least, most)) = (ranges[channel], node.range(channel));
                ranges[channel] = (low.min(least), high.max(most));
            }
        }
        let value = |channel: usize| {
            let (low, high) = ranges[channel];
            let logarithm = (sum[channel] / total).clamp(low, high).min(MAX_LOGARITHM);
            (libm::exp(logarithm) - self.floor).max(0.0)
        };
        DVec3::from_array([0, 1, 2].map(value))
    }
}

impl Brdf for Scattered {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        coordinates(pair).map_or(DVec3::ZERO, |at| self.at(at))
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: false, conserving: false }
    }
}

/// Returns coordinates and values, with samples at the same coordinates replaced by their mean.
fn merge(samples: &MeasuredSamples) -> Vec<(DVec3, DVec3)> {
    let mut placed: Vec<([i64; 3], DVec3, DVec3)> = Vec::with_capacity(samples.rows().len());
    for (pair, rgb) in samples.rows() {
        if let Some(at) = coordinates(pair) {
            placed.push((cell(at), at, *rgb));
        }
    }
    // The sort must be stable for the mean to be deterministic.
    placed.sort_by_key(|(cell, ..)| *cell);
    let group = |group: &[([i64; 3], DVec3, DVec3)]| {
        let sum: DVec3 = group.iter().map(|(.., rgb)| *rgb).sum();
        (group[0].1, sum / group.len() as f64)
    };
    placed.chunk_by(|a, b| a.0 == b.0).map(group).collect()
}

/// Adds swapped samples where the swapped pair was not measured, by the rule of [`GAP`]. Where both
/// pairs were measured both are kept: goniometers often contradict themselves there.
fn complete(mut samples: Vec<(DVec3, DVec3)>) -> Vec<(DVec3, DVec3)> {
    let points: Vec<DVec3> = samples.iter().map(|(at, _)| *at).collect();
    let (tree, _) = Tree::new(&points);
    let is_missing = |(at, _): &&(DVec3, DVec3)| {
        let own = tree.nearest::<BLENDED>(*at);
        tree.nearest::<1>(swapped(*at)).squares[0] > GAP * GAP * own.squares[own.count - 1]
    };
    let missing = samples.iter().filter(is_missing);
    let missing: Vec<_> = missing.map(|(at, rgb)| (swapped(*at), *rgb)).collect();
    samples.extend(missing);
    samples
}

#[expect(clippy::cast_possible_truncation, reason = "coordinates are at most 1")]
fn cell(at: DVec3) -> [i64; 3] {
    at.to_array().map(|part| (part / CELL).round() as i64)
}

/// Offset of the interpolated quantity; see [`FLOOR`].
fn floor(samples: &[(DVec3, DVec3)]) -> f64 {
    let mut brightest: Vec<f64> = samples.iter().map(|(_, rgb)| rgb.max_element()).collect();
    let (_, middle, brighter) = {
        let middle = brightest.len() / 2;
        brightest.select_nth_unstable_by(middle, f64::total_cmp)
    };
    // If most samples are black, only the others count.
    let largest = brighter.iter().copied().fold(*middle, f64::max);
    let scale = if *middle > 0.0 { *middle } else { largest };
    if scale > 0.0 { (scale * FLOOR).max(f64::MIN_POSITIVE) } else { 1.0 }
}

/// Fits the local polynomial of the sample at a position of the tree.
fn node(tree: &Tree, values: &[[f64; 3]], position: usize) -> Node {
    let here = tree.point(position);
    let found = tree.nearest::<FITTED>(here);
    let radius = found.squares[found.count - 1].sqrt() * 1.001;
    let others = found.positions[..found.count].iter().filter(|other| **other != position);
    let neighbour =
        |other: &usize| Neighbour { offset: tree.point(*other) - here, value: values[*other] };
    let neighbours: Vec<Neighbour> = others.map(neighbour).collect();
    Node::fit(values[position], &neighbours, radius)
}
