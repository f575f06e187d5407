//! Pairs of directions of one inclination of the eye, at which a fit is made, with f cos_i.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use brood_brdf::DirectionPair;
use glam::DVec3;

use crate::reflectance::{direction, spread};
use crate::table::Source;

/// Directions to the light that are even over the hemisphere, and even over half vectors, denser
/// near the normal.
const EVEN: usize = 384;
const BY_HALF: usize = 640;
/// Angle from the mirror direction of what counts as near it in errors, in radians.
const NEAR: f64 = 0.15;
/// Step of the azimuth of the eye from pair to pair, of anisotropic materials: the golden ratio.
const TURN: f64 = 0.618_033_988_749_894_9;

/// Pairs of one inclination of the eye.
pub(super) struct View {
    pub(super) pairs: Vec<DirectionPair>,
    /// f cos_i.
    pub(super) values: Vec<DVec3>,
    /// Weight of each pair in the error: half of it is even over the hemisphere, half near the
    /// mirror direction.
    pub(super) error_weights: Vec<f64>,
    /// Weight of each pair in the integral over the hemisphere.
    pub(super) solid_angles: Vec<f64>,
}

impl View {
    /// Evaluates at an inclination of the eye, in radians. The azimuth is 0, or all of them.
    pub(super) fn of(source: &Source<'_>, inclination: f64, is_anisotropic: bool) -> Self {
        let eye = direction(inclination, 0.0);
        let mut view = Self {
            pairs: Vec::new(),
            values: Vec::new(),
            error_weights: Vec::new(),
            solid_angles: Vec::new(),
        };
        let mirror = DVec3::new(-eye.x, -eye.y, eye.z);
        for k in 0..EVEN + BY_HALF {
            let place = spread(k);
            let light = match k < EVEN {
                true => direction(libm::acos(1.0 - place.x), TAU * place.y),
                false => {
                    let half = direction(FRAC_PI_2 * place.x * place.x, TAU * place.y);
                    2.0 * half.dot(eye) * half - eye
                }
            };
            if light.z <= 0.0 {
                continue;
            }
            let density = density(light, eye);
            let cap = if light.dot(mirror) > libm::cos(NEAR) { 1.0 } else { 0.0 };
            let near = cap / (TAU * (1.0 - libm::cos(NEAR)));
            let azimuth = if is_anisotropic { TAU * (TURN * k as f64).fract() } else { 0.0 };
            let turned = |w: DVec3| {
                let (sin, cos) = (libm::sin(azimuth), libm::cos(azimuth));
                DVec3::new(cos * w.x - sin * w.y, sin * w.x + cos * w.y, w.z).normalize()
            };
            let pair = DirectionPair::new(turned(light), turned(eye));
            view.pairs.push(pair.expect("the directions have length 1"));
            view.error_weights.push((0.5 / TAU + 0.5 * near) / density);
            view.solid_angles.push(1.0 / density);
        }
        let f = source.f(&view.pairs);
        view.values = f.into_iter().zip(&view.pairs).map(|(f, pair)| f * pair.cos_i()).collect();
        view
    }

    /// Integral over the directions to the light of f cos_i given by pair.
    pub(super) fn albedo(&self, values: impl Iterator<Item = DVec3>) -> DVec3 {
        values.zip(&self.solid_angles).map(|(value, weight)| value * *weight).sum()
    }
}

/// Number of directions to the light per solid angle.
fn density(light: DVec3, eye: DVec3) -> f64 {
    let half = (light + eye).normalize();
    let inclination = libm::atan2(half.truncate().length(), half.z).max(1e-6);
    let x = libm::sqrt(inclination / FRAC_PI_2);
    let by_half = 1.0 / (TAU * PI * x * libm::sin(inclination) * 4.0 * half.dot(eye).abs());
    EVEN as f64 / TAU + BY_HALF as f64 * by_half
}
