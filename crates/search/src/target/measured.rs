//! Measured materials as targets: fitted samples, held-out samples, and the least error that a
//! reciprocal material can reach.

use std::f64::consts::FRAC_PI_2;

use brood_brdf::{Brdf, DirectionPair};
use brood_genome::RANGE;
use glam::DVec3;

use super::{Reflected, Samples, draw_pairs, from_half};
use crate::metric::e_log;

/// Number of pairs drawn for the fitted and for the held-out samples.
const FITTED: usize = 4096;
const HELD: usize = 16384;
/// Every fifth sample of a material measured at given pairs is held out.
const ONE_IN: usize = 5;
/// Largest number of pixels used.
const PIXELS: usize = 10_240;
/// Largest number of lower bounds used, evenly picked.
const LEAST: usize = 1024;
/// Least number of samples; fewer cannot be distinguished from noise.
const FEWEST: usize = 100;
/// Seeds of the fitted and of the held-out pairs.
const STREAMS: (u64, u64) = (1, 2);
/// Largest f of a program: the square of its range.
pub(crate) const LARGEST: f64 = (RANGE as f64) * (RANGE as f64);

/// Stride through the samples of a slice: a prime that does not divide their number.
const STRIDE: usize = 1009;
/// Least value of both cosines.
const LEAST_COSINE: f64 = 0.01;

/// A measured material as a target.
#[derive(Debug, Clone)]
pub struct MeasuredTarget {
    /// Fitted samples.
    pub fitted: Samples,
    /// Held-out samples, on which errors are reported.
    pub held: Samples,
    /// E_log, on the held-out samples, of the measurement's mean over the exchange of light and
    /// eye: the least error of a reciprocal material. `None` if only one of a pair and its exchange
    /// was measured.
    pub floor: Option<f64>,
    /// Largest directional albedo; `None` unless the material is defined everywhere.
    pub reflected: Option<Reflected>,
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
    /// A value that no program can reach.
    #[error("reflectance must be a finite number from 0 to {LARGEST:.3e}, got {0}")]
    Value(f64),
}

impl MeasuredTarget {
    /// Target of a material that is defined everywhere.
    ///
    /// # Errors
    /// Returns [`TargetError`] if the material is black, or a value is out of range.
    pub fn of(brdf: &dyn Brdf) -> Result<Self, TargetError> {
        let fitted = Samples::of(brdf, draw_pairs(FITTED, STREAMS.0));
        let held = Samples::of(brdf, draw_pairs(HELD, STREAMS.1));
        let raw = held.pairs().iter().map(|pair| brdf.f(pair).to_array().map(|f| f.max(0.0)));
        let raw = Samples::new(held.pairs().to_vec(), raw.collect());
        let floor = Some(e_log(&raw.weighted(), &held.weighted()));
        let reflected = Some(Reflected::most(brdf));
        Self { fitted, held, floor, reflected }.checked()
    }

    /// Target of an image slice: f at the middle of each of 90 x 90 degrees of theta_h and theta_d,
    /// with phi_d a quarter turn.
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
        // Shuffled, so that every fifth sample is not a column.
        let pairs: Vec<DirectionPair> = angles.map(pair).collect();
        let count = pairs.len();
        let pairs = (0..count).map(|at| pairs[at * STRIDE % count]).filter(is_above).collect();
        Self::split(&Samples::of(slice, pairs))
    }

    /// Target of samples measured at given pairs, in their order.
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

    /// Target of the pixels of pictures; if there are too many, an even selection of them.
    ///
    /// # Errors
    /// Returns [`TargetError`] if there are too few samples, all are black, or a value is out of
    /// range.
    pub fn of_pixels(samples: &Samples) -> Result<Self, TargetError> {
        let count = samples.len();
        if count <= PIXELS {
            return Self::split(samples);
        }
        let picked = (0..PIXELS).map(|k| k * count / PIXELS);
        let (pairs, values) = picked.map(|at| (samples.pairs()[at], samples.values()[at])).unzip();
        Self::split(&Samples::new(pairs, values).with_lower_bounds(samples.lower_bounds().to_vec()))
    }

    fn split(samples: &Samples) -> Result<Self, TargetError> {
        if samples.len() < FEWEST {
            return Err(TargetError::Few(samples.len()));
        }
        let part = |is_held: bool| {
            let rows = (0..samples.len()).filter(|at| (at % ONE_IN == 0) == is_held);
            let (pairs, values) =
                rows.map(|at| (samples.pairs()[at], samples.values()[at])).unzip();
            Samples::new(pairs, values)
        };
        let step = samples.lower_bounds().len().div_ceil(LEAST).max(1);
        let least = samples.lower_bounds().iter().step_by(step).copied().collect();
        let fitted = part(false).with_lower_bounds(least);
        Self { fitted, held: part(true), floor: None, reflected: None }.checked()
    }

    fn checked(self) -> Result<Self, TargetError> {
        let values = || [&self.fitted, &self.held].into_iter().flat_map(|samples| samples.values());
        let wrong = |f: &f64| !(0.0..=LARGEST).contains(f);
        if let Some(f) = values().flatten().copied().find(wrong) {
            return Err(TargetError::Value(f));
        }
        match self.fitted.largest() {
            0.0 => Err(TargetError::Black(self.fitted.len())),
            _ => Ok(self),
        }
    }
}

/// True if the pair is as far above the surface as drawn pairs.
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
        assert!(target.floor.is_some_and(|floor| floor < 1e-12));
        let phong = MeasuredTarget::of(&*Model::new(ModelKind::Phong).brdf()).unwrap();
        assert!(phong.floor.is_some_and(|floor| floor > 1e-3), "{:?}", phong.floor);
    }

    #[test]
    fn every_fifth_sample_is_held_out() {
        let target = MeasuredTarget::of_samples(&rows(1000, 0.5)).unwrap();
        assert_eq!((target.fitted.len(), target.held.len()), (800, 200));
        assert_eq!(target.floor, None);
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
