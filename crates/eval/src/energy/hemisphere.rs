//! Directions of the hemisphere: quadrature of integrals over it, and the incident directions that are looked at.

use std::f64::consts::{PI, TAU};

use brood_brdf::DirectionPair;
use glam::DVec3;

/// A product rule for integrals of f cos_o over the hemisphere: Gauss-Legendre in cos_o, equal steps in azimuth.
///
/// Exact where f is a polynomial of the directions of a degree below twice the number of rings, and converging faster than
/// any power where it is analytic; clamps make kinks, which it meets as any other rule does.
///
/// # Source
/// Atkinson and Han, *Spherical Harmonics and Approximations on the Unit Sphere* (2012), section 5.1.
#[derive(Debug, Clone)]
pub struct Quadrature {
    /// Ring by ring from grazing to the normal, in each the azimuths.
    directions: Vec<DVec3>,
    /// Of one direction of each ring.
    weights: Vec<f64>,
}

impl Quadrature {
    /// `order` rings of twice as many azimuths.
    ///
    /// # Panics
    /// Where the order is 0.
    #[must_use]
    pub fn new(order: usize) -> Self {
        let azimuths = 2 * order;
        let rings = gauss_legendre(order);
        let mut directions = Vec::with_capacity(order * azimuths);
        for (cos_theta, _) in &rings {
            let sin_theta = ((1.0 - cos_theta) * (1.0 + cos_theta)).sqrt();
            for step in 0..azimuths {
                let turn = (step as f64 + 0.5) / azimuths as f64;
                directions.push(around(sin_theta, *cos_theta, turn));
            }
        }
        let step = TAU / azimuths as f64;
        let weights = rings.iter().map(|(cos_theta, weight)| weight * cos_theta * step).collect();
        Self { directions, weights }
    }

    /// The directions, in the order of the values that are integrated.
    #[must_use]
    pub fn directions(&self) -> &[DVec3] {
        &self.directions
    }

    /// Its number of rings.
    pub(super) fn order(&self) -> usize {
        self.weights.len()
    }

    /// The directions, and what f counts in each.
    pub(super) fn weighted(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let azimuths = self.directions.len() / self.weights.len();
        let weights =
            self.weights.iter().flat_map(move |weight| std::iter::repeat_n(*weight, azimuths));
        self.directions.iter().copied().zip(weights)
    }

    /// The integral of f cos_o from f at the directions. Sums are f64 in one order.
    ///
    /// # Panics
    /// Where there are not as many values as directions.
    pub fn integrate(&self, f: impl ExactSizeIterator<Item = f64>) -> f64 {
        assert_eq!(f.len(), self.directions.len(), "there is a value for each direction");
        let azimuths = self.directions.len() / self.weights.len();
        let mut values = f;
        let ring = |weight: &f64| weight * values.by_ref().take(azimuths).sum::<f64>();
        self.weights.iter().map(ring).sum()
    }
}

/// Nodes and weights of the rule of that order on [0, 1], nodes ascending.
///
/// # Error
/// Below 1e-14 for orders up to 1024: Newton's method on the recurrence of the Legendre polynomials.
pub(super) fn gauss_legendre(order: usize) -> Vec<(f64, f64)> {
    assert!(order > 0, "a rule has a node");
    let n = order as f64;
    let node = |index: usize| {
        let mut x = -libm::cos(PI * (index as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        for _ in 0..6 {
            let (mut last, mut value) = (1.0, x);
            for k in 2..=order {
                let k = k as f64;
                (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
            }
            slope = n * (x * value - last) / (x * x - 1.0);
            x -= value / slope;
        }
        // The weight on [-1, 1] is twice that on [0, 1].
        (0.5 * (x + 1.0), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..order).map(node).collect()
}

/// The direction with that sine and cosine from the normal, at that share of a turn from x.
#[must_use]
pub fn around(sin_theta: f64, cos_theta: f64, turn: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(turn * TAU);
    DVec3::new(sin_theta * cos, sin_theta * sin, cos_theta)
}

/// A pair of directions built from sines and cosines.
///
/// # Panics
/// Where one is not of length 1.
#[must_use]
pub fn pair(wi: DVec3, wo: DVec3) -> DirectionPair {
    DirectionPair::new(wi, wo).expect("built from sines and cosines")
}

#[cfg(test)]
mod tests {
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
