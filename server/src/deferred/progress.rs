//! Progress of a request whose answer may be deferred, and the time that such a request may take.
//!
//! The task that handles the request finds its progress by [`AnswerProgress::current`]. Tasks and
//! threads that it starts do not inherit it: pass it to them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use brood_protocol::PictureKey;

use crate::limit;
use crate::problem::ApiError;

tokio::task_local! {
    static PROGRESS: Arc<AnswerProgress>;
}

/// Progress of a request: the parts of its answer, pictures or children, that are ready.
#[derive(Debug, Default)]
pub struct AnswerProgress {
    parts: Mutex<Parts>,
}

#[derive(Debug, Default)]
struct Parts {
    expected: usize,
    begun: usize,
    ready: usize,
    /// Pictures that are not ready.
    waiting: Vec<PictureKey>,
    /// Largest share that was reported.
    reported: f64,
}

/// Picture that a request waits for; it counts as ready when this is dropped.
pub struct Part {
    progress: Arc<AnswerProgress>,
    key: PictureKey,
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut parts = self.progress.lock();
        if let Some(at) = parts.waiting.iter().position(|key| *key == self.key) {
            parts.waiting.swap_remove(at);
        }
        parts.ready += 1;
    }
}

impl AnswerProgress {
    /// Returns the progress of the request that this task handles; `None` unless the request has
    /// `Prefer: respond-async`.
    pub fn current() -> Option<Arc<Self>> {
        PROGRESS.try_with(Arc::clone).ok()
    }

    /// Adds to the number of parts that the answer of this task will have.
    pub fn expect(parts: usize) {
        if let Some(progress) = Self::current() {
            progress.lock().expected += parts;
        }
    }

    /// Runs a future with this as its [`AnswerProgress::current`].
    pub async fn run<F: Future>(self: Arc<Self>, future: F) -> F::Output {
        PROGRESS.scope(self, future).await
    }

    /// Adds a picture that the request waits for.
    pub fn begin(self: &Arc<Self>, key: PictureKey) -> Part {
        let mut parts = self.lock();
        parts.begun += 1;
        parts.waiting.push(key);
        Part { progress: self.clone(), key }
    }

    /// Adds parts that are ready.
    pub fn step(&self, parts: usize) {
        let mut all = self.lock();
        all.begun += parts;
        all.ready += parts;
    }

    /// Returns the share of the parts that is ready, 0 to 1. It never falls. `progress_of` returns
    /// the share of a waiting picture that is rendered.
    pub fn share(&self, progress_of: impl Fn(PictureKey) -> f32) -> f64 {
        let mut parts = self.lock();
        let partly: f64 = parts.waiting.iter().map(|key| f64::from(progress_of(*key))).sum();
        let all = parts.expected.max(parts.begun);
        if all > 0 {
            let share = (parts.ready as f64 + partly) / all as f64;
            parts.reported = share.clamp(parts.reported, 1.0);
        }
        parts.reported
    }

    fn lock(&self) -> MutexGuard<'_, Parts> {
        self.parts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns the longest time that the request of this task may take.
pub fn longest_wait() -> Duration {
    if AnswerProgress::current().is_some() { limit::DEFERRED } else { limit::WAIT }
}

/// Returns the result of `work`.
///
/// # Errors
/// 503 if it takes longer than [`longest_wait`].
pub async fn in_time<T>(work: impl Future<Output = Result<T, ApiError>>) -> Result<T, ApiError> {
    let done = tokio::time::timeout(longest_wait(), work).await;
    done.map_err(|_| ApiError::not_yet("retry in a moment"))?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn share_counts_ready_parts_and_rendered_shares_of_waiting_pictures() {
        assert!(AnswerProgress::current().is_none());
        AnswerProgress::expect(7);
        assert_eq!(longest_wait(), limit::WAIT);
        let progress = Arc::new(AnswerProgress::default());
        let half = |_| 0.5;
        assert_eq!(progress.share(half), 0.0);
        let requested = async {
            AnswerProgress::expect(4);
            assert_eq!(longest_wait(), limit::DEFERRED);
            let progress = AnswerProgress::current().unwrap();
            let first = progress.begin(PictureKey([1; 32]));
            let second = progress.begin(PictureKey([2; 32]));
            assert_eq!(progress.share(half), 0.25);
            drop(first);
            assert_eq!(progress.share(half), 0.375);
            assert_eq!(progress.share(|_| 0.0), 0.375, "it never falls");
            drop(second);
            progress.step(2);
        };
        progress.clone().run(requested).await;
        assert_eq!(progress.share(half), 1.0);
        progress.step(1);
        assert_eq!(progress.share(half), 1.0, "more parts than expected");
    }
}
