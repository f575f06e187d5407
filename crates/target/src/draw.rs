//! Random pairs of directions at which materials are sampled, half of them concentrated on
//! highlights.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use brood_brdf::DirectionPair;
use brood_genome::{BirthKey, Operator, Stream};
use glam::DVec3;

/// Least cosine of a pair; pairs below are drawn again.
const LEAST_COSINE: f64 = 0.01;
const LEAST_NARROW_COSINE: f64 = 1e-4;
/// ln of the smallest theta_h, relative to 90 degrees.
const NARROWEST: f64 = -9.0;
/// ln of the smallest deviation of the azimuths of grazing pairs from opposite, relative to 180
/// degrees.
const CLOSEST: f64 = -11.0;
/// Least theta_d of every second narrow pair, relative to 90 degrees.
const GRAZING: f64 = 0.75;

/// Draws pairs of directions above the surface; deterministic in the seed.
///
/// Every first of two is uniform over both hemispheres; every second is uniform in (theta_h,
/// theta_d, phi_d, phi_h), which is dense where half vectors are close to the normal.
///
/// # Source
/// Rusinkiewicz, *A New Change of Variables for Efficient BRDF Representation* (1998), for the
/// angles.
#[must_use]
pub fn draw_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut stream = Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::Directions);
    let mut pairs = Vec::with_capacity(count);
    while pairs.len() < count {
        let halves = pairs.len() % 2 == 1;
        let (wi, wo) = if halves { by_half(&mut stream) } else { by_hemisphere(&mut stream) };
        if wi.z.min(wo.z) < LEAST_COSINE {
            continue;
        }
        pairs.push(DirectionPair::new(wi, wo).expect("both directions are unit vectors"));
    }
    pairs
}

/// Draws pairs of directions in highlights, where samples are few. theta_h is log-uniform: as often
/// between 0.01 and 0.1 degrees as between 1 and 10. Every second pair has theta_d above 67
/// degrees.
#[must_use]
pub fn narrow_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut stream = Stream::new(BirthKey { seed, slot: 1, attempt: 0 }, Operator::Directions);
    let mut pairs = Vec::with_capacity(count);
    while pairs.len() < count {
        let theta_h = FRAC_PI_2 * libm::exp(NARROWEST * unit(&mut stream));
        let least = if pairs.len() % 2 == 0 { GRAZING } else { 0.0 };
        let theta_d = FRAC_PI_2 * (least + (1.0 - least) * unit(&mut stream));
        let [phi_d, phi_h] = [(); 2].map(|()| TAU * unit(&mut stream));
        let (wi, wo) = from_half([theta_h, theta_d, phi_d, phi_h]);
        if wi.z.min(wo.z) >= LEAST_NARROW_COSINE {
            pairs.push(DirectionPair::new(wi, wo).expect("both directions are unit vectors"));
        }
    }
    pairs
}

/// Draws pairs of directions towards the horizon. Both cosines are log-uniform from 1e-4 to 1. In
/// every second pair the deviation of the azimuths from opposite is log-uniform as well: as often
/// between 0.01 and 0.1 degrees as between 1 and 10.
#[must_use]
pub fn grazing_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut stream = Stream::new(BirthKey { seed, slot: 2, attempt: 0 }, Operator::Directions);
    let mut drawn = || unit(&mut stream);
    let mut pair = |index: usize| {
        let [cos_i, cos_o] = [(); 2].map(|()| libm::pow(LEAST_NARROW_COSINE, drawn()));
        let (phi, aside) = (TAU * drawn(), drawn());
        let aside = if index.is_multiple_of(2) { libm::exp(CLOSEST * aside) } else { aside };
        let (wi, wo) = (at(cos_i, phi), at(cos_o, phi + PI * (1.0 + aside)));
        DirectionPair::new(wi, wo).expect("both directions are unit vectors")
    };
    (0..count).map(&mut pair).collect()
}

fn by_hemisphere(stream: &mut Stream) -> (DVec3, DVec3) {
    let mut direction = || {
        let z = unit(stream);
        at(z, TAU * unit(stream))
    };
    (direction(), direction())
}

