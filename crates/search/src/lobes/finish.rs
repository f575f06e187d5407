//! End of a fit: prunes the best fit step by step, refines the results on all samples, and enforces
//! bounds and albedo.

use rayon::prelude::*;

use super::Lobes;
use super::normal_equations::e_log;
use super::prune::Shorter;
use super::schedule::{Fit, Problem};
use crate::levenberg_marquardt::Solution;
use crate::method::HasTime;

/// Number of steps on all samples.
const STEPS: usize = 10;

/// A finished fit.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Parameters of the fit.
    pub lobes: Lobes,
    /// E_log on the training samples, bounds included, before refinement on all samples.
    pub fitted: f64,
    /// E_log on the validation samples, before refinement on these as well.
    pub held: f64,
    /// Error used for ranking: the minimised objective on the training samples plus the square of
    /// `held`. Fits chosen by E_log alone have higher peaks where samples are few.
    pub(super) ranking_error: f64,
}

impl Fit {
    /// The best fit, then the shorter fits that pruning of its least salient weights makes step by
    /// step; empty before the first generation.
    pub(crate) fn front(&self) -> impl Iterator<Item = Fitted> {
        self.kept.first().into_iter().flat_map(|best| {
            let Problem { all, held, .. } = &self.shapes[best.problem];
            let fitted = |fit: Solution<Lobes>| {
                let (fitted, held) = (e_log(&fit.point, all), e_log(&fit.point, held));
                Fitted { fitted, held, ranking_error: fit.error + held * held, lobes: fit.point }
            };
            let first = best.fit.clone();
            std::iter::once(first.clone()).chain(Shorter::new(first, best.held, all)).map(fitted)
        })
    }

    /// Refines fits of [`Fit::front`] on all samples, validation samples included. Drops those that
    /// still exceed the ceiling or an albedo of 1, unless all do. The first one is always refined;
    /// the others as long as `has_time` returns true, which is called before every few of them.
    pub(crate) fn refine(
        &self,
        mut front: impl Iterator<Item = Fitted>,
        has_time: &mut HasTime<'_>,
    ) -> Vec<Fitted> {
        let Some(best) = self.kept.first() else { return Vec::new() };
        has_time();
        let Problem { shape, whole, pool, .. } = &self.shapes[best.problem];
        let pool = pool.with_ceiling(shape, self.largest, self.seed);
        let refined = |fitted: Fitted| {
            let mut fit = Solution::of(fitted.lobes, whole);
            fit.refine(whole, STEPS);
            let lobes = pool.enforce(fit, whole).point;
            let is_below = pool.is_below(&lobes) && !pool.exceeds_albedo(&lobes, 1.0);
            (Fitted { lobes, ..fitted }, is_below)
        };
        let mut found: Vec<(Fitted, bool)> = front.next().map(&refined).into_iter().collect();
        // One per thread at a time. Fits are independent, so the number of threads does not change
        // them.
        let few = rayon::current_num_threads();
        while has_time() {
            let next: Vec<Fitted> = front.by_ref().take(few).collect();
            if next.is_empty() {
                break;
            }
            found.par_extend(next.into_par_iter().map(&refined));
        }
        if found.iter().any(|(_, is_below)| *is_below) {
            found.retain(|(_, is_below)| *is_below);
        }
        found.into_iter().map(|(fitted, _)| fitted).collect()
    }
}
