//! Exponential back-off with jitter for calls to a server.
//!
//! The jitter is random on purpose and not reproducible: workers that lost the same server at the
//! same time must not all return at the same time.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

const FIRST: Duration = Duration::from_millis(100);
const LONGEST: Duration = Duration::from_secs(5);

/// Delay that doubles with every consecutive failure.
#[derive(Debug, Default)]
pub(crate) struct Backoff {
    failures: u32,
}

impl Backoff {
    /// Resets the delay after a success.
    pub(crate) fn reset(&mut self) {
        self.failures = 0;
    }

    /// Returns the number of failures since the last success.
    pub(crate) fn failures(&self) -> u32 {
        self.failures
    }

    /// Counts one more failure and returns the delay before the next attempt: between half and all
    /// of a bound that doubles from 100 ms to 5 s.
    pub(crate) fn next(&mut self) -> Duration {
        let bound = FIRST.saturating_mul(1 << self.failures.min(10)).min(LONGEST);
        self.failures = self.failures.saturating_add(1);
        let random = RandomState::new().build_hasher().finish() % 1024;
        bound / 2 + bound * u32::try_from(random).expect("below 1024") / 2048
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delay_doubles_up_to_limit_when_failures_repeat() {
        let mut backoff = Backoff::default();
        let mut bound = FIRST;
        for _ in 0..40 {
            let wait = backoff.next();
            assert!(wait >= bound / 2 && wait <= bound, "{wait:?}, bound {bound:?}");
            bound = (bound * 2).min(LONGEST);
        }
        assert_eq!(backoff.failures(), 40);
        backoff.reset();
        assert_eq!(backoff.failures(), 0);
        assert!(backoff.next() <= FIRST);
    }
}
