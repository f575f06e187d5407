//! Measured materials as targets of a search: samples that the search fits, held-out samples on
//! which errors are reported, and the least error that a reciprocal material can reach.
//!
//! f is the reflectance (BRDF) of red, green and blue for a pair of directions. A material is
//! reciprocal if f stays the same when light and eye are exchanged.

use std::f64::consts::FRAC_PI_2;

use brood_brdf::{Brdf, DirectionPair};
use brood_genome::RANGE;
use glam::DVec3;

use crate::draw::from_half;
use crate::{Reflected, Samples, draw_pairs};

/// Number of pairs drawn for the fitted samples of a material that is defined everywhere.
const FITTED: usize = 4096;
/// Number of pairs drawn for its held-out samples.
const HELD: usize = 16384;
/// One in this many samples is held out, if the material was measured at given pairs.
const ONE_IN: usize = 5;
/// Largest number of pixels used as samples, fitted and held-out together.
const PIXELS: usize = 10_240;
/// The same for pixels that are lit from several directions, whose evaluation takes longer.
const MEANS: usize = 4096;
/// Largest number of clipped pixels used, evenly picked. Of their f only a lower bound is known.
const LEAST: usize = 1024;
/// Least number of samples; fewer cannot be distinguished from noise.
pub(crate) const FEWEST: usize = 100;
/// Seeds from which the fitted and the held-out pairs are drawn.
const STREAMS: (u64, u64) = (1, 2);
/// Step from one sample of a slice to the next in shuffled order: a prime that does not divide
/// their number, so that every sample is visited once.
const STRIDE: usize = 1009;
/// Points of the scan for the reciprocal f that is closest to two measured ones, and number of
/// times that the interval around the best is cut to two thirds.
const SCAN: u32 = 8;
const THIRDS: u32 = 20;
/// Least cosine between each direction of a pair and the normal; also that of drawn pairs.
const LEAST_COSINE: f64 = 0.01;

/// A measured material as a target.
#[derive(Debug, Clone)]
pub struct MeasuredTarget {
    /// Fitted samples.
    pub fitted: Samples,
    /// Held-out samples, on which errors are reported.
    pub held: Samples,
    /// f as measured, where samples are means of both orders of directions. `None` unless the
    /// material is defined everywhere.
    pub measured: Option<AsMeasured>,
    /// Largest directional albedo: share of the light from one direction that is reflected. `None`
    /// unless the material is defined everywhere.
    pub reflected: Option<Reflected>,
}

/// The held-out samples as they were measured, in both orders: before and after the exchange of
/// light and eye.
#[derive(Debug, Clone)]
pub struct AsMeasured {
    /// f in the order of the pair, and with light and eye exchanged.
    values: Vec<[[f64; 3]; 2]>,
    /// Least error (E_log) of a reciprocal material on these samples, both orders.
    pub floor: f64,
}

impl AsMeasured {
    fn of(brdf: &dyn Brdf, pairs: &[DirectionPair]) -> Self {
        let f = |pair: &DirectionPair| brdf.f(pair).to_array().map(|f| f.max(0.0));
        let both = |pair: &DirectionPair| [f(pair), f(&pair.swapped())];
        let values: Vec<[[f64; 3]; 2]> = pairs.iter().map(both).collect();
        let squares = pairs.iter().zip(&values).map(|(pair, [one, other])| -> f64 {
            let channel =
                |c: usize| least_squares([(one[c], pair.cos_i()), (other[c], pair.cos_o())]);
            (0..3).map(channel).sum()
        });
        let floor = (squares.sum::<f64>() / (6.0 * pairs.len().max(1) as f64)).sqrt();
        Self { values, floor }
    }

    /// Returns the samples of both orders; `pairs` are those of the held-out samples.
    #[must_use]
    pub fn samples(&self, pairs: &[DirectionPair]) -> Samples {
        let both = pairs
            .iter()
            .zip(&self.values)
            .flat_map(|(pair, values)| [(*pair, values[0]), (pair.swapped(), values[1])]);
        let (pairs, values) = both.unzip();
        Samples::new(pairs, values)
    }
}

