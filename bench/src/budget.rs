//! Budget of a search: a number of generations, or seconds including the final steps.

use std::time::{Duration, Instant};

use brood_search::{Outcome, Progress, Search, TimeBudget};

/// Limit of a search.
#[derive(Debug, Clone, Copy)]
pub enum FitBudget {
    /// Number of generations; gives the same result on every machine.
    Generations(u32),
    /// Seconds. A step is not started if, at the duration of similar ones, it would end later.
    Seconds(f64),
}

/// Runs the search until the budget is spent and calls `on_generation` after each generation.
/// Returns `None` if no generation found anything.
pub fn spend(
    search: &mut Search,
    budget: FitBudget,
    mut on_generation: impl FnMut(&Search, &Progress, Duration),
) -> Option<(Outcome, Progress)> {
    let begun = Instant::now();
    let spent = || begun.elapsed().as_secs_f64();
    let (generations_max, mut pace) = match budget {
        FitBudget::Generations(generations) => (generations, None),
        FitBudget::Seconds(seconds) => (u32::MAX, Some(TimeBudget::new(seconds))),
    };
    loop {
        let (before, times) = (begun.elapsed(), search.next_step_cost());
        let progress = search.step();
        let now = begun.elapsed();
        on_generation(search, &progress, now);
        let is_late = pace.as_mut().is_some_and(|pace| {
            pace.took((now - before).as_secs_f64(), times);
            pace.is_over(now.as_secs_f64(), search)
        });
        if is_late || progress.generation >= generations_max {
            let outcome =
                search.finish_while(|| pace.as_mut().is_none_or(|pace| pace.has_time(spent())));
            return outcome.map(|outcome| (outcome, progress));
        }
    }
}
