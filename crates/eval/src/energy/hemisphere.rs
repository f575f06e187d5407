//! Quadrature over the hemisphere, and construction of directions and direction pairs.

use std::f64::consts::TAU;

use brood_brdf::{DirectionPair, gauss_legendre};
use glam::DVec3;

/// A product rule for integrals of f cos_o over the hemisphere: Gauss-Legendre in cos_o, equal
/// steps in azimuth.
///
/// Exact if f cos_o is a polynomial of wo of a degree below twice the number of rings; converges
/// faster than any power if f is analytic. Clamps cause kinks, which reduce the order of
/// convergence as for any other rule.
///
/// # Source
/// Atkinson and Han, *Spherical Harmonics and Approximations on the Unit Sphere* (2012), section
/// 5.1.
#[derive(Debug, Clone)]
pub struct Quadrature {
    /// Directions ring by ring from grazing to the normal, each ring by azimuth.
    directions: Vec<DVec3>,
    /// Weight of one direction of each ring.
    weights: Vec<f64>,
}

impl Quadrature {
    /// Creates a rule of `order` rings with `2 * order` azimuths each.
    ///
    /// # Panics
    /// If the order is 0.
    #[must_use]
    pub fn new(order: usize) -> Self {
        let azimuths = 2 * order;
        let rings = gauss_legendre(order);
        let mut directions = Vec::with_capacity(order * azimuths);
        for (cos_theta, _) in &rings {
            let sin_theta = ((1.0 - cos_theta) * (1.0 + cos_theta)).sqrt();
            for step in 0..azimuths {
                let turn = (step as f64 + 0.5) / azimuths as f64;
                directions.push(direction_at(sin_theta, *cos_theta, turn));
            }
        }
        let step = TAU / azimuths as f64;
        let weights = rings.iter().map(|(cos_theta, weight)| weight * cos_theta * step).collect();
        Self { directions, weights }
    }

    /// Returns the directions, in the order in which [`Quadrature::integrate`] takes values.
    #[must_use]
    pub fn directions(&self) -> &[DVec3] {
        &self.directions
    }

    /// Returns the directions with their weights of f.
    pub(super) fn weighted(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let azimuths = self.directions.len() / self.weights.len();
        let weights =
            self.weights.iter().flat_map(move |weight| std::iter::repeat_n(*weight, azimuths));
        self.directions.iter().copied().zip(weights)
    }

    /// Returns the integral of f cos_o, given f at the directions. Sums are f64 in a fixed order.
    ///
    /// # Panics
    /// If the number of values is not that of directions.
    pub fn integrate(&self, f: impl ExactSizeIterator<Item = f64>) -> f64 {
        assert_eq!(f.len(), self.directions.len(), "there is a value for each direction");
        let azimuths = self.directions.len() / self.weights.len();
        let mut values = f;
        let ring = |weight: &f64| weight * values.by_ref().take(azimuths).sum::<f64>();
        self.weights.iter().map(ring).sum()
    }
}

/// Returns the direction with that sine and cosine of the angle from the normal, turned from x by
/// `turn` of a full turn.
#[must_use]
pub fn direction_at(sin_theta: f64, cos_theta: f64, turn: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(turn * TAU);
    DVec3::new(sin_theta * cos, sin_theta * sin, cos_theta)
}

/// Returns a pair of directions built from sines and cosines.
///
/// # Panics
/// If a direction is not of length 1.
#[must_use]
pub fn direction_pair(wi: DVec3, wo: DVec3) -> DirectionPair {
    DirectionPair::new(wi, wo).expect("directions from sines and cosines have length 1")
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn integral(order: usize, f: impl Fn(&DVec3) -> f64) -> f64 {
        let rule = Quadrature::new(order);
        rule.integrate(rule.directions().iter().map(f).collect::<Vec<_>>().into_iter())
    }

    #[test]
    fn polynomials_are_integrated_exactly() {
        for order in [1, 2, 7, 64, 256] {
            assert!((integral(order, |_| 1.0) - PI).abs() < 1e-12, "{order}");
        }
        // x^2 cos over the hemisphere: pi / 4.
        assert!((integral(3, |w| w.x * w.x) - PI / 4.0).abs() < 1e-14);
        assert!((integral(8, |w| w.z.powi(6)) - TAU / 8.0).abs() < 1e-14);
        assert!(integral(4, |w| w.x * w.y).abs() < 1e-14);
    }
}
