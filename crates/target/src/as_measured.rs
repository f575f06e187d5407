//! f as it was measured, before light and eye are exchanged, and the least error that a reciprocal
//! material has on it.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use brood_brdf::{Brdf, DirectionPair};

use crate::Samples;

/// Points of the scan for the reciprocal f that is closest to the measured ones, and number of
/// times that the interval around the best is cut to two thirds.
const SCAN: u32 = 8;
const THIRDS: u32 = 20;
/// Resolution at which given angles are compared, in radians.
const ANGLE_STEP: f64 = 1e-4;
/// Half a turn in these steps.
const HALF_TURN: i64 = 31_416;

/// Samples as they were measured, some of them in both orders: before and after the exchange of
/// light and eye.
#[derive(Debug, Clone)]
pub struct AsMeasured {
    /// All samples, of both orders. If the material is defined everywhere, these are the held-out
    /// pairs in both orders; otherwise all given pairs.
    pub samples: Samples,
    /// Number of samples whose pair was also measured in the other order, or again.
    pub repeated: usize,
    /// Least error (E_log) of a reciprocal isotropic material on `samples`.
    pub floor: f64,
}

impl AsMeasured {
    /// Measures a material that is defined everywhere at these pairs in both orders.
    pub(crate) fn everywhere(brdf: &dyn Brdf, pairs: &[DirectionPair]) -> Self {
        let both: Vec<DirectionPair> =
            pairs.iter().flat_map(|pair| [*pair, pair.swapped()]).collect();
        let f = |pair: &DirectionPair| brdf.f(pair).to_array().map(|f| f.max(0.0));
        let values = both.iter().map(f).collect();
        let samples = Samples::new(both, values);
        let groups = (0..samples.len()).step_by(2).map(|at| vec![at, at + 1]);
        let (repeated, floor) = (samples.len(), floor(&samples, groups));
        Self { samples, repeated, floor }
    }

    /// Finds the pairs that are given in both orders, or several times, up to a turn about the
    /// normal. `None` if there are none.
    pub(crate) fn given(samples: &Samples) -> Option<Self> {
        let mut groups: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
        for (at, pair) in samples.pairs().iter().enumerate() {
            groups.entry(place(pair)).or_default().push(at);
        }
        let groups: Vec<Vec<usize>> =
            groups.into_values().filter(|group| group.len() > 1).collect();
        let repeated = groups.iter().map(Vec::len).sum();
        let floor = floor(samples, groups.into_iter());
        (repeated > 0).then(|| Self { samples: samples.clone(), repeated, floor })
    }
}

/// Angles of a pair in steps: both zenith angles, the smaller one first, and the azimuth between
/// these directions. They stay the same when light and eye are exchanged, and when both are turned
/// about the normal.
fn place(pair: &DirectionPair) -> [i64; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "angles are small")]
    let steps = |angle: f64| (angle / ANGLE_STEP).round() as i64;
    let of = |pair: &DirectionPair| {
        let (wi, wo) = (pair.wi(), pair.wo());
        // Exact near the normal, unlike the arc cosine.
        let zenith = |w: glam::DVec3| libm::atan2(w.truncate().length(), w.z);
        let zeniths = [steps(zenith(wi)), steps(zenith(wo))];
        let turn = libm::atan2(wo.y, wo.x) - libm::atan2(wi.y, wi.x);
        let turn = steps((turn + PI).rem_euclid(2.0 * PI) - PI);
        let has_turn = zeniths[0] > 0 && zeniths[1] > 0;
        let turn = if turn == -HALF_TURN { HALF_TURN } else { turn };
        [zeniths[0], zeniths[1], if has_turn { turn } else { 0 }]
    };
    of(pair).min(of(&pair.swapped()))
}

/// Least E_log on the samples if all of a group have the same f; samples of no group are exact.
fn floor(samples: &Samples, groups: impl Iterator<Item = Vec<usize>>) -> f64 {
    let squares = groups.map(|group| -> f64 {
        let channel = |c: usize| {
            let of = |at: &usize| (samples.values()[*at][c], samples.pairs()[*at].cos_i());
            least_squares(&group.iter().map(of).collect::<Vec<_>>())
        };
        (0..3).map(channel).sum()
    });
    (squares.sum::<f64>() / (3.0 * samples.len().max(1) as f64)).sqrt()
}

/// Least sum of squared differences of ln(1 + f cos) between one f and measured values of f, each
/// with its cosine.
fn least_squares(measured: &[(f64, f64)]) -> f64 {
    let all = || measured.iter().map(|(f, _)| *f);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    if low >= high {
        return 0.0;
    }
    let error = |f: f64| -> f64 {
        let difference = |(g, cos): &(f64, f64)| libm::log1p(g * cos) - libm::log1p(f * cos);
        measured.iter().map(difference).map(|difference| difference * difference).sum()
    };
    // The least error is between the least and the largest f. It is searched for on a scale on
    // which equal cosines give a parabola; the scan finds the lowest of several minima.
    let product: f64 = measured.iter().map(|(_, cos)| cos).product();
    let mean_cos = libm::pow(product, 1.0 / measured.len() as f64);
    let [low, high] = [low, high].map(|f| libm::log1p(f * mean_cos));
    let at = |place: f64| error(libm::expm1(low + (high - low) * place) / mean_cos);
    let steps = f64::from(SCAN);
    let lowest = (0..=SCAN).map(f64::from).min_by(|a, b| at(a / steps).total_cmp(&at(b / steps)));
    let lowest = lowest.expect("the scan has points");
    let [mut from, mut to] =
        [lowest - 1.0, lowest + 1.0].map(|step| (step / steps).clamp(0.0, 1.0));
    for _ in 0..THIRDS {
        let third = (to - from) / 3.0;
        if at(from + third) < at(to - third) {
            to -= third;
        } else {
            from += third;
        }
    }
    at(f64::midpoint(from, to))
}

#[cfg(test)]
#[path = "as_measured_tests.rs"]
mod tests;
