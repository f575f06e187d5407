//! How long a search goes on: so many generations, or so many seconds, with what finishing takes.

use std::time::{Duration, Instant};

use brood_search::{Outcome, Progress, Search};

/// Of a budget in seconds, what is kept for shortening what was found: this share, or so many seconds where that is less.
const KEPT: (f64, f64) = (0.3, 4.0);

/// What a search may take.
#[derive(Debug, Clone, Copy)]
pub enum Budget {
    /// So many generations: the same result on every machine.
    Generations(u32),
    /// No generation is begun that would, if it took as long as the last one, end later.
    Seconds(f64),
}

/// Goes on with the search until the budget is used up, `told` being told of each generation. Nothing where no generation found
/// anything.
pub fn spend(
    search: &mut Search,
    budget: Budget,
    mut told: impl FnMut(&Progress, Duration),
) -> Option<(Outcome, Progress)> {
    let begun = Instant::now();
    let mut last = Duration::ZERO;
    loop {
        let before = begun.elapsed();
        let progress = search.step();
        let now = begun.elapsed();
        last = last.max(now - before);
        told(&progress, now);
        let is_over = match budget {
            Budget::Generations(generations) => progress.generation >= generations,
            Budget::Seconds(seconds) => {
                let kept = if search.is_short() { 0.0 } else { (KEPT.0 * seconds).min(KEPT.1) };
                (now + last).as_secs_f64() > seconds - kept
            }
        };
        if is_over {
            let outcome = search.finish_while(|| match budget {
                Budget::Generations(_) => true,
                Budget::Seconds(seconds) => begun.elapsed().as_secs_f64() < seconds,
            });
            return outcome.map(|outcome| (outcome, progress));
        }
        // The longest of late, so that one long generation is not held against all that follow.
        last = last.mul_f64(0.7);
    }
}
