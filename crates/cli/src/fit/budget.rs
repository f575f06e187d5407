//! How long a search goes on: so many generations, or so many seconds, with what finishing takes.

use std::time::{Duration, Instant};

use brood_search::{Outcome, Pace, Progress, Search};

/// What a search may take.
#[derive(Debug, Clone, Copy)]
pub enum Budget {
    /// So many generations: the same result on every machine.
    Generations(u32),
    /// Nothing is begun that would, if it took as long as what was like it, end later.
    Seconds(f64),
}

/// Goes on with the search until the budget is used up, `told` being told of each generation. Nothing where no generation found
/// anything.
pub fn spend(
    search: &mut Search,
    budget: Budget,
    mut told: impl FnMut(&Search, &Progress, Duration),
) -> Option<(Outcome, Progress)> {
    let begun = Instant::now();
    let spent = || begun.elapsed().as_secs_f64();
    let (most, mut pace) = match budget {
        Budget::Generations(generations) => (generations, None),
        Budget::Seconds(seconds) => (u32::MAX, Some(Pace::new(seconds))),
    };
    loop {
        let (before, times) = (begun.elapsed(), search.next_takes());
        let progress = search.step();
        let now = begun.elapsed();
        told(search, &progress, now);
        let is_late = pace.as_mut().is_some_and(|pace| {
            pace.took((now - before).as_secs_f64(), times);
            pace.is_over(now.as_secs_f64(), search)
        });
        if is_late || progress.generation >= most {
            let outcome =
                search.finish_while(|| pace.as_mut().is_none_or(|pace| pace.has_time(spent())));
            return outcome.map(|outcome| (outcome, progress));
        }
    }
}
