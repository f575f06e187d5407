//! How seconds are spent: no generation is begun that there is no time for, and something is kept for finishing. Whose seconds
//! they are is the caller's business: it has the clock.

use crate::Search;

/// Of the seconds, what is kept for shortening what was found: this share, or so many seconds where that is less.
const KEPT: (f64, f64) = (0.3, 4.0);
/// How soon a long generation is forgotten, so that it is not held against all that follow.
const FORGET: f64 = 0.7;

/// A budget of seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    seconds: f64,
    /// The longest generation of late.
    longest: f64,
    /// When the part of finishing began that is under way, and the longest of late.
    part: Option<f64>,
    longest_part: f64,
}

impl Pace {
    /// Nothing of so many seconds is spent.
    #[must_use]
    pub fn new(seconds: f64) -> Self {
        Self { seconds, longest: 0.0, part: None, longest_part: 0.0 }
    }

    /// A generation took so many seconds, of which was said before that it takes so many `times` as long as others.
    pub fn took(&mut self, seconds: f64, times: f64) {
        self.longest = (seconds / times).max(FORGET * self.longest);
    }

    /// Whether there is no time for another generation of the search after so many seconds.
    #[must_use]
    pub fn is_over(&self, spent: f64, search: &Search) -> bool {
        self.has_passed(spent, search.is_short(), search.next_takes())
    }

    /// Of a search whose end `is_short` nothing is kept for it. The next generation takes so many `times` as long as the ones before;
    /// where that is more than once, it does what would be done at the end.
    fn has_passed(&self, spent: f64, is_short: bool, times: f64) -> bool {
        let is_kept = !is_short && times <= 1.0;
        let kept = if is_kept { (KEPT.0 * self.seconds).min(KEPT.1) } else { 0.0 };
        spent + times * self.longest > self.seconds - kept
    }

    /// Whether there is time for a part of finishing, after so many seconds; asked before each of them.
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
    fn no_generation_is_begun_that_there_is_no_time_for() {
        let mut pace = Pace::new(10.0);
        assert!(!pace.has_passed(0.0, false, 1.0) && !pace.has_passed(6.9, false, 1.0));
        assert!(pace.has_passed(7.5, false, 1.0) && !pace.has_passed(7.5, true, 1.0));
        pace.took(4.0, 1.0);
        assert!(pace.has_passed(6.5, true, 1.0));
        (0..3).for_each(|_| pace.took(0.1, 1.0));
        assert!(!pace.has_passed(6.5, true, 1.0), "a long one is forgotten");
        assert!(pace.has_passed(6.5, true, 5.0), "but the next one is longer");
        let mut pace = Pace::new(10.0);
        pace.took(0.6, 1.0);
        assert!(!pace.has_passed(4.2, false, 5.0), "and the end with it");
        pace.took(3.0, 5.0);
        assert!(!pace.has_passed(8.0, true, 1.0), "those after it are not as long");
    }

    #[test]
    fn no_part_of_finishing_is_begun_that_there_is_no_time_for() {
        let mut pace = Pace::new(10.0);
        assert!(pace.has_time(7.0), "nothing is known yet");
        assert!(pace.has_time(8.0), "parts take a second");
        assert!(!pace.has_time(9.5));
    }

    #[test]
    fn of_many_seconds_only_some_are_kept() {
        assert!(!Pace::new(1000.0).has_passed(995.0, false, 1.0));
    }
}