/// Least sum of squared differences of ln(1 + f cos) that one f has from two measured ones, each
/// with its cosine.
fn least_squares(measured: [(f64, f64); 2]) -> f64 {
    let [(one, _), (other, _)] = measured;
    if one == other {
        return 0.0;
    }
    let error = |f: f64| -> f64 {
        let difference = |(g, cos): (f64, f64)| libm::log1p(g * cos) - libm::log1p(f * cos);
        measured.map(difference).iter().map(|difference| difference * difference).sum()
    };
    // The least error is between the two. It is searched for on a scale on which equal cosines give
    // a parabola; the scan finds the lowest of several minima.
    let mean_cos = (measured[0].1 * measured[1].1).sqrt();
    let [low, high] = [one.min(other), one.max(other)].map(|f| libm::log1p(f * mean_cos));
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

/// Error of using measurements as a target.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// Too few samples.
    #[error(
        "{0} samples are above the surface by more than half a degree; at least {FEWEST} are needed"
    )]
    Few(usize),
    /// All samples are black.
    #[error("it reflects nothing at any of {0} samples")]
    Black(usize),
    /// A sample's f is negative, not finite, or greater than programs can reach.
    #[error(
        "reflectance must be a finite number from 0 to {most:.3e}, got {0}",
        most = MeasuredTarget::LARGEST
    )]
    Value(f64),
}

impl MeasuredTarget {
    /// Largest f of a sample. A program's f is the square of a result (its layers and output stage
    /// aside), and results are at most [`RANGE`].
    pub const LARGEST: f64 = (RANGE as f64) * (RANGE as f64);

    /// Least error (E_log) of a reciprocal material on f as measured, see [`AsMeasured`].
    #[must_use]
    pub fn floor(&self) -> Option<f64> {
        self.measured.as_ref().map(|measured| measured.floor)
    }

    /// Makes the target of a material that is defined everywhere, that is for all directions above
    /// the surface.
    ///
    /// # Errors
    /// Returns [`TargetError`] if the material is black, or a value is out of range.
    pub fn of(brdf: &dyn Brdf) -> Result<Self, TargetError> {
        let fitted = Samples::of(brdf, draw_pairs(FITTED, STREAMS.0));
        let held = Samples::of(brdf, draw_pairs(HELD, STREAMS.1));
        let measured = Some(AsMeasured::of(brdf, held.pairs()));
        let reflected = Some(Reflected::most(brdf));
        Self { fitted, held, measured, reflected }.checked()
    }

    /// Makes the target of an image slice: a picture of f over theta_h (columns) and theta_d
    /// (rows), with phi_d = 90 degrees. It is sampled at the middle of each of 90 x 90 degrees.
    ///
    /// # Errors
    /// Returns [`TargetError`] if there are too few samples, all are black, or a value is out of
    /// range.
    pub fn of_slice(slice: &dyn Brdf) -> Result<Self, TargetError> {
        let middle = |index: u32| (f64::from(index) + 0.5).to_radians();
        let angles =
            (0..90).flat_map(|row| (0..90).map(move |column| (middle(column), middle(row))));
        let pair = |(theta_h, theta_d): (f64, f64)| {
            let (wi, wo) = from_half([theta_h, theta_d, FRAC_PI_2, 0.0]);
            DirectionPair::new(wi, wo).expect("both directions are unit vectors")
        };
        // Shuffled: 5 divides 90, so in the order of the rows the held-out samples, every fifth,
        // would be whole columns.
        let pairs: Vec<DirectionPair> = angles.map(pair).collect();
        let count = pairs.len();
        let pairs = (0..count).map(|at| pairs[at * STRIDE % count]).filter(is_above).collect();
        Self::split(&Samples::of(slice, pairs))
    }

