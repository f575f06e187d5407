//! Directions that a material may reflect from: what a scene knows before it knows the material.
//!
//! Samples are drawn once and shaded with any number of materials, so they are spread over what materials do: half by the
//! cosine, the others as mirrors of three roughnesses do. Owns the drawing and its density; knows no light.

use std::f64::consts::PI;

use glam::DVec3;

use super::area::aside;

/// GGX alpha of the mirrors: a third of the half each.
const ALPHAS: [f64; 3] = [0.05, 0.15, 0.45];
/// Share of the directions that are drawn by the cosine: a matt material has at most this much less of the samples.
const BY_COSINE: f64 = 0.5;

/// The directions for one direction to the eye, both in the local frame (z is the normal).
#[derive(Debug, Clone, Copy)]
pub(super) struct Mixture {
    wo: DVec3,
}

impl Mixture {
    /// # Domain
    /// A unit vector above the horizon.
    pub fn new(wo: DVec3) -> Self {
        Self { wo }
    }

    /// The direction of a place in the unit square. It may be below the horizon, as those of mirrors may.
    ///
    /// # Domain
    /// Both coordinates within (0, 1). Places next to each other make directions next to each other but for three edges.
    pub fn draw(&self, [across, around]: [f64; 2]) -> DVec3 {
        if across < BY_COSINE {
            return by_cosine([across / BY_COSINE, around]);
        }
        let lobes = (across - BY_COSINE) / (1.0 - BY_COSINE) * ALPHAS.len() as f64;
        let lobe = (lobes as usize).min(ALPHAS.len() - 1);
        visible_normal_mirror(self.wo, ALPHAS[lobe], [lobes - lobe as f64, around])
    }

    /// Density of the directions that are drawn.
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

/// The direction of a place in the unit square, drawn by the cosine: never below the horizon.
pub(super) fn by_cosine([across, around]: [f64; 2]) -> DVec3 {
    aside(DVec3::X, DVec3::Y, around) * across.sqrt() + DVec3::Z * (1.0 - across).sqrt()
}

/// The mirror direction about a normal that the eye sees, drawn as a GGX surface has them.
///
/// # Source
/// Dupuy and Benyoub 2023, *Sampling Visible GGX Normals with Spherical Caps*.
fn visible_normal_mirror(wo: DVec3, alpha: f64, [across, around]: [f64; 2]) -> DVec3 {
    let stretch = DVec3::new(alpha, alpha, 1.0);
    let stretched = (wo * stretch).normalize();
    let z = (1.0 - across) * (1.0 + stretched.z) - stretched.z;
    let cap = aside(DVec3::X, DVec3::Y, around) * (1.0 - z * z).max(0.0).sqrt() + DVec3::Z * z;
    let h = ((cap + stretched) * stretch).normalize();
    (h * (2.0 * wo.dot(h)) - wo).normalize()
}

/// Density of those mirror directions by solid angle, D G1 / (4 cos_o): G1 / cos_o is written without a quotient that
/// vanishes. `half` is the sum of the two directions.
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
    use crate::sample_set::sequence::Places;

    fn eye(cos: f64) -> DVec3 {
        DVec3::new((1.0 - cos * cos).sqrt() * 0.6, (1.0 - cos * cos).sqrt() * 0.8, cos)
    }

    /// The mean of g / density over what is drawn is the integral of g, whatever is drawn by.
    #[test]
    fn drawn_directions_integrate_what_is_above_the_horizon() {
        let count = 1 << 16;
        for cos in [1.0, 0.7, 0.2, 0.01] {
            let mixture = Mixture::new(eye(cos));
            let places = Places::new(3, 0);
            let (mut solid_angle, mut by_cosine, mut drawn) = (0.0, 0.0, 0.0);
            for sample in 0..count {
                let wi = mixture.draw(places.at(sample));
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
    fn mirrors_draw_their_own_direction_densest() {
        let wo = eye(0.6);
        let mirror = DVec3::new(-wo.x, -wo.y, wo.z);
        let mixture = Mixture::new(wo);
        assert!(mixture.density(mirror) > 10.0 * mixture.density(DVec3::Z));
        // A mean of what a middling mirror draws is about its direction.
        let places = Places::new(5, 0);
        let mean: DVec3 =
            (0..4096).map(|sample| visible_normal_mirror(wo, 0.05, places.at(sample))).sum();
        assert!(mean.normalize().dot(mirror) > 0.999, "{mean}");
    }
}
