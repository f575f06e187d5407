//! How long to wait before asking a server again that did not answer: bounded, doubling, jittered.
//!
//! It refuses to know what failed. The jitter is not reproducible on purpose: workers that lost one server together
//! must not come back together.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

const FIRST: Duration = Duration::from_millis(100);
const LONGEST: Duration = Duration::from_secs(5);

/// Waits that grow until something succeeds.
#[derive(Debug, Default)]
pub(crate) struct Backoff {
    failures: u32,
}

impl Backoff {
    /// Something succeeded.
    pub(crate) fn reset(&mut self) {
        self.failures = 0;
    }

    /// Failures since the last success.
    pub(crate) fn failures(&self) -> u32 {
        self.failures
    }

    /// The wait after one more failure: between half and all of the bound, which doubles up to 5 s.
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
    fn waits_grow_up_to_the_bound_when_failures_go_on() {
        let mut backoff = Backoff::default();
        let mut bound = FIRST;
        for _ in 0..40 {
            let wait = backoff.next();
            assert!(wait >= bound / 2 && wait <= bound, "{wait:?} of {bound:?}");
            bound = (bound * 2).min(LONGEST);
        }
        assert_eq!(backoff.failures(), 40);
        backoff.reset();
        assert_eq!(backoff.failures(), 0);
        assert!(backoff.next() <= FIRST);
    }
}
