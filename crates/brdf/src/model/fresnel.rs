//! Fresnel reflectance of unpolarised light at a smooth boundary, branch-free.

use glam::DVec3;

use super::constants::MetalConstants;
use crate::block::{larger, unit};

/// (1 - c)^5 for the cosine c of the angle to the boundary's normal.
#[inline(always)]
pub(super) fn schlick_weight(c: f64) -> f64 {
    let m = unit(1.0 - c);
    let m2 = m * m;
    m2 * m2 * m
}

/// Schlick's approximation, given the reflectance at normal incidence.
///
/// # Domain
/// `f0` in [0, 1]; c is clamped to [0, 1].
///
/// # Source
/// Schlick 1994, equation 15.
#[inline(always)]
pub(super) fn schlick(f0: DVec3, c: f64) -> DVec3 {
    f0 + (DVec3::ONE - f0) * schlick_weight(c)
}

/// Reflectance of a smooth boundary to a medium of relative refractive index `eta` > 0; 1 at total
/// reflection.
///
/// # Source
/// Fresnel's equations, as in Born and Wolf, section 1.5.2.
#[inline(always)]
pub(super) fn dielectric(eta: f64, c: f64) -> f64 {
    let c = unit(c);
    let sin2_t = (1.0 - c * c) * (1.0 / (eta * eta));
    // If sin2_t >= 1, cos_t is 0 and both quotients are 1.
    let cos_t = larger(1.0 - sin2_t, 0.0).sqrt();
    let perpendicular = (c - eta * cos_t) / (c + eta * cos_t);
    let parallel = (eta * c - cos_t) / (eta * c + cos_t);
    let partly = 0.5 * (perpendicular * perpendicular + parallel * parallel);
    if sin2_t >= 1.0 { 1.0 } else { partly }
}

/// Reflectance of [`dielectric`] as a fraction, for formulas that divide by another term anyway.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReflectanceFraction {
    /// Cosine of the refracted direction; 0 at total reflection.
    pub(super) cos_t: f64,
    /// Reflectance is `numerator / denominator`, unless `is_total`.
    pub(super) numerator: f64,
    pub(super) denominator: f64,
    pub(super) is_total: bool,
}

impl ReflectanceFraction {
    /// # Domain
    /// `eta` > 0, c in [0, 1].
    #[inline(always)]
    pub(super) fn of(eta: f64, c: f64) -> Self {
        let sin2_t = (1.0 - c * c) * (1.0 / (eta * eta));
        let cos_t = larger(1.0 - sin2_t, 0.0).sqrt();
        let (minus, plus) = (c - eta * cos_t, c + eta * cos_t);
        let (parallel_minus, parallel_plus) = (eta * c - cos_t, eta * c + cos_t);
        let (a, b) = (minus * parallel_plus, parallel_minus * plus);
        let all = plus * parallel_plus;
        Self {
            cos_t,
            numerator: 0.5 * (a * a + b * b),
            denominator: all * all,
            is_total: sin2_t >= 1.0,
        }
    }
}

/// Smooth boundary to a metal of complex index eta + i k, relative to the outside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Conductor {
    /// eta^2 - k^2
    difference: f64,
    /// 4 eta^2 k^2
    product: f64,
}

impl Conductor {
    pub(super) fn new(eta: f64, k: f64) -> Self {
        let (eta2, k2) = (eta * eta, k * k);
        Self { difference: eta2 - k2, product: 4.0 * eta2 * k2 }
    }

    pub(super) fn constants(&self) -> MetalConstants {
        MetalConstants { difference: self.difference, product: self.product }
    }

    /// # Source
    /// Born and Wolf, section 14.2; in the form of Lagarde 2013, "Memo on Fresnel equations".
    #[inline(always)]
    pub(super) fn reflectance(&self, c: f64) -> f64 {
        let c = unit(c);
        let (cos2, sin2) = (c * c, 1.0 - c * c);
        let t0 = self.difference - sin2;
        let a2_plus_b2 = (t0 * t0 + self.product).sqrt();
        let a = larger(0.5 * (a2_plus_b2 + t0), 0.0).sqrt();
        let (t1, t2) = (a2_plus_b2 + cos2, 2.0 * c * a);
        let perpendicular = (t1 - t2) / (t1 + t2);
        let (t3, t4) = (cos2 * a2_plus_b2 + sin2 * sin2, t2 * sin2);
        0.5 * perpendicular * (1.0 + (t3 - t4) / (t3 + t4))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, wanted: f64) {
        assert!((found - wanted).abs() < 1e-12, "{found} is not {wanted}");
    }

    #[test]
    fn fresnel_has_its_known_values() {
        close(dielectric(1.5, 1.0), 0.04);
        close(dielectric(1.5, 0.0), 1.0);
        // At Brewster's angle only the perpendicular part is left.
        let c = 1.0 / (1.0_f64 + 1.5 * 1.5).sqrt();
        close(dielectric(1.5, c), 0.5 * ((1.0 - 2.25_f64) / (1.0 + 2.25)).powi(2));
        // From the dense side, beyond the critical angle.
        close(dielectric(1.0 / 1.5, 0.5), 1.0);
        // Without absorption a metal is a dielectric.
        for c in [0.0, 0.1, 0.5, 0.9, 1.0] {
            close(Conductor::new(1.5, 0.0).reflectance(c), dielectric(1.5, c));
        }
        close(Conductor::new(0.2, 3.0).reflectance(1.0), (0.8 * 0.8 + 9.0) / (1.2 * 1.2 + 9.0));
        close(schlick(DVec3::splat(0.04), 1.0).x, 0.04);
        close(schlick(DVec3::splat(0.04), 0.0).x, 1.0);
    }
}
