//! Error bounds of exported models for each kind, and error statistics.

use super::ReferenceValue;
use brood_genome::ModelKind;

/// Error bound of a kind of model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Kind of the model.
    pub kind: ModelKind,
    /// Bound of the median relative error.
    pub median: f64,
    /// Bound of the largest error in units.
    pub units: f64,
}

/// Bounds of all kinds, a small multiple of the measured errors.
pub const BOUNDS: [Bound; 15] = [
    bound(ModelKind::Lambert, 1e-7, 1.0),
    bound(ModelKind::OrenNayar, 1e-7, 3.0),
    bound(ModelKind::Phong, 1e-7, 16.0),
    bound(ModelKind::BlinnPhong, 1e-7, 8.0),
    bound(ModelKind::ReflectedBlinnPhong, 1e-7, 8.0),
    bound(ModelKind::NormalisedBlinnPhong, 1e-7, 8.0),
    bound(ModelKind::CookTorrance, 1e-7, 10.0),
    bound(ModelKind::Conductor, 5e-7, 16.0),
    bound(ModelKind::Coated, 3e-7, 20.0),
    bound(ModelKind::RoughPlastic, 2e-7, 8.0),
    bound(ModelKind::Principled, 2e-7, 10.0),
    bound(ModelKind::Ward, 1e-7, 16.0),
    bound(ModelKind::AshikhminShirley, 2e-7, 24.0),
    bound(ModelKind::Abc, 1e-7, 16.0),
    bound(ModelKind::Sgd, 1e-7, 16.0),
];

const fn bound(kind: ModelKind, median: f64, units: f64) -> Bound {
    Bound { kind, median, units }
}

/// Errors collected for one kind.
#[derive(Debug, Clone)]
pub struct ErrorTally {
    kind: ModelKind,
    relative: Vec<f64>,
    units: f64,
    worst: String,
}

/// Summary of the errors of one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorSummary {
    /// Median relative error of values that are not 0.
    pub median: f64,
    /// 99th percentile of these errors.
    pub p99: f64,
    /// Largest of these errors.
    pub worst: f64,
    /// The largest error in units.
    pub units: f64,
}

impl ErrorTally {
    /// Creates an empty tally.
    #[must_use]
    pub fn new(kind: ModelKind) -> Self {
        Self { kind, relative: Vec::new(), units: 0.0, worst: String::new() }
    }

    /// Adds a value. `case` describes it in failure messages.
    ///
    /// # Panics
    /// If the value is negative or not finite.
    pub fn add(&mut self, found: [f32; 3], wanted: &ReferenceValue, case: impl Fn() -> String) {
        for (channel, found) in found.into_iter().enumerate() {
            let (f, unit) = (wanted.f[channel], wanted.unit[channel]);
            assert!(found >= 0.0 && found.is_finite(), "{found} instead of {f}: {}", case());
            let off = (f64::from(found) - f).abs();
            if f > super::MIN_F {
                self.relative.push(off / f);
            }
            if off / unit > self.units {
                self.units = off / unit;
                self.worst = format!("{found} instead of {f}: {}", case());
            }
        }
    }

    /// Summary of the errors so far.
    #[must_use]
    pub fn summary(&self) -> ErrorSummary {
        let mut sorted = self.relative.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |share: usize| sorted.get(sorted.len() * share / 100).copied().unwrap_or_default();
        let worst = sorted.last().copied().unwrap_or_default();
        ErrorSummary { median: at(50), p99: at(99), worst, units: self.units }
    }

    /// Checks the errors against [`BOUNDS`].
    ///
    /// # Panics
    /// If an error exceeds its bound.
    pub fn check(&self) {
        let bound = BOUNDS.into_iter().find(|bound| bound.kind == self.kind);
        let bound = bound.expect("every kind has a bound");
        let figures = self.summary();
        let kept = figures.median <= bound.median && figures.units <= bound.units;
        assert!(kept, "{}: {figures:?} beyond {bound:?}; worst: {}", self.kind, self.worst);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn every_kind_has_a_bound_and_larger_errors_panic() {
        assert_eq!(BOUNDS.map(|bound| bound.kind), ModelKind::ALL);
        let unit = DVec3::splat(1e-7);
        let wanted = ReferenceValue { f: DVec3::ONE, unit };
        let mut tally = ErrorTally::new(ModelKind::Ward);
        tally.add([1.0; 3], &wanted, String::new);
        tally.check();
        tally.add([1.1, 1.0, 1.0], &wanted, || "the worst".to_owned());
        assert!(tally.summary().units > 9e5);
        assert!(std::panic::catch_unwind(move || tally.check()).is_err());
    }
}
