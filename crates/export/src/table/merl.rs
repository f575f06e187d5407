//! Writer of MERL's `.binary`: f at the centres of bins of half and difference angles. Bins whose
//! centres are below the surface have f at a place that is above, if there is one.
//!
//! The layout is in the reader, `crates/brdf/src/measured/merl.rs`. A table has one f for both
//! orders of the directions: of a BRDF that is not reciprocal it holds the mean of both.

use std::f64::consts::{FRAC_PI_2, PI};

use brood_brdf::{DirectionPair, Merl};
use glam::DVec3;
use rayon::prelude::*;

use super::deviation::Deviation;
use super::source::Source;
use crate::exported::Exported;
use crate::reflectance::direction;

/// Bins of theta_h, theta_d, and phi_d over half a turn.
const SIZES: [usize; 3] = [90, 90, 180];
/// Factors from f to stored numbers in red, green and blue.
const SCALES: [f64; 3] = [1500.0, 1500.0 / 1.15, 1500.0 / 1.66];
/// Number for bins in which a direction is below the surface everywhere.
const BELOW: f64 = -1.0;

/// Makes the file of an isotropic BRDF.
pub(super) fn file(source: &Source<'_>) -> Exported {
    let rows: Vec<Vec<[f64; 3]>> =
        (0..SIZES[0]).into_par_iter().map(|half| row(source, half)).collect();
    let entries = SIZES.iter().product::<usize>();
    let mut bytes = Vec::with_capacity(12 + 24 * entries);
    for size in SIZES {
        bytes.extend(i32::try_from(size).expect("sizes are small").to_le_bytes());
    }
    for channel in 0..3 {
        bytes.extend(rows.iter().flatten().flat_map(|entry| entry[channel].to_le_bytes()));
    }
    let table = Merl::read(&bytes).expect("the file is valid");
    let order = match source.is_reciprocal() {
        true => "",
        false => ", mean of both orders of light and eye",
    };
    let note = format!("{}{order}; {}", source.words(), Deviation::of(&table, source));
    Exported { bytes, note: Some(note) }
}

/// Numbers of the bins of one theta_h, in the order of the file.
fn row(source: &Source<'_>, half: usize) -> Vec<[f64; 3]> {
    let bins = (0..SIZES[1]).flat_map(|d| (0..SIZES[2]).map(move |phi| pair([half, d, phi])));
    let places: Vec<Option<DirectionPair>> = bins.collect();
    let pairs: Vec<DirectionPair> = places.iter().flatten().copied().collect();
    let mut f = source.f(&pairs);
    if !source.is_reciprocal() {
        let swapped: Vec<DirectionPair> = pairs.iter().map(DirectionPair::swapped).collect();
        let others = source.f(&swapped);
        f.iter_mut().zip(others).for_each(|(f, other)| *f = f.midpoint(other));
    }
    let mut found = f.into_iter();
    let number = |place: &Option<DirectionPair>| match place {
        Some(_) => {
            let f = found.next().expect("there is f for each pair");
            (f.max(DVec3::ZERO) * DVec3::from(SCALES)).to_array()
        }
        None => [BELOW; 3],
    };
    places.iter().map(number).collect()
}

/// Pair of a bin: at the centre, or else where both directions are highest; `None` if a direction
/// is below the surface everywhere.
fn pair(bin: [usize; 3]) -> Option<DirectionPair> {
    const PLACES: [f64; 3] = [0.01, 0.5, 0.99];
    if let Some(pair) = pair_at(bin, [0.5; 3]) {
        return Some(pair);
    }
    let places = (0..27).map(|k| [PLACES[k % 3], PLACES[k / 3 % 3], PLACES[k / 9]]);
    let height = |pair: &DirectionPair| pair.cos_i().min(pair.cos_o());
    let pairs = places.filter_map(|place| pair_at(bin, place));
    pairs.max_by(|a, b| height(a).total_cmp(&height(b)))
}

/// Pair at a place in a bin; `None` if a direction is below the surface.
fn pair_at(bin: [usize; 3], place: [f64; 3]) -> Option<DirectionPair> {
    let part = |axis: usize| (bin[axis] as f64 + place[axis]) / SIZES[axis] as f64;
    // Bins of the half angle follow its square root.
    let theta_h = part(0) * part(0) * FRAC_PI_2;
    let (sin, cos) = (libm::sin(theta_h), libm::cos(theta_h));
    let tilt = |w: DVec3| DVec3::new(cos * w.x + sin * w.z, w.y, cos * w.z - sin * w.x);
    let apart = direction(part(1) * FRAC_PI_2, part(2) * PI);
    let (wi, wo) = (tilt(apart), tilt(DVec3::new(-apart.x, -apart.y, apart.z)));
    (wi.z > 0.0 && wo.z > 0.0)
        .then(|| DirectionPair::new(wi, wo).expect("the directions have length 1"))
}
