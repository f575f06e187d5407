//! Acknowledged broods, counted by all clients together.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Counters that clients share.
#[derive(Debug, Default)]
pub struct Tally {
    all: AtomicU64,
    refused: AtomicU64,
    window: Mutex<Window>,
}

/// Time that is measured.
#[derive(Debug, Default)]
struct Window {
    state: State,
    /// Times from request to answer in milliseconds, of broods acknowledged in the window.
    times_ms: Vec<f64>,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum State {
    /// The clients warm up.
    #[default]
    Before,
    Open,
    /// The clients end.
    Over,
}

impl Tally {
    /// Counts an acknowledged brood.
    pub fn born(&self, time: Duration) {
        self.all.fetch_add(1, Ordering::Relaxed);
        let mut window = self.window();
        if window.state == State::Open {
            window.times_ms.push(time.as_secs_f64() * 1e3);
        }
    }

    /// Counts a request that the server was too busy for.
    pub fn refused(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }

    /// Begins the measurement.
    pub fn open(&self) {
        self.window().state = State::Open;
    }

    /// Ends the measurement. Returns the times of its broods in milliseconds.
    pub fn close(&self) -> Vec<f64> {
        let mut window = self.window();
        window.state = State::Over;
        std::mem::take(&mut window.times_ms)
    }

    /// True after the measurement.
    pub fn is_over(&self) -> bool {
        self.window().state == State::Over
    }

    /// Number of all acknowledged broods, and of refused requests.
    pub fn totals(&self) -> (u64, u64) {
        (self.all.load(Ordering::Relaxed), self.refused.load(Ordering::Relaxed))
    }

    fn window(&self) -> MutexGuard<'_, Window> {
        self.window.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_broods_of_the_window_are_timed_and_all_are_counted() {
        let tally = Tally::default();
        let born = || tally.born(Duration::from_millis(3));
        born();
        tally.open();
        born();
        born();
        tally.refused();
        assert!(!tally.is_over());
        assert_eq!(tally.close(), [3.0, 3.0]);
        born();
        assert!(tally.is_over());
        assert_eq!(tally.totals(), (4, 1));
        assert!(tally.close().is_empty());
    }
}
