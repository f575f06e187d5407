//! Coordinates of direction pairs in which near pairs reflect alike.
//!
//! Invariant under turns about the normal and mirroring; swapping the directions negates the last
//! coordinate. Continuous where an azimuth is undefined.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::DirectionPair;

/// Scale of the difference angle and of its azimuth relative to the half angle, chosen by the error
/// on held-out samples of models and measurements.
const DIFFERENCE_SCALE: f64 = 0.6;
const AZIMUTH_SCALE: f64 = 0.6;

/// Returns `None` unless both directions are above the surface. The first coordinate is the square
/// root of the half angle, because highlights are narrow.
pub(super) fn coordinates(pair: &DirectionPair) -> Option<DVec3> {
    let (wi, wo) = (pair.wi(), pair.wo());
    if !(wi.z > 0.0 && wo.z > 0.0) {
        return None;
    }
    let sum = wi + wo;
    let (across, length, apart) = (libm::hypot(sum.x, sum.y), sum.length(), (wi - wo).length());
    let half = libm::atan2(across, sum.z) / FRAC_PI_2;
    let difference = libm::atan2(apart, length) / FRAC_PI_2;
    // cos_o - cos_i = 2 sin theta_h sin theta_d cos phi_d.
    let sines = across * apart;
    let cosine = if sines > 0.0 { ((wo.z - wi.z) * length / sines).clamp(-1.0, 1.0) } else { 0.0 };
    // (half * difference)^(3/4)
    let root = (half * difference).sqrt();
    let envelope = root * root.sqrt();
    Some(DVec3::new(half.sqrt(), DIFFERENCE_SCALE * difference, AZIMUTH_SCALE * envelope * cosine))
}

/// Coordinates of the swapped pair.
pub(super) fn swapped(at: DVec3) -> DVec3 {
    DVec3::new(at.x, at.y, -at.z)
}

#[cfg(test)]
mod tests {
    use super::super::super::angle::Angles;
    use super::*;

    #[test]
    fn coordinates_follow_the_angles_and_swapping_negates_one() {
        let direction = |theta: f64, phi: f64| {
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        for (theta_i, theta_o, phi) in [(0.2, 1.1, 2.0), (1.4, 0.3, 0.1), (0.7, 0.7, 3.0)] {
            let pair = DirectionPair::new(direction(theta_i, 0.4), direction(theta_o, 0.4 + phi));
            let pair = pair.unwrap();
            let (found, angles) = (coordinates(&pair).unwrap(), Angles::of(&pair).unwrap());
            let (h, d) = (angles.theta_h / FRAC_PI_2, angles.theta_d / FRAC_PI_2);
            let cosine = found.z / (AZIMUTH_SCALE * (h * d).powf(0.75));
            assert!(
                (found.x - h.sqrt()).abs() < 1e-12
                    && (found.y - DIFFERENCE_SCALE * d).abs() < 1e-12
            );
            assert!((cosine.abs() - angles.phi_d.cos().abs()).abs() < 1e-9, "{cosine}");
            assert_eq!(coordinates(&pair.swapped()), Some(swapped(found)));
            let mirrored =
                DirectionPair::new(direction(theta_i, -0.4), direction(theta_o, -0.4 - phi));
            let mirrored = coordinates(&mirrored.unwrap()).unwrap();
            assert!((mirrored - found).length() < 1e-12);
        }
        let normal = DirectionPair::new(DVec3::Z, DVec3::Z).unwrap();
        assert_eq!(coordinates(&normal), Some(DVec3::ZERO));
        let below = DirectionPair::new(DVec3::Z, DVec3::NEG_Z).unwrap();
        assert_eq!(coordinates(&below), None);
    }
}
