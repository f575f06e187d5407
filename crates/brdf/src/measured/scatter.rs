//! A material that is known by samples at scattered pairs of directions, interpolated between them.
//!
//! It assumes that the material is isotropic and the same as its mirror image, and reciprocal where only one of a pair and its swap was
//! measured. Where samples came from, it does not know.

mod node;
mod place;
#[cfg(test)]
mod tests;
mod tree;

use glam::DVec3;

use super::sample::Samples;
use crate::{Brdf, Claims, DirectionPair};
use node::{Neighbour, Node};
use place::{place, swapped};
use tree::Tree;

/// Samples that are mixed, and those whose values decide what a sample says of its neighbourhood, itself included.
const MIXED: usize = 8;
const FITTED: usize = 29;
/// Interpolated is ln(f + floor); the floor is this part of the middle one of the samples' brightest channels.
const FLOOR: f64 = 1e-3;
/// Samples whose coordinates agree to this are one.
const SAME: f64 = 1e-6;
/// So many times as far as samples usually are is where none is.
const GAP: f64 = 2.0;
/// Natural logarithms above this are no f64's.
const LARGEST: f64 = 700.0;

/// Interpolated samples.
///
/// At a sample it is the sample's value (0 where that is below 0), between samples it is continuous; beyond them, and where they are
/// few, it stays near the range of the nearest ones.
///
/// # Source
/// The weights of Franke and Little (Franke 1982), with polynomials for the samples as Renka 1988 has them, in the coordinates of
/// `docs/maths/shading.md`.
pub struct Scattered {
    tree: Tree,
    /// In the order of the tree.
    nodes: Vec<Node>,
    floor: f64,
}

impl Scattered {
    /// Prepares samples. The same for the same samples in the same order.
    #[must_use]
    pub fn new(samples: &Samples) -> Self {
        let merged = complete(merge(samples));
        let floor = floor(&merged);
        let points: Vec<DVec3> = merged.iter().map(|(place, _)| *place).collect();
        let (tree, order) = Tree::new(&points);
        let logarithm = |value: f64| libm::log(value.max(0.0) + floor);
        let values: Vec<[f64; 3]> =
            order.iter().map(|index| merged[*index].1.to_array().map(logarithm)).collect();
        let nodes = (0..values.len()).map(|place| node(&tree, &values, place)).collect();
        Self { tree, nodes, floor }
    }

    fn at(&self, at: DVec3) -> DVec3 {
        let found = self.tree.nearest::<MIXED>(at);
        let radius = found.squares[found.count - 1].sqrt() * (1.0 + 1e-6);
        let mut sum = [0.0; 3];
        let mut total = 0.0;
        let mut ranges = [(f64::INFINITY, f64::NEG_INFINITY); 3];
        for (square, place) in found.squares.iter().zip(found.places).take(found.count) {
            let node = &self.nodes[place];
            let distance = square.sqrt();
            // Without end at the sample, 0 where the next one would take its place.
            let weight = (radius - distance) / (radius * distance + f64::MIN_POSITIVE.sqrt());
            let weight = (weight * weight).clamp(1e-30, 1e30);
            total += weight;
            let told = node.at(at - self.tree.point(place));
            for channel in 0..3 {
                sum[channel] += weight * told[channel];
                let ((low, high), (least, most)) = (ranges[channel], node.range(channel));
                ranges[channel] = (low.min(least), high.max(most));
            }
        }
        let value = |channel: usize| {
            let (low, high) = ranges[channel];
            let logarithm = (sum[channel] / total).clamp(low, high).min(LARGEST);
            (libm::exp(logarithm) - self.floor).max(0.0)
        };
        DVec3::from_array([0, 1, 2].map(value))
    }
}

impl Brdf for Scattered {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        place(pair).map_or(DVec3::ZERO, |place| self.at(place))
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: false, conserving: false }
    }
}

/// Places and values; the mean of the values where several samples are at the same place.
fn merge(samples: &Samples) -> Vec<(DVec3, DVec3)> {
    let mut placed: Vec<([i64; 3], DVec3, DVec3)> = Vec::with_capacity(samples.rows().len());
    for (pair, rgb) in samples.rows() {
        if let Some(place) = place(pair) {
            placed.push((cell(place), place, *rgb));
        }
    }
    // The sort is stable, so that the mean does not depend on chance.
    placed.sort_by_key(|(cell, ..)| *cell);
    let group = |group: &[([i64; 3], DVec3, DVec3)]| {
        let sum: DVec3 = group.iter().map(|(.., rgb)| *rgb).sum();
        (group[0].1, sum / group.len() as f64)
    };
    placed.chunk_by(|a, b| a.0 == b.0).map(group).collect()
}

/// Adds swapped samples where the swapped pair was not measured: no sample there is as near as those that are mixed at the sample itself,
/// or as `GAP` times that. Where both were, each is believed; goniometers often contradict themselves there.
fn complete(mut samples: Vec<(DVec3, DVec3)>) -> Vec<(DVec3, DVec3)> {
    let points: Vec<DVec3> = samples.iter().map(|(place, _)| *place).collect();
    let (tree, _) = Tree::new(&points);
    let is_missing = |(place, _): &&(DVec3, DVec3)| {
        let own = tree.nearest::<MIXED>(*place);
        tree.nearest::<1>(swapped(*place)).squares[0] > GAP * GAP * own.squares[own.count - 1]
    };
    let missing = samples.iter().filter(is_missing);
    let missing: Vec<_> = missing.map(|(place, rgb)| (swapped(*place), *rgb)).collect();
    samples.extend(missing);
    samples
}

#[expect(clippy::cast_possible_truncation, reason = "coordinates are at most 1")]
fn cell(place: DVec3) -> [i64; 3] {
    place.to_array().map(|part| (part / SAME).round() as i64)
}

fn floor(samples: &[(DVec3, DVec3)]) -> f64 {
    let mut brightest: Vec<f64> = samples.iter().map(|(_, rgb)| rgb.max_element()).collect();
    let (_, middle, brighter) = {
        let middle = brightest.len() / 2;
        brightest.select_nth_unstable_by(middle, f64::total_cmp)
    };
    // Where most is black, what is not counts alone.
    let largest = brighter.iter().copied().fold(*middle, f64::max);
    let scale = if *middle > 0.0 { *middle } else { largest };
    if scale > 0.0 { (scale * FLOOR).max(f64::MIN_POSITIVE) } else { 1.0 }
}

/// What the sample at a place of the tree says.
fn node(tree: &Tree, values: &[[f64; 3]], place: usize) -> Node {
    let here = tree.point(place);
    let found = tree.nearest::<FITTED>(here);
    let radius = found.squares[found.count - 1].sqrt() * 1.001;
    let others = found.places[..found.count].iter().filter(|other| **other != place);
    let neighbour =
        |other: &usize| Neighbour { offset: tree.point(*other) - here, value: values[*other] };
    let neighbours: Vec<Neighbour> = others.map(neighbour).collect();
    Node::fit(values[place], &neighbours, radius)
}
