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
use crate::{AsMeasured, Reflected, Samples, draw_pairs};

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
/// Least cosine between each direction of a pair and the normal; also that of drawn pairs.
const LEAST_COSINE: f64 = 0.01;

/// A measured material as a target.
#[derive(Debug, Clone)]
pub struct MeasuredTarget {
    /// Fitted samples.
    pub fitted: Samples,
    /// Held-out samples, on which errors are reported.
    pub held: Samples,
    /// f as measured in both orders of directions. `None` if no pair was measured in both.
    pub measured: Option<AsMeasured>,
    /// Largest directional albedo: share of the light from one direction that is reflected. `None`
    /// unless the material is defined everywhere.
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

    /// Least error (E_log) of a reciprocal material on f as measured; see [`AsMeasured::floor`].
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
        let measured = Some(AsMeasured::everywhere(brdf, held.pairs()));
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
        let samples = Samples::new(pairs, values);
        let measured = AsMeasured::given(&samples);
        Ok(Self { measured, ..Self::split(&samples)? })
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
            return Ok(Self::split(samples)?.of_pictures());
        }
        let most = count.min(PIXELS);
        let picked = (0..most).map(|k| k * count / most);
        let (pairs, values) = picked.map(|at| (samples.pairs()[at], samples.values()[at])).unzip();
        let picked = Samples::new(pairs, values).with_means(means.thinned(MEANS));
        let picked = picked.with_lower_bounds(samples.lower_bounds().to_vec());
        Ok(Self::split(&picked)?.of_pictures())
    }

    fn of_pictures(self) -> Self {
        Self { fitted: self.fitted.of_pictures(), held: self.held.of_pictures(), ..self }
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
