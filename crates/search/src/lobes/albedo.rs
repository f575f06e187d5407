//! What a fit reflects of all light that comes from a direction, held below 1.
//!
//! Next to the horizon are hardly any samples, and ln(1 + f cos_i) tells little of f there. A fit of white paper that is off by
//! 0.009 reflected twice what came from 89 degrees, and the energy limit divides all of a material by the most that it reflects.

use brood_brdf::Input;
use brood_eval::{Level, LobeRule, around};
use rayon::prelude::*;

use super::batch::{Batch, points};
use super::flux::Flux;
use super::normal::Normal;
use super::sweep::{Numbers, Room, Sweep};
use super::{Lobes, Shape};
use crate::Samples;

/// Where light comes from, in degrees from the normal.
pub(crate) const ANGLES: [f64; 12] =
    [0.0, 30.0, 50.0, 62.0, 70.0, 76.0, 80.0, 83.0, 85.5, 87.5, 88.7, 89.5];
/// Of the quadrature.
const ORDER: usize = 12;
/// What is held, and what is let be. The quadrature is off by up to 3 %, usually far less; the energy limit takes care of the rest.
const HELD: f64 = 0.975;
pub(super) const TOLERATED: f64 = 0.985;
/// What the square of an excess counts of the mean of squared differences.
pub(crate) const IMPORTANCE: f64 = 0.3;

/// Nodes of the quadratures of directional albedos.
#[derive(Debug, Clone)]
pub(super) struct Albedos {
    /// One for each angle.
    nodes: Vec<Batch>,
}

impl Albedos {
    pub(super) fn new(shape: &Shape) -> Self {
        let rule = LobeRule::new(ORDER);
        let is_mirrored = !shape.inputs.contains(&Input::MirrorAsymmetry);
        Self {
            nodes: ANGLES
                .par_iter()
                .map(|angle| nodes(&rule, *angle, is_mirrored, shape))
                .collect(),
        }
    }

    /// Of any channel and angle.
    pub(super) fn largest(&self, lobes: &Lobes) -> f64 {
        self.values(lobes).as_flattened().iter().fold(0.0, |most, albedo| albedo.max(most))
    }

    /// In mean squared differences.
    pub(super) fn cost(&self, lobes: &Lobes) -> f64 {
        let values = self.values(lobes);
        IMPORTANCE * values.as_flattened().iter().map(|albedo| excess(*albedo).powi(2)).sum::<f64>()
    }

    /// Adds to the normal equations of so many squared differences, and is the same cost.
    pub(super) fn add(&self, lobes: &Lobes, normal: &mut Normal, total: f64) -> f64 {
        let numbers = Numbers::new(lobes);
        let albedo = |batch: &Batch| {
            let mut slopes = [0, 1, 2].map(|_| vec![0.0; lobes.numbers.len()]);
            (reflected(&numbers, batch, Some(&mut slopes)), slopes)
        };
        let all: Vec<_> = self.nodes.par_iter().map(albedo).collect();
        let free: Vec<usize> = (0..lobes.numbers.len()).filter(|at| lobes.free[*at]).collect();
        let mut cost = 0.0;
        for (albedo, slopes) in all {
            for (albedo, slopes) in albedo.into_iter().zip(slopes) {
                let excess = excess(albedo);
                if excess == 0.0 {
                    continue;
                }
                cost += IMPORTANCE * excess * excess;
                for (row, a) in free.iter().enumerate() {
                    let slope = IMPORTANCE * total * slopes[*a];
                    normal.gradient[row] += slope * excess;
                    for (column, b) in free.iter().enumerate() {
                        normal.matrix[row * free.len() + column] += slope * slopes[*b];
                    }
                }
            }
        }
        cost
    }

    /// [angle][channel].
    fn values(&self, lobes: &Lobes) -> Vec<[f64; 3]> {
        let numbers = Numbers::new(lobes);
        self.nodes.par_iter().map(|batch| reflected(&numbers, batch, None)).collect()
    }
}

fn excess(albedo: f64) -> f64 {
    (albedo - HELD).max(0.0)
}

fn reflected(numbers: &Numbers, batch: &Batch, mut slopes: Option<&mut [Vec<f64>; 3]>) -> [f64; 3] {
    let mut room = Room::new(&numbers.shape);
    let mut sums = [0.0; 3];
    for block in &batch.blocks {
        let sweep = Sweep { numbers, block, gain: 1.0, room: &mut room, sums: None };
        let reflected = Level::best().run(Flux { sweep, slopes: slopes.as_deref_mut() });
        sums = [0, 1, 2].map(|channel| sums[channel] + reflected[channel]);
    }
    sums
}

/// Where light that comes from that angle goes, and what f counts there. Of a material that is its own mirror image half is enough.
#[expect(clippy::cast_possible_truncation, reason = "the fit is of f32, as the machine is")]
fn nodes(rule: &LobeRule, angle: f64, is_mirrored: bool, shape: &Shape) -> Batch {
    let (sin, cos) = libm::sincos(angle.to_radians());
    let wi = around(sin, cos, 0.0);
    let nodes = rule.nodes(wi).into_iter();
    let half = nodes.filter(|(pair, _)| !is_mirrored || pair.wo().y > 0.0);
    let (pairs, weights): (Vec<_>, Vec<f64>) = half.unzip();
    let whole = if is_mirrored { 2.0 } else { 1.0 };
    let values = vec![[0.0; 3]; pairs.len()];
    let mut points = points(&Samples::new(pairs, values), shape);
    for (point, weight) in points.iter_mut().zip(weights) {
        point.importance = (whole * weight) as f32;
    }
    Batch::new(points.iter())
}

#[cfg(test)]
#[path = "albedo_tests.rs"]
mod tests;
