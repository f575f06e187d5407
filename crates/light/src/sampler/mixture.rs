//! Material lobes: a mixture of directions and its density, for importance sampling.
//!
//! A sample set serves any number of materials, so sampling cannot depend on one. Half of the
//! directions are cosine-distributed, the others are mirror directions of visible GGX normals at
//! three roughnesses. Independent of lights.

use std::f64::consts::PI;

use glam::DVec3;

/// GGX alpha of the lobes; each has a third of the samples that are not cosine-distributed.
const ALPHAS: [f64; 3] = [0.05, 0.15, 0.45];
/// Share of cosine-distributed directions: the least share of the samples useful to diffuse
/// materials.
const BY_COSINE: f64 = 0.5;

/// Mixture of directions for one direction to the eye, in the local frame (z is the normal).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mixture {
    wo: DVec3,
}

impl Mixture {
    /// Makes the mixture for the direction to the eye.
    ///
    /// # Domain
    /// A unit vector above the horizon.
    pub fn new(wo: DVec3) -> Self {
        Self { wo }
    }

    /// Maps a point of the unit square to a direction, which may be below the horizon.
    ///
    /// # Domain
    /// Both coordinates within (0, 1). Continuous except at three lines between the lobes.
    pub fn draw(&self, [across, around]: [f64; 2]) -> DVec3 {
        if across < BY_COSINE {
            return by_cosine([across / BY_COSINE, around]);
        }
        let lobes = (across - BY_COSINE) / (1.0 - BY_COSINE) * ALPHAS.len() as f64;
        let lobe = (lobes as usize).min(ALPHAS.len() - 1);
        visible_normal_mirror(self.wo, ALPHAS[lobe], [lobes - lobe as f64, around])
    }

    /// Returns the density of the mixture in a direction.
    ///
    /// # Units
    /// 1/sr; at least half of cos / pi.
    pub fn density(&self, wi: DVec3) -> f64 {
        let by_cosine = wi.z.max(0.0) / PI;
        let half = wi + self.wo;
        let mirrors: f64 = ALPHAS.iter().map(|alpha| mirror_density(self.wo, half, *alpha)).sum();
        BY_COSINE * by_cosine + (1.0 - BY_COSINE) / ALPHAS.len() as f64 * mirrors
    }
}

/// Returns the point of the unit circle spanned by `x` and `y` at a fraction of a turn.
pub(crate) fn on_unit_circle(x: DVec3, y: DVec3, turn: f64) -> DVec3 {
    let angle = 2.0 * PI * turn;
    x * libm::cos(angle) + y * libm::sin(angle)
}

/// Maps a point of the unit square to a cosine-distributed direction, never below the horizon.
pub(crate) fn by_cosine([across, around]: [f64; 2]) -> DVec3 {
    on_unit_circle(DVec3::X, DVec3::Y, around) * across.sqrt() + DVec3::Z * (1.0 - across).sqrt()
}

/// Maps a point of the unit square to the mirror direction about a visible GGX normal.
///
/// # Source
/// Dupuy and Benyoub 2023, *Sampling Visible GGX Normals with Spherical Caps*.
fn visible_normal_mirror(wo: DVec3, alpha: f64, [across, around]: [f64; 2]) -> DVec3 {
    let stretch = DVec3::new(alpha, alpha, 1.0);
    let stretched = (wo * stretch).normalize();
    let z = (1.0 - across) * (1.0 + stretched.z) - stretched.z;
    let cap =
        on_unit_circle(DVec3::X, DVec3::Y, around) * (1.0 - z * z).max(0.0).sqrt() + DVec3::Z * z;
    let h = ((cap + stretched) * stretch).normalize();
    (h * (2.0 * wo.dot(h)) - wo).normalize()
}

/// Returns the density of these mirror directions per solid angle, D G1 / (4 cos_o). G1 / cos_o is
/// in a form without division by cos_o. `half` is the sum of the two directions, not normalised.
fn mirror_density(wo: DVec3, half: DVec3, alpha: f64) -> f64 {
    let square = half.length_squared();
    if square <= 0.0 {
        return 0.0;
    }
    let across = (half.x * half.x + half.y * half.y) / square;
    let along = half.z * half.z / square;
    let a2 = alpha * alpha;
    let root = across + a2 * along;
    let d = a2 / (PI * root * root);
    let level = wo.x * wo.x + wo.y * wo.y;
    let g1_over_cos = 2.0 / (wo.z + (wo.z * wo.z + a2 * level).sqrt());
    d * g1_over_cos / 4.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::SamplePoints;

    fn eye(cos: f64) -> DVec3 {
        DVec3::new((1.0 - cos * cos).sqrt() * 0.6, (1.0 - cos * cos).sqrt() * 0.8, cos)
    }

    /// The mean of g / density over drawn directions is the integral of g.
    #[test]
    fn mean_of_quotient_by_density_is_the_integral() {
        let count = 1 << 16;
        for cos in [1.0, 0.7, 0.2, 0.01] {
            let mixture = Mixture::new(eye(cos));
            let points = SamplePoints::new(3, 0);
            let (mut solid_angle, mut by_cosine, mut drawn) = (0.0, 0.0, 0.0);
            for sample in 0..count {
                let wi = mixture.draw(points.at(sample));
                assert!((wi.length() - 1.0).abs() < 1e-12);
                let density = mixture.density(wi);
                assert!(density > 0.0 && density.is_finite(), "{cos} {wi}");
                if wi.z > 0.0 {
                    solid_angle += wi.z.sqrt() / density;
                    by_cosine += wi.z / density;
                }
                drawn += f64::from(u8::from(wi.z > 0.0));
            }
            let mean = |sum: f64| sum / f64::from(count);
            // The integrals of cos^(1/2) and of cos over the hemisphere.
            assert!((mean(solid_angle) / (2.0 * PI / 1.5) - 1.0).abs() < 2e-3, "{cos}");
            assert!((mean(by_cosine) / PI - 1.0).abs() < 2e-3, "{cos}");
            assert!(mean(drawn) > 0.7, "{cos} {}", mean(drawn));
        }
    }

    #[test]
    fn density_is_high_in_mirror_direction() {
        let wo = eye(0.6);
        let mirror = DVec3::new(-wo.x, -wo.y, wo.z);
        let mixture = Mixture::new(wo);
        assert!(mixture.density(mirror) > 10.0 * mixture.density(DVec3::Z));
        // The mean of directions of a smooth lobe is close to the mirror direction.
        let points = SamplePoints::new(5, 0);
        let mean: DVec3 =
            (0..4096).map(|sample| visible_normal_mirror(wo, 0.05, points.at(sample))).sum();
        assert!(mean.normalize().dot(mirror) > 0.999, "{mean}");
    }
}