/// Direction with this cosine and azimuth.
fn at(z: f64, phi: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(phi);
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z).normalize()
}

fn by_half(stream: &mut Stream) -> (DVec3, DVec3) {
    let [theta_h, theta_d] = [(); 2].map(|()| FRAC_PI_2 * unit(stream));
    let [phi_d, phi_h] = [(); 2].map(|()| TAU * unit(stream));
    from_half([theta_h, theta_d, phi_d, phi_h])
}

/// Pair of directions with these theta_h and theta_d, and phi_d of 90 degrees; `None` if one of
/// them is below the surface.
#[must_use]
pub fn pair_of_half(theta_h: f64, theta_d: f64) -> Option<DirectionPair> {
    let (wi, wo) = from_half([theta_h, theta_d, FRAC_PI_2, 0.0]);
    let is_above = wi.z.min(wo.z) >= LEAST_COSINE;
    is_above.then(|| DirectionPair::new(wi, wo).expect("both directions are unit vectors"))
}

/// Pair of directions with these angles: theta_h, theta_d, phi_d, phi_h.
pub(crate) fn from_half([theta_h, theta_d, phi_d, phi_h]: [f64; 4]) -> (DVec3, DVec3) {
    let (sin_h, cos_h) = libm::sincos(theta_h);
    let (sin_d, cos_d) = libm::sincos(theta_d);
    let (sin_pd, cos_pd) = libm::sincos(phi_d);
    let (sin_ph, cos_ph) = libm::sincos(phi_h);
    let turn = |v: DVec3| {
        let v = DVec3::new(cos_h * v.x + sin_h * v.z, v.y, cos_h * v.z - sin_h * v.x);
        DVec3::new(cos_ph * v.x - sin_ph * v.y, sin_ph * v.x + cos_ph * v.y, v.z).normalize()
    };
    let d = DVec3::new(sin_d * cos_pd, sin_d * sin_pd, cos_d);
    // Mirrored at the half vector, which is the z axis here.
    (turn(d), turn(DVec3::new(-d.x, -d.y, d.z)))
}

fn unit(stream: &mut Stream) -> f64 {
    f64::from(stream.unit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draw_pairs_concentrates_half_of_the_pairs_on_highlights() {
        let pairs = draw_pairs(4000, 5);
        assert!(pairs.iter().all(|pair| pair.cos_i().min(pair.cos_o()) >= LEAST_COSINE - 1e-12));
        let near = |start: usize| {
            let of = |pair: &DirectionPair| (pair.wi() + pair.wo()).normalize().z;
            pairs.iter().skip(start).step_by(2).filter(|pair| of(pair) > 0.9962).count()
        };
        // Half vectors within 5 degrees of the normal.
        assert!(near(0) < 30 && near(1) > 120, "{} {}", near(0), near(1));
        assert_eq!(draw_pairs(10, 5), pairs[..10]);
        assert_ne!(draw_pairs(10, 6), pairs[..10]);
    }

    #[test]
    fn grazing_pairs_are_log_uniform_and_half_of_them_near_the_mirror_direction() {
        let pairs = grazing_pairs(4000, 5);
        let cosines: Vec<f64> =
            pairs.iter().flat_map(|pair| [pair.cos_i(), pair.cos_o()]).collect();
        assert!(cosines.iter().all(|cosine| *cosine >= 0.99 * LEAST_NARROW_COSINE));
        for least in [1e-4, 1e-3, 1e-2, 1e-1] {
            let range = least..10.0 * least;
            let count = cosines.iter().filter(|cosine| range.contains(*cosine)).count();
            assert!((1850..2150).contains(&count), "{count} from {least}");
        }
        let is_opposite = |pair: &&DirectionPair| {
            let [wi, wo] = [pair.wi(), pair.wo()].map(|w| w.truncate());
            (PI - wi.angle_to(wo).abs()).to_degrees() < 0.1
        };
        let count = pairs.iter().filter(is_opposite).count();
        assert!((600..720).contains(&count), "{count}");
    }
}
