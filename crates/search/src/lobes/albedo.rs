//! Directional albedos of fits, and the penalty that keeps them below 1.
//!
//! Few samples are near the horizon, and ln(1 + f cos_i) is insensitive to f there. A fit of white
//! paper with an E_log of 0.009 had an albedo of 2 at 89 degrees. The energy limit divides f by the
//! largest albedo, which makes such a fit too dark at all angles.

use brood_brdf::Input;
use brood_eval::{Level, LobeRule, direction_at};
use brood_genome::lobes::Shape;
use brood_target::Samples;
use rayon::prelude::*;

use super::Lobes;
use super::block::{Block, blocks, points};
use super::flux::Flux;
use super::sweep::{Parameters, Sweep, Workspace};
use crate::levenberg_marquardt::NormalEquations;

/// Angles of the incident light, in degrees from the normal. The last ones divide the cosine by
/// about five, down to the 1e-6 at which the energy limit ends.
pub(crate) const ANGLES: [f64; 17] = [
    0.0, 30.0, 50.0, 62.0, 70.0, 76.0, 80.0, 83.0, 85.5, 87.5, 88.7, 89.5, 89.9, 89.98, 89.996,
    89.9992, 89.99994,
];
/// Order of the quadrature ([`LobeRule`]).
const ORDER: usize = 12;
/// Albedo above which the penalty is not 0, and albedo from which on a fit gets the penalty. The
/// quadrature is off by up to 3 %, usually far less; the energy limit covers the rest.
const PENALTY_ALBEDO: f64 = 0.975;
pub(super) const TOLERATED_ALBEDO: f64 = 0.985;
/// Weight of a squared excess, relative to the mean squared difference.
pub(crate) const IMPORTANCE: f64 = 0.3;

/// Nodes of the quadratures of directional albedos.
#[derive(Debug, Clone)]
pub(super) struct Albedos {
    /// Nodes of each of [`ANGLES`], as samples whose importance is the quadrature weight.
    nodes: Vec<Vec<Block>>,
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

    /// Largest albedo of any channel and angle.
    pub(super) fn largest(&self, lobes: &Lobes) -> f64 {
        self.values(lobes).as_flattened().iter().fold(0.0, |most, albedo| albedo.max(most))
    }

    /// Albedo penalty, in the unit of the mean squared difference to which it is added.
    pub(super) fn cost(&self, lobes: &Lobes) -> f64 {
        let values = self.values(lobes);
        IMPORTANCE * values.as_flattened().iter().map(|albedo| excess(*albedo).powi(2)).sum::<f64>()
    }

    /// Adds the albedo penalty to normal equations that are sums of squared differences of total
    /// weight `total`; returns the penalty as in [`Albedos::cost`].
    pub(super) fn add(&self, lobes: &Lobes, normal: &mut NormalEquations, total: f64) -> f64 {
        let parameters = Parameters::new(lobes);
        let albedo = |blocks: &Vec<Block>| {
            let mut gradients = [0, 1, 2].map(|_| vec![0.0; lobes.parameters.len()]);
            (reflected(&parameters, blocks, Some(&mut gradients)), gradients)
        };
        let all: Vec<_> = self.nodes.par_iter().map(albedo).collect();
        let free: Vec<usize> = (0..lobes.parameters.len()).filter(|at| lobes.free[*at]).collect();
        let mut cost = 0.0;
        for (albedo, gradients) in all {
            for (albedo, gradient) in albedo.into_iter().zip(gradients) {
                let excess = excess(albedo);
                if excess == 0.0 {
                    continue;
                }
                cost += IMPORTANCE * excess * excess;
                for (row, a) in free.iter().enumerate() {
                    let scaled = IMPORTANCE * total * gradient[*a];
                    normal.gradient[row] += scaled * excess;
                    for (column, b) in free.iter().enumerate() {
                        normal.matrix[row * free.len() + column] += scaled * gradient[*b];
                    }
                }
            }
        }
        cost
    }

    /// Albedos, [angle][channel].
    fn values(&self, lobes: &Lobes) -> Vec<[f64; 3]> {
        let parameters = Parameters::new(lobes);
        self.nodes.par_iter().map(|blocks| reflected(&parameters, blocks, None)).collect()
    }
}

fn excess(albedo: f64) -> f64 {
    (albedo - PENALTY_ALBEDO).max(0.0)
}

/// Albedo of each channel at the angle of these nodes. Adds its gradients by all parameters to
/// `gradients`, if present.
fn reflected(
    parameters: &Parameters,
    blocks: &[Block],
    mut gradients: Option<&mut [Vec<f64>; 3]>,
) -> [f64; 3] {
    let mut workspace = Workspace::new(&parameters.shape);
    let mut sums = [0.0; 3];
    for block in blocks {
        let sweep = Sweep { parameters, block, gain: 1.0, workspace: &mut workspace, sums: None };
        let reflected = Level::best().run(Flux { sweep, gradients: gradients.as_deref_mut() });
        sums = [0, 1, 2].map(|channel| sums[channel] + reflected[channel]);
    }
    sums
}

/// Nodes of the outgoing directions with their weights, for light from this angle in degrees. Half
/// the hemisphere suffices for a material that is its own mirror image.
#[expect(clippy::cast_possible_truncation, reason = "the fit is of f32, as the machine is")]
fn nodes(rule: &LobeRule, angle: f64, is_mirrored: bool, shape: &Shape) -> Vec<Block> {
    let (sin, cos) = libm::sincos(angle.to_radians());
    let wi = direction_at(sin, cos, 0.0);
    let nodes = rule.nodes(wi).into_iter();
    let half = nodes.filter(|(pair, _)| !is_mirrored || pair.wo().y > 0.0);
    let (pairs, weights): (Vec<_>, Vec<f64>) = half.unzip();
    let whole = if is_mirrored { 2.0 } else { 1.0 };
    let values = vec![[0.0; 3]; pairs.len()];
    let mut points = points(&Samples::new(pairs, values), shape);
    for (point, weight) in points.iter_mut().zip(weights) {
        point.importance = (whole * weight) as f32;
    }
    blocks(points.iter())
}

#[cfg(test)]
#[path = "albedo_tests.rs"]
mod tests;