    /// Makes the target of samples measured at given pairs; every fifth in their order is held out.
    ///
    /// # Errors
    /// Returns [`TargetError`] if there are too few samples, all are black, or a value is out of
    /// range.
    pub fn of_samples(samples: &brood_brdf::MeasuredSamples) -> Result<Self, TargetError> {
        let rows = samples.rows().iter().filter(|(pair, _)| is_above(pair));
        let of = |(pair, f): &(DirectionPair, DVec3)| (*pair, f.to_array().map(|f| f.max(0.0)));
        let (pairs, values) = rows.map(of).unzip();
        Self::split(&Samples::new(pairs, values))
    }

    /// Makes the target of the usable pixels of pictures; an even selection if there are more than
    /// 10,240.
    ///
    /// # Errors
    /// Returns [`TargetError`] if there are too few samples, all are black, or a value is out of
    /// range.
    pub fn of_pixels(samples: &Samples) -> Result<Self, TargetError> {
        let (count, means) = (samples.len(), samples.means());
        if count <= PIXELS && means.len() <= MEANS {
            return Self::split(samples);
        }
        let most = count.min(PIXELS);
        let picked = (0..most).map(|k| k * count / most);
        let (pairs, values) = picked.map(|at| (samples.pairs()[at], samples.values()[at])).unzip();
        let picked = Samples::new(pairs, values).with_means(means.thinned(MEANS));
        Self::split(&picked.with_lower_bounds(samples.lower_bounds().to_vec()))
    }

    /// Makes a target that holds out every fifth sample, the first included.
    fn split(samples: &Samples) -> Result<Self, TargetError> {
        if samples.observations() < FEWEST {
            return Err(TargetError::Few(samples.observations()));
        }
        let part = |is_held: bool| {
            let is_in = |at: &usize| at.is_multiple_of(ONE_IN) == is_held;
            let rows = (0..samples.len()).filter(is_in);
            let (pairs, values) =
                rows.map(|at| (samples.pairs()[at], samples.values()[at])).unzip();
            let means = samples.means();
            Samples::new(pairs, values).with_means(means.select((0..means.len()).filter(is_in)))
        };
        let step = samples.lower_bounds().len().div_ceil(LEAST).max(1);
        let least = samples.lower_bounds().iter().step_by(step).copied().collect();
        let fitted = part(false).with_lower_bounds(least);
        Self { fitted, held: part(true), measured: None, reflected: None }.checked()
    }

    /// Returns the target, or the error of its values.
    fn checked(self) -> Result<Self, TargetError> {
        let values = || {
            [&self.fitted, &self.held].into_iter().flat_map(|samples| {
                let means = samples.means().values().iter().map(|value| &value.mean);
                samples.values().iter().chain(means)
            })
        };
        let wrong = |f: &f64| !(0.0..=Self::LARGEST).contains(f);
        if let Some(f) = values().flatten().copied().find(wrong) {
            return Err(TargetError::Value(f));
        }
        match self.fitted.largest() {
            0.0 => Err(TargetError::Black(self.fitted.len())),
            _ => Ok(self),
        }
    }
}

