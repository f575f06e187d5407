//! End of the leases of workers that have died or were stopped.

use std::time::Duration;

use brood_storage::LostLeases;
use tokio::time::timeout;

use crate::dispatch::end_leases;
use crate::state::App;

/// Longest time for the end of a worker's leases. Leases that are not ended by then expire.
const REQUEUE: Duration = Duration::from_secs(5);

/// Handle that requeues the jobs of dead and stopped workers.
#[derive(Clone)]
pub struct WorkerReaper {
    app: App,
}

impl WorkerReaper {
    /// Requeues jobs of the workers of a server.
    pub(crate) fn new(app: App) -> Self {
        Self { app }
    }

    /// Requeues the jobs of a worker that has died or, if `was_stopped`, was stopped.
    pub async fn requeue_jobs_of(&self, worker: &str, was_stopped: bool) {
        // A stopping server ends all leases at once and closes the store. PostgreSQL keeps those of
        // searches and exports, which expire: `brood serve` ends its worker of searches before.
        if self.app.stopping.is_cancelled() {
            return;
        }
        let name = worker.to_owned();
        let lost =
            if was_stopped { LostLeases::OfStopped(name) } else { LostLeases::OfWorker(name) };
        if timeout(REQUEUE, end_all_leases(&self.app, lost)).await.is_err() {
            tracing::warn!(worker, "the store does not answer: leases of the worker expire");
        }
    }
}

/// Ends leases of all kinds and requeues their jobs.
pub async fn end_all_leases(app: &App, lost: LostLeases) {
    end_leases(&*app.pictures, lost.clone()).await;
    end_leases(&*app.searches, lost.clone()).await;
    end_leases(&*app.exports, lost.clone()).await;
    if let LostLeases::OfWorker(worker) | LostLeases::OfStopped(worker) = lost {
        app.workers.gone(&worker);
    }
}
