//! Fits that a search keeps, and finished fits.

use brood_brdf::Model;

use super::residual::Space;
use crate::levenberg_marquardt::Solution;

/// A fit that is kept.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    pub(super) space: Space,
    /// Solution; its error is the mean square on the training samples, under the energy limit.
    /// Large differences count less if the batch says so.
    pub(super) fit: Solution<Vec<f64>>,
    /// The same on the validation samples.
    pub(super) held: f64,
    /// Mean squares on training and on validation samples in which every difference counts fully.
    pub(super) squares: [f64; 2],
    /// -2 ln of the probability of the form after all samples, up to a constant; the least is best.
    pub(super) evidence: f64,
}

/// A finished fit.
#[derive(Debug, Clone)]
pub(super) struct Finished {
    pub(super) models: Vec<Model>,
    pub(super) parameters: usize,
    /// Mean squares on the training and on the validation samples in which every difference counts
    /// fully, before it was refined on both.
    pub(super) fitted: f64,
    pub(super) held: f64,
    pub(super) evidence: f64,
}

impl Finished {
    pub(super) fn of(kept: &Kept) -> Self {
        let Kept { space, fit, squares: [fitted, held], evidence, .. } = kept;
        let models = space.models(&fit.point);
        Self { models, parameters: space.len(), fitted: *fitted, held: *held, evidence: *evidence }
    }
}