/// True if both directions are more than about half a degree above the surface, as in drawn pairs.
fn is_above(pair: &DirectionPair) -> bool {
    pair.cos_i().min(pair.cos_o()) >= LEAST_COSINE
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_brdf::{Model, ModelKind};

    fn rows(count: usize, f: f64) -> brood_brdf::MeasuredSamples {
        let rows = draw_pairs(count, 9).into_iter().map(|pair| (pair, DVec3::splat(f))).collect();
        brood_brdf::MeasuredSamples::new(rows).unwrap()
    }

    #[test]
    fn floor_is_zero_only_for_reciprocal_materials() {
        let target = MeasuredTarget::of(&*Model::new(ModelKind::Conductor).brdf()).unwrap();
        assert_eq!((target.fitted.len(), target.held.len()), (FITTED, HELD));
        assert!(target.floor().is_some_and(|floor| floor < 1e-12));
        let phong = MeasuredTarget::of(&*Model::new(ModelKind::Phong).brdf()).unwrap();
        assert!(phong.floor().is_some_and(|floor| floor > 1e-3), "{:?}", phong.floor());
    }

    /// The samples that are fitted are reciprocal, so their error is 0, below the floor. On f as
    /// measured, in both orders, the same material is at least as far away as the floor.
    #[test]
    fn floor_is_below_the_error_of_reciprocal_materials_on_the_same_samples() {
        let phong = Model::new(ModelKind::Phong);
        let target = MeasuredTarget::of(&*phong.brdf()).unwrap();
        let measured = target.measured.as_ref().unwrap();
        let samples = measured.samples(target.held.pairs());
        assert_eq!(samples.len(), 2 * HELD);
        let error = |found: &dyn Fn(usize) -> [f64; 3]| {
            let found = (0..samples.len()).map(found).collect();
            let found = Samples::new(samples.pairs().to_vec(), found);
            crate::metric::e_log(&samples.weighted(), &found.weighted())
        };
        let exact = error(&|at| phong.brdf().f(&samples.pairs()[at]).to_array());
        assert!(exact < 1e-12, "{exact}");
        let mean = error(&|at| target.held.values()[at / 2]);
        let darker = error(&|at| target.held.values()[at / 2].map(|f| 0.9 * f));
        assert!(measured.floor <= mean && mean < 3.0 * measured.floor, "{mean} {}", measured.floor);
        assert!(darker > measured.floor, "{darker} {}", measured.floor);
    }

    #[test]
    fn least_squares_is_the_minimum_of_a_fine_scan() {
        for measured in [
            [(0.5, 0.3), (0.5, 0.9)],
            [(0.0, 0.3), (2.0, 0.9)],
            [(900.0, 0.02), (0.1, 1.0)],
            [(1e4, 1.0), (1e-3, 0.01)],
            [(3.0, 0.5), (5.0, 0.5)],
        ] {
            let error = |f: f64| -> f64 {
                let of = |(g, cos): (f64, f64)| (g * cos).ln_1p() - (f * cos).ln_1p();
                measured.map(of).iter().map(|difference| difference * difference).sum()
            };
            let [low, high] = [measured[0].0.min(measured[1].0), measured[0].0.max(measured[1].0)];
            let at = |step: u32| {
                (low.ln_1p() + (high.ln_1p() - low.ln_1p()) * f64::from(step) / 1e4).exp_m1()
            };
            let scanned = (0..=10_000).map(at).map(error).fold(f64::INFINITY, f64::min);
            let found = least_squares(measured);
            assert!((found - scanned).abs() < 1e-6, "{measured:?} {found} {scanned}");
        }
    }

    #[test]
    fn every_fifth_sample_is_held_out() {
        let target = MeasuredTarget::of_samples(&rows(1000, 0.5)).unwrap();
        assert_eq!((target.fitted.len(), target.held.len()), (800, 200));
        assert_eq!(target.floor(), None);
    }

    #[test]
    fn slice_is_sampled_above_the_surface() {
        let target = MeasuredTarget::of_slice(&*Model::new(ModelKind::Conductor).brdf()).unwrap();
        let all = target.fitted.len() + target.held.len();
        assert!((6000..8100).contains(&all) && target.held.len() == all.div_ceil(5), "{all}");
    }

    #[test]
    fn unusable_samples_are_rejected() {
        let refused = |samples| MeasuredTarget::of_samples(&samples).unwrap_err();
        assert_eq!(refused(rows(99, 0.5)), TargetError::Few(99));
        assert_eq!(refused(rows(1000, -1.0)), TargetError::Black(800));
        assert_eq!(refused(rows(1000, 1e12)), TargetError::Value(1e12));
    }
}
