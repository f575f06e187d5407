//! Cancellation and progress of a running job, shared by the task of its lease and the render
//! thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use tokio_util::sync::CancellationToken;

/// Steps of the progress from 0 to 1.
const STEPS: f32 = 10_000.0;

/// Control of one job; clones share its state.
#[derive(Debug, Clone, Default)]
pub(crate) struct JobControl {
    /// Cancelled if the lease was lost.
    pub(crate) cancelled: CancellationToken,
    steps: Arc<AtomicU32>,
}

impl JobControl {
    /// Raises the progress to `share`, 0 to 1; a smaller share has no effect.
    pub(crate) fn note(&self, share: f32) {
        self.steps.fetch_max((share.clamp(0.0, 1.0) * STEPS) as u32, Ordering::Relaxed);
    }

    /// Returns the largest share noted.
    pub(crate) fn progress(&self) -> f32 {
        self.steps.load(Ordering::Relaxed) as f32 / STEPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_never_falls() {
        let control = JobControl::default();
        for (noted, progress) in
            [(0.0, 0.0), (0.25, 0.25), (0.1, 0.25), (f32::NAN, 0.25), (7.0, 1.0)]
        {
            control.clone().note(noted);
            assert_eq!(control.progress(), progress);
        }
    }
}
