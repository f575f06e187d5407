//! Cancellation and progress of a running job, shared by the task of its lease and the render
//! thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tokio_util::sync::CancellationToken;

/// Steps of each camera ray: sample, evaluation, film.
const STEPS: u64 = 3;

/// Control of one job; clones share its state.
#[derive(Debug, Clone, Default)]
pub(crate) struct JobControl {
    /// Cancelled if the lease was lost.
    pub(crate) cancelled: CancellationToken,
    /// Least number of camera rays of the job.
    rays: u64,
    steps: Arc<AtomicU64>,
}

impl JobControl {
    /// Control of a job of at least this many camera rays.
    pub(crate) fn new(rays: u64) -> Self {
        Self { rays, ..Self::default() }
    }

    /// Notes that this many rays have done one more step.
    pub(crate) fn advance(&self, rays: u64) {
        self.steps.fetch_add(rays, Ordering::Relaxed);
    }

    /// Returns the share of the job that is rendered, 0 to 1. It is approximate: a job may have
    /// more rays than its least number.
    pub(crate) fn progress(&self) -> f32 {
        let all = (STEPS * self.rays).max(1) as f32;
        (self.steps.load(Ordering::Relaxed) as f32 / all).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_the_share_of_steps_at_most_1() {
        let control = JobControl::new(100);
        for (rays, progress) in [(0, 0.0), (150, 0.5), (75, 0.75), (1000, 1.0)] {
            control.clone().advance(rays);
            assert_eq!(control.progress(), progress);
        }
        assert_eq!(JobControl::default().progress(), 0.0);
    }
}
