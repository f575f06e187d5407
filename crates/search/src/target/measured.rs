//! Measured materials as targets: what is fitted, what is held out, and how close a reciprocal material can come at all.

use std::f64::consts::FRAC_PI_2;

use brood_brdf::{Brdf, DirectionPair};
use glam::DVec3;

use super::{Reflected, Samples, draw_pairs, from_half};
use crate::metric::e_log;

/// Drawn to fit, and to hold out.
const FITTED: usize = 4096;
const HELD: usize = 16384;
/// Of samples that were measured at pairs of their own, one in so many is held out.
const ONE_IN: usize = 5;
/// Pixels that are looked at, at most.
const PIXELS: usize = 10_240;
/// Pairs of which nothing is known but that f is not below a value: of more only some are looked at, evenly.
const LEAST: usize = 1024;
/// Fewer cannot be told from noise.
const FEWEST: usize = 100;
/// Streams of what is fitted and what is held out.
const STREAMS: (u64, u64) = (1, 2);
/// As much as a program can reflect: the square of its range.
const LARGEST: f64 = 65504.0 * 65504.0;

/// Prime, and no divisor of the samples of a slice.
const STRIDE: usize = 1009;
/// Both cosines are at least this.
const LEAST_COSINE: f64 = 0.01;

/// A measured material.
#[derive(Debug, Clone)]
pub struct MeasuredTarget {
    /// What is fitted.
    pub fitted: Samples,
    /// What is held out, to measure by.
    pub held: Samples,
    /// E_log of the mean over the exchange of light and eye against what was measured, on what is held out: closer no reciprocal
    /// material comes. None where only one of a pair and its exchange was measured.
    pub floor: Option<f64>,
    /// The most that is reflected of the light from one direction, of a material that is known everywhere.
    pub reflected: Option<Reflected>,
}

/// Why something is no target.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// Too little to fit.
    #[error("{0} samples are above the surface by more than half a degree, {FEWEST} are needed")]
    Few(usize),
    /// Nothing to match.
    #[error("it reflects nothing at any of {0} samples")]
    Black(usize),
    /// A value no program reaches.
    #[error("it reflects {0}, which is no finite number up to {LARGEST:.3e}")]
    Value(f64),
}

impl MeasuredTarget {
    /// Of a material that is known everywhere.
    pub fn of(brdf: &dyn Brdf) -> Result<Self, TargetError> {
        let fitted = Samples::of(brdf, draw_pairs(FITTED, STREAMS.0));
        let held = Samples::of(brdf, draw_pairs(HELD, STREAMS.1));
        let raw = held.pairs().iter().map(|pair| brdf.f(pair).to_array().map(|f| f.max(0.0)));
        let raw = Samples::new(held.pairs().to_vec(), raw.collect());
        let floor = Some(e_log(&raw.weighted(), &held.weighted()));
        let reflected = Some(Reflected::most(brdf));
        Self { fitted, held, floor, reflected }.checked()
    }

    /// Of a material that is known by its image slice alone: at the middle of each of 90 x 90 degrees of theta_h and theta_d, phi_d
    /// being a quarter turn.
    pub fn of_slice(slice: &dyn Brdf) -> Result<Self, TargetError> {
        let middle = |index: u32| (f64::from(index) + 0.5).to_radians();
        let angles =
            (0..90).flat_map(|row| (0..90).map(move |column| (middle(column), middle(row))));
        let pair = |(theta_h, theta_d): (f64, f64)| {
            let (wi, wo) = from_half([theta_h, theta_d, FRAC_PI_2, 0.0]);
            DirectionPair::new(wi, wo).expect("both have been made unit")
        };
        // In another order, so that every fifth is not a column.
        let pairs: Vec<DirectionPair> = angles.map(pair).collect();
        let count = pairs.len();
        let pairs = (0..count).map(|at| pairs[at * STRIDE % count]).filter(is_above).collect();
        Self::split(&Samples::of(slice, pairs))
    }

    /// Of samples at pairs of their own, in their order.
    pub fn of_samples(samples: &brood_brdf::Samples) -> Result<Self, TargetError> {
        let rows = samples.rows().iter().filter(|(pair, _)| is_above(pair));
        let of = |(pair, f): &(DirectionPair, DVec3)| (*pair, f.to_array().map(|f| f.max(0.0)));
        let (pairs, values) = rows.map(of).unzip();
        Self::split(&Samples::new(pairs, values))
    }

    /// Of the pixels of pictures: of very many only some, evenly.
    pub fn of_pixels(samples: &Samples) -> Result<Self, TargetError> {
        let count = samples.len();
        if count <= PIXELS {
            return Self::split(samples);
        }
        let picked = (0..PIXELS).map(|k| k * count / PIXELS);
        let (pairs, values) = picked.map(|at| (samples.pairs()[at], samples.values()[at])).unzip();
        Self::split(&Samples::new(pairs, values).with_least(samples.least().to_vec()))
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
        let step = samples.least().len().div_ceil(LEAST).max(1);
        let least = samples.least().iter().step_by(step).copied().collect();
        let fitted = part(false).with_least(least);
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

/// As far above the surface as what is drawn.
fn is_above(pair: &DirectionPair) -> bool {
    pair.cos_i().min(pair.cos_o()) >= LEAST_COSINE
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_brdf::{Model, ModelKind};

    fn rows(count: usize, f: f64) -> brood_brdf::Samples {
        let rows = draw_pairs(count, 9).into_iter().map(|pair| (pair, DVec3::splat(f))).collect();
        brood_brdf::Samples::new(rows).unwrap()
    }

    #[test]
    fn reciprocal_material_can_be_matched_and_another_one_not_wholly() {
        let target = MeasuredTarget::of(&*Model::new(ModelKind::Conductor).brdf()).unwrap();
        assert_eq!((target.fitted.len(), target.held.len()), (FITTED, HELD));
        assert!(target.floor.is_some_and(|floor| floor < 1e-12));
        let phong = MeasuredTarget::of(&*Model::new(ModelKind::Phong).brdf()).unwrap();
        assert!(phong.floor.is_some_and(|floor| floor > 1e-3), "{:?}", phong.floor);
    }

    #[test]
    fn samples_are_fitted_but_for_every_fifth() {
        let target = MeasuredTarget::of_samples(&rows(1000, 0.5)).unwrap();
        assert_eq!((target.fitted.len(), target.held.len()), (800, 200));
        assert_eq!(target.floor, None);
    }

    #[test]
    fn slice_is_fitted_where_it_has_values() {
        let target = MeasuredTarget::of_slice(&*Model::new(ModelKind::Conductor).brdf()).unwrap();
        let all = target.fitted.len() + target.held.len();
        assert!((6000..8100).contains(&all) && target.held.len() == all.div_ceil(5), "{all}");
    }

    #[test]
    fn what_is_no_target_is_refused() {
        let refused = |samples| MeasuredTarget::of_samples(&samples).unwrap_err();
        assert_eq!(refused(rows(99, 0.5)), TargetError::Few(99));
        assert_eq!(refused(rows(1000, -1.0)), TargetError::Black(800));
        assert_eq!(refused(rows(1000, 1e12)), TargetError::Value(1e12));
    }
}
