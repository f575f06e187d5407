//! Fits that a search keeps, and finished fits.

use brood_brdf::Model;

use super::residual::Space;
use crate::levenberg_marquardt::Solution;

/// A fit that is kept.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    pub(super) space: Space,
    /// Solution; its error is the mean square on the training samples, under the energy limit.
    pub(super) fit: Solution<Vec<f64>>,
    /// Mean square on the validation samples, under the energy limit.
    pub(super) held: f64,
    /// -2 ln of the probability of the form after all samples, up to a constant; the least is best.
    pub(super) evidence: f64,
}

/// A finished fit.
#[derive(Debug, Clone)]
pub(super) struct Finished {
    pub(super) models: Vec<Model>,
    pub(super) parameters: usize,
    /// Mean squares on the training and on the validation samples, before it was refined on both.
    pub(super) fitted: f64,
    pub(super) held: f64,
    pub(super) evidence: f64,
}

impl Finished {
    pub(super) fn of(kept: &Kept) -> Self {
        let Kept { space, fit, held, evidence } = kept;
        let (parameters, fitted) = (space.len(), fit.error);
        let models = space.models(&fit.point);
        Self { models, parameters, fitted, held: *held, evidence: *evidence }
    }
}
