//! Time budget of a search in seconds: decides if another generation may start, and reserves time
//! for finishing. The caller has the clock and passes elapsed seconds in.

use crate::Search;

/// Reserve for [`Search::finish`]: this share of the budget, at most this many seconds.
const KEPT: (f64, f64) = (0.3, 4.0);
/// Decay of the longest duration per generation, so that one slow generation does not end the
/// search early.
const FORGET: f64 = 0.7;

/// Time budget with estimates of how long generations and parts of finishing take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeBudget {
    seconds: f64,
    /// Longest recent duration of a generation in seconds, decayed by [`FORGET`].
    longest: f64,
    /// Start of the current part of finishing (see [`Search::finish_while`]), and the longest
    /// recent duration of a part, in seconds.
    part: Option<f64>,
    longest_part: f64,
}

impl TimeBudget {
    /// Creates an unspent budget.
    #[must_use]
    pub fn new(seconds: f64) -> Self {
        Self { seconds, longest: 0.0, part: None, longest_part: 0.0 }
    }

    /// Records that a generation took `seconds`; `times` is what [`Search::next_step_cost`]
    /// returned before it.
    pub fn took(&mut self, seconds: f64, times: f64) {
        self.longest = (seconds / times).max(FORGET * self.longest);
    }

    /// True if there is no time for another generation after `spent` seconds.
    #[must_use]
    pub fn is_over(&self, spent: f64, search: &Search) -> bool {
        self.has_passed(spent, search.finishes_quickly(), search.next_step_cost())
    }

    /// `times` is [`Search::next_step_cost`]. No time is reserved if the search `finishes_quickly`,
    /// or if `times` is above 1: the next generation then does the work that the reserve is for.
    fn has_passed(&self, spent: f64, finishes_quickly: bool, times: f64) -> bool {
        let is_kept = !finishes_quickly && times <= 1.0;
        let kept = if is_kept { (KEPT.0 * self.seconds).min(KEPT.1) } else { 0.0 };
        spent + times * self.longest > self.seconds - kept
    }

    /// True if there is time for another part of finishing after `spent` seconds. Call it before
    /// each part: it measures the parts by the time between calls.
    #[must_use]
    pub fn has_time(&mut self, spent: f64) -> bool {
        let took = self.part.map_or(0.0, |begun| spent - begun);
        self.part = Some(spent);
        self.longest_part = took.max(FORGET * self.longest_part);
        spent + self.longest_part <= self.seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generation_is_not_started_when_it_would_overrun() {
        let mut pace = TimeBudget::new(10.0);
        assert!(!pace.has_passed(0.0, false, 1.0) && !pace.has_passed(6.9, false, 1.0));
        assert!(pace.has_passed(7.5, false, 1.0) && !pace.has_passed(7.5, true, 1.0));
        pace.took(4.0, 1.0);
        assert!(pace.has_passed(6.5, true, 1.0));
        (0..3).for_each(|_| pace.took(0.1, 1.0));
        assert!(!pace.has_passed(6.5, true, 1.0), "the estimate decays");
        assert!(pace.has_passed(6.5, true, 5.0), "the next one takes 5 times as long");
        let mut pace = TimeBudget::new(10.0);
        pace.took(0.6, 1.0);
        assert!(!pace.has_passed(4.2, false, 5.0), "a finishing generation needs no reserve");
        pace.took(3.0, 5.0);
        assert!(!pace.has_passed(8.0, true, 1.0), "the estimate is divided by `times`");
    }

    #[test]
    fn part_of_finishing_is_not_started_when_it_would_overrun() {
        let mut pace = TimeBudget::new(10.0);
        assert!(pace.has_time(7.0), "no estimate yet");
        assert!(pace.has_time(8.0), "parts take one second");
        assert!(!pace.has_time(9.5));
    }

    #[test]
    fn reserve_is_capped_when_the_budget_is_long() {
        assert!(!TimeBudget::new(1000.0).has_passed(995.0, false, 1.0));
    }
}
