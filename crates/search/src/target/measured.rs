//! Measured materials as targets: what is fitted, what is held out, and how close a reciprocal material can come at all.

use brood_brdf::{Brdf, DirectionPair};

use super::{Samples, draw_pairs};
use crate::metric::e_log;

/// Drawn to fit, and to hold out.
const FITTED: usize = 4096;
const HELD: usize = 16384;
/// Of samples that were measured at pairs of their own, one in so many is held out.
const ONE_IN: usize = 5;
/// Fewer cannot be told from noise.
const FEWEST: usize = 100;
/// Streams of what is fitted and what is held out.
const STREAMS: (u64, u64) = (1, 2);
/// As much as a program can reflect: the square of its range.
const LARGEST: f64 = 65504.0 * 65504.0;

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
}

/// Why something is no target.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// Too little to fit.
    #[error(
        "{0} samples are above the surface by more than half a degree; at least {FEWEST} are needed"
    )]
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
        Self { fitted, held, floor }.checked()
    }

    /// Of samples at pairs of their own, in their order.
    pub fn of_samples(samples: &brood_brdf::Samples) -> Result<Self, TargetError> {
        // As far above the surface as the samples of other targets.
        let is_above = |pair: &DirectionPair| pair.cos_i().min(pair.cos_o()) >= 0.01;
        let rows: Vec<_> = samples.rows().iter().filter(|(pair, _)| is_above(pair)).collect();
        if rows.len() < FEWEST {
            return Err(TargetError::Few(rows.len()));
        }
        let part = |is_held: bool| {
            let rows = rows.iter().enumerate().filter(|(at, _)| (at % ONE_IN == 0) == is_held);
            let of = |(pair, f): &(DirectionPair, glam::DVec3)| {
                (*pair, f.to_array().map(|f| f.max(0.0)))
            };
            let (pairs, values) = rows.map(|(_, row)| of(row)).unzip();
            Samples::new(pairs, values)
        };
        Self { fitted: part(false), held: part(true), floor: None }.checked()
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

#[cfg(test)]
mod tests {
    use brood_brdf::{Model, ModelKind};
    use glam::DVec3;

    use super::*;

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
    fn what_is_no_target_is_refused() {
        let refused = |samples| MeasuredTarget::of_samples(&samples).unwrap_err();
        assert_eq!(refused(rows(99, 0.5)), TargetError::Few(99));
        assert_eq!(refused(rows(1000, -1.0)), TargetError::Black(800));
        assert_eq!(refused(rows(1000, 1e12)), TargetError::Value(1e12));
    }
}
