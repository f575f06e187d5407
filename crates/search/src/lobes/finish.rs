//! The end of a fit: the best and its shorter ones, refined on all samples and held where samples are few.

use rayon::prelude::*;

use super::Lobes;
use super::damped::Damped;
use super::normal::e_log;
use super::prune::Shorter;
use super::schedule::{Fit, Problem};
use crate::method::GoOn;

/// Steps on all samples.
const STEPS: usize = 10;

/// A fit that is done.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The fit.
    pub lobes: Lobes,
    /// Its E_log on the samples it was fitted to, bounds being samples too; before it was refined on all of them.
    pub fitted: f64,
    /// On those held back, before it was refined on these as well.
    pub held: f64,
    /// What the least of is the best: all that was minimised where it was fitted, and the square of `held`. Fits chosen by E_log alone
    /// stand out more where samples are few.
    pub(super) off: f64,
}

impl Fit {
    /// The best, and the shorter ones that come of leaving out, one after the other, what it needs least; nothing where there has
    /// been no generation.
    pub(crate) fn front(&self) -> impl Iterator<Item = Fitted> {
        self.kept.first().into_iter().flat_map(|best| {
            let Problem { all, held, .. } = &self.shapes[best.problem];
            let fitted = |fit: Damped| {
                let (fitted, held) = (e_log(&fit.lobes, all), e_log(&fit.lobes, held));
                Fitted { fitted, held, off: fit.error + held * held, lobes: fit.lobes }
            };
            let first = best.damped.clone();
            std::iter::once(first.clone()).chain(Shorter::new(first, best.held, all)).map(fitted)
        })
    }

    /// These of [`Fit::front`] refined on all samples, those held back as well; without those that even then stand out where samples
    /// are few or send back more than there is, unless all do. The first is refined in any case; `go_on` is asked before every few.
    pub(crate) fn refine(
        &self,
        mut front: impl Iterator<Item = Fitted>,
        go_on: &mut GoOn<'_>,
    ) -> Vec<Fitted> {
        let Some(best) = self.kept.first() else { return Vec::new() };
        go_on();
        let Problem { shape, whole, pool, .. } = &self.shapes[best.problem];
        let pool = pool.ceiled(shape, self.largest, self.seed);
        let refined = |fitted: Fitted| {
            let mut fit = Damped::new(fitted.lobes, whole);
            fit.refine(whole, STEPS);
            let lobes = pool.hold(fit, whole).lobes;
            let is_below = pool.is_below(&lobes) && pool.albedos().largest(&lobes) <= 1.0;
            (Fitted { lobes, ..fitted }, is_below)
        };
        let mut found: Vec<(Fitted, bool)> = front.next().map(&refined).into_iter().collect();
        // As many as are refined at once; what becomes of each has nothing to do with the others.
        let few = rayon::current_num_threads();
        while go_on() {
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
