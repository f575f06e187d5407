//! Half and difference angles, the coordinates of isotropic tables.

use std::f64::consts::PI;

use glam::DVec3;

use crate::DirectionPair;

/// Angles of Rusinkiewicz 1998 of a pair above the surface, without the azimuth of the half vector.
///
/// # Units
/// Radians. `phi_d` is in [0, pi]: swapping the directions adds pi, which a reciprocal material
/// cannot distinguish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Angles {
    pub(super) theta_h: f64,
    pub(super) theta_d: f64,
    pub(super) phi_d: f64,
}

impl Angles {
    /// Returns `None` unless both directions are above the surface. The swapped pair gives the
    /// same bits.
    pub(super) fn of(pair: &DirectionPair) -> Option<Self> {
        let (wi, wo) = (pair.wi(), pair.wo());
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return None;
        }
        let (sum, apart) = (wi + wo, upwards(wi - wo));
        let across = libm::hypot(sum.x, sum.y);
        let theta_h = libm::atan2(across, sum.z);
        // |wi + wo| / 2 and |wi - wo| / 2 are the cosine and the sine of the angle between
        // wi and h.
        let theta_d = libm::atan2(apart.length(), sum.length());
        // Frame of h: along the meridian, and along the circle of latitude.
        let (cos, sin) = if across > 0.0 { (sum.x / across, sum.y / across) } else { (1.0, 0.0) };
        let length = sum.length();
        let along =
            (cos * apart.x + sin * apart.y) * (sum.z / length) - apart.z * (across / length);
        let beside = cos * apart.y - sin * apart.x;
        let phi = libm::atan2(beside, along);
        let phi_d = if phi < 0.0 { phi + PI } else { phi };
        Some(Self { theta_h, theta_d, phi_d: phi_d.clamp(0.0, PI) })
    }
}

/// Returns `w` or `-w`, such that the last component that is not 0 is positive.
fn upwards(w: DVec3) -> DVec3 {
    let last = [w.z, w.y, w.x].into_iter().find(|part| *part != 0.0).unwrap_or(0.0);
    if last < 0.0 { -w } else { w + DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn direction(theta: f64, phi: f64) -> DVec3 {
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    /// The pair with these angles, by the rotations of the definition.
    fn pair(theta_h: f64, theta_d: f64, phi_d: f64, phi_h: f64) -> DirectionPair {
        let turn = |w: DVec3| {
            let (sin, cos) = theta_h.sin_cos();
            let tilted = DVec3::new(cos * w.x + sin * w.z, w.y, cos * w.z - sin * w.x);
            let (sin, cos) = phi_h.sin_cos();
            DVec3::new(cos * tilted.x - sin * tilted.y, sin * tilted.x + cos * tilted.y, tilted.z)
        };
        let d = direction(theta_d, phi_d);
        DirectionPair::new(turn(d), turn(DVec3::new(-d.x, -d.y, d.z))).unwrap()
    }

    #[test]
    fn angles_round_trip_and_swapping_changes_no_bit() {
        let mut checked = 0;
        for theta_h in [1e-6, 0.2, 0.7, 1.2] {
            for theta_d in [1e-5, 0.3, 0.8, 1.3] {
                for phi_d in [0.1, 1.0, FRAC_PI_2, 2.5, 3.0] {
                    let pair = pair(theta_h, theta_d, phi_d, 0.7);
                    let Some(found) = Angles::of(&pair) else { continue };
                    assert_eq!(Angles::of(&pair.swapped()), Some(found));
                    let off = [found.theta_h - theta_h, found.theta_d - theta_d];
                    assert!(off.iter().all(|off| off.abs() < 1e-9), "{found:?}");
                    assert!((found.phi_d - phi_d).abs() < 1e-9, "{found:?} is not {phi_d}");
                    checked += 1;
                }
            }
        }
        assert!(checked > 40, "{checked}");
    }

    #[test]
    fn angles_exist_for_equal_directions_and_not_below_the_surface() {
        let z = DirectionPair::new(DVec3::Z, DVec3::Z).unwrap();
        assert_eq!(Angles::of(&z), Some(Angles { theta_h: 0.0, theta_d: 0.0, phi_d: 0.0 }));
        let below = DirectionPair::new(DVec3::Z, DVec3::NEG_Z).unwrap();
        assert_eq!(Angles::of(&below), None);
    }
}
