//! Where a pair of directions lies among samples: three coordinates in which near means alike.
//!
//! They are the same for pairs that are turned about the normal and for mirror images; the swapped pair has the last one with the other
//! sign. Where an azimuth loses its meaning, it changes nothing.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::DirectionPair;

/// How much less a step of the difference angle changes than one of the half angle, and of its azimuth. Found on models and
/// measurements of which a part was held out.
const ALONG: f64 = 0.6;
const AROUND: f64 = 0.6;

/// None where a direction is not above the surface. Along the half angle it goes by the square root, since highlights are narrow.
pub(super) fn place(pair: &DirectionPair) -> Option<DVec3> {
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
    // To the power of 3/4; 0 where either is.
    let root = (half * difference).sqrt();
    let sway = root * root.sqrt();
    Some(DVec3::new(half.sqrt(), ALONG * difference, AROUND * sway * cosine))
}

/// That of the swapped pair.
pub(super) fn swapped(place: DVec3) -> DVec3 {
    DVec3::new(place.x, place.y, -place.z)
}

#[cfg(test)]
mod tests {
    use super::super::super::angle::Angles;
    use super::*;

    #[test]
    fn places_are_of_the_angles_and_swapping_changes_a_sign() {
        let direction = |theta: f64, phi: f64| {
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        for (theta_i, theta_o, phi) in [(0.2, 1.1, 2.0), (1.4, 0.3, 0.1), (0.7, 0.7, 3.0)] {
            let pair = DirectionPair::new(direction(theta_i, 0.4), direction(theta_o, 0.4 + phi));
            let pair = pair.unwrap();
            let (found, angles) = (place(&pair).unwrap(), Angles::of(&pair).unwrap());
            let (h, d) = (angles.theta_h / FRAC_PI_2, angles.theta_d / FRAC_PI_2);
            let cosine = found.z / (AROUND * (h * d).powf(0.75));
            assert!((found.x - h.sqrt()).abs() < 1e-12 && (found.y - ALONG * d).abs() < 1e-12);
            assert!((cosine.abs() - angles.phi_d.cos().abs()).abs() < 1e-9, "{cosine}");
            assert_eq!(place(&pair.swapped()), Some(swapped(found)));
            let mirrored =
                DirectionPair::new(direction(theta_i, -0.4), direction(theta_o, -0.4 - phi));
            let mirrored = place(&mirrored.unwrap()).unwrap();
            assert!((mirrored - found).length() < 1e-12);
        }
        let normal = DirectionPair::new(DVec3::Z, DVec3::Z).unwrap();
        assert_eq!(place(&normal), Some(DVec3::ZERO));
        let below = DirectionPair::new(DVec3::Z, DVec3::NEG_Z).unwrap();
        assert_eq!(place(&below), None);
    }
}
